"""From an altitude map to the area law and to friction of many textures: ``python map_to_area_law.py FOLDER``."""

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

# %% Rough contact of the map says how real contact saturates with pressure.
law = surface.area_law(youngs_modulus_gpa=0.38)
print(law)

# %% A material with this law, and friction of a thousand grooves at three pressures.
material: slipgrid.types.MaterialTable = {
    "youngs_modulus_gpa": 0.38,
    "density_g_cm3": 0.9,
    "friction": {"static_mean": 0.30, "dynamic_mean": 0.27, "relative_std": 0.05},
    "area_law": law,
}
cell = slipgrid.Scene(
    material=material,
    pattern={"planform": "groove", "width_um": 100, "spacing_um": 200, "depth_um": 10},
    sample={"layer_um": 100, "block_um": 10},
    load={"pressure_mpa": [0.7, 1.3, 2.6], "speed_mm_s": 2.0},
).steady()
widths_um, spacings_um = np.linspace(40.0, 200.0, 33), np.linspace(100.0, 400.0, 31)
ratio = cell.ratio(widths_um[:, None], spacings_um, 10.0)
print("ratio", ratio.shape, "from", ratio.min().round(3), "to", ratio.max().round(3))

# %% Pictures.
import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot

figure, axes = pyplot.subplots(1, 3, figsize=(12, 3.5), layout="constrained")
surface.plot(axes[0])
law.plot(axes[1])
contours = axes[2].contourf(spacings_um, widths_um, ratio[:, :, 2])
figure.colorbar(contours, ax=axes[2], label="friction, textured over flat, at 2.6 MPa")
axes[2].set(xlabel="spacing in µm", ylabel="width in µm")
figure.savefig(folder / "map-to-area-law.png", dpi=80)
