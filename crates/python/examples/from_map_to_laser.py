"""From an altitude map to the files of a laser: the cells of a notebook.

Run as it stands: ``python from_map_to_laser.py FOLDER``. With matplotlib it draws as well.
"""

# %% A map: here a synthetic one; yours comes from a profilometer, slipgrid.Map.read("sample.sur").
from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import slipgrid

folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
folder.mkdir(parents=True, exist_ok=True)
random = np.random.default_rng(1)
waves = np.fft.rfft2(random.standard_normal((64, 64)))
wavenumber = np.hypot(np.fft.fftfreq(64)[:, None], np.fft.rfftfreq(64)[None, :])
waves[wavenumber > 0.25] = 0.0
waves[0, 0] = 0.0
heights = np.fft.irfft2(waves / np.maximum(wavenumber, 1.0 / 64.0) ** 1.8, s=(64, 64))
surface = slipgrid.Map(0.15e-6 * heights / heights.std(), pixel_um=1.0)
print(surface, "rms slope", round(surface.measure().parameters.rms_slope, 4))

# %% How real contact saturates with pressure, by rough contact of the map.
law = surface.area_law(youngs_modulus_gpa=0.38)
print(law.frame().tail(3))

# %% A design: grooves that take a fifth of dry friction away at 2.6 MPa.
keep = law.pressure_mpa >= 0.7
material = {
    "youngs_modulus_gpa": 0.38,
    "density_g_cm3": 0.9,
    "friction": {"static_mean": 0.30, "dynamic_mean": 0.27, "relative_std": 0.05},
    "area_law": {"pressure_mpa": law.pressure_mpa[keep], "factor": law.factor[keep] / law.factor[keep][0]},
}
design = slipgrid.Design(
    name="from a map",
    material=material,
    target={"quantity": "ratio", "pressure_mpa": 2.6, "value": 0.9, "tolerance": 0.05},
    bounds={"width_um": [40, 200], "spacing_um": [100, 400], "depth_um": [5, 40]},
    pattern={"planform": "groove"},
    specimen={"shape": "disc", "diameter_mm": 2},
    sample={"layer_um": 100, "block_um": 10},
)
found = design.optimize()
print(found.headline)
print(found.frame())

# %% What a micrometre more or less does: a steady cell, asked a thousand times.
cell = slipgrid.Scene(
    material=material,
    pattern={"planform": "groove", "width_um": 100, "spacing_um": 200, "depth_um": 10},
    sample={"length_um": 2000, "layer_um": 100, "block_um": 10},
    load={"pressure_mpa": [2.6], "speed_mm_s": 2.0},
).steady()
best = found.design
widths_um = np.linspace(40.0, 200.0, 81)
others = np.full_like(widths_um, best.spacing_um), np.full_like(widths_um, best.depth_um)
ratios = cell.ratios_of(np.column_stack([widths_um, *others]))[:, 0]

# %% Files for the laser, the page, and a picture.
found.export(folder)
try:
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot
except ImportError:
    print("no matplotlib: no picture")
else:
    figure, axes = pyplot.subplots(figsize=(5, 3), layout="constrained")
    axes.plot(widths_um, ratios)
    axes.axhspan(0.85, 0.95, alpha=0.2)
    axes.plot([best.width_um], [found.modelled[0].ratio], "o")
    axes.set(xlabel="width in µm", ylabel="friction, textured over flat, at 2.6 MPa")
    figure.savefig(folder / "width.png", dpi=100)
print("wrote", folder)
