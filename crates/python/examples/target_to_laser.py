"""From a target of friction to the files of a laser: ``python target_to_laser.py FOLDER``."""

# %% A design: grooves that take a tenth of dry friction away at 2.6 MPa.
from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import slipgrid

folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
folder.mkdir(parents=True, exist_ok=True)
design = slipgrid.Design(
    name="a tenth less",
    material={
        "youngs_modulus_gpa": 0.38,
        "density_g_cm3": 0.9,
        "friction": {"static_mean": 0.30, "dynamic_mean": 0.27, "relative_std": 0.05},
        "area_law": {"pressure_mpa": [0.7, 1.3, 2.6, 10.0], "factor": [1.0, 0.9, 0.7, 0.3]},
    },
    target={"quantity": "ratio", "pressure_mpa": 2.6, "value": 0.9, "tolerance": 0.05},
    bounds={"width_um": [40, 200], "spacing_um": [100, 400], "depth_um": [5, 40]},
    pattern={"planform": "groove"},
    specimen={"shape": "disc", "diameter_mm": 2},
    sample={"layer_um": 100, "block_um": 10},
)

# %% Before the search: what is expected of any groove, with the chance that a cut sample is on target.
widths_um, spacings_um = np.linspace(40.0, 200.0, 65), np.linspace(100.0, 400.0, 61)
predicted = design.predict(widths_um[:, None], spacings_um, 10.0)
print(predicted, "chance up to", predicted.chance.max().round(2))

# %% The search, confirmed in time.
found = design.optimize()
print(found.headline)
print(f"{found.design.width_um} um wide, {found.design.spacing_um} um apart, {found.design.depth_um} um deep")

# %% Files for the laser, and the page.
found.export(folder)

# %% A picture.
import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot

figure, axes = pyplot.subplots(1, 2, figsize=(9, 3.5), layout="constrained")
chances = axes[0].contourf(spacings_um, widths_um, predicted.chance)
figure.colorbar(chances, ax=axes[0], label="chance on target, 10 µm deep")
axes[0].set(xlabel="spacing in µm", ylabel="width in µm")
found.plot(axes[1])
figure.savefig(folder / "target-to-laser.png", dpi=80)
