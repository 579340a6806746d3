"""From raw exports of a tribometer to a material with its errors: ``python traces_to_material.py FOLDER``."""

# %% A calibration names the traces of flat samples, and says which condition each was measured at.
from __future__ import annotations

import sys
from pathlib import Path

import slipgrid

folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
folder.mkdir(parents=True, exist_ok=True)
ROOT = Path(__file__).resolve().parents[3]
calibration = slipgrid.Calibration.read(ROOT / "calibration" / "synthetic-polymer" / "calibration.toml")

# %% Local coefficients and the area law's scale, fitted to the flat samples.
material = calibration.fit()
for parameter in material.fit.parameters:
    low, high = parameter.interval_95
    print(f"{parameter.name}: {parameter.value:.4g}, 95 % {low:.4g} to {high:.4g}")
print(*material.warnings, sep="\n")

# %% The file, and friction of grooves of any width by the model alone.
material.save(folder / "material.toml")
condition: slipgrid.types.ConditionTable = {"speed_mm_s": 5.0, "humidity_pct": 50.0}
widths_um = [40.0, 80.0, 120.0, 160.0]
print(material.ratio(widths_um, 300.0, 20.0, 1.0, condition=condition).round(4))

# %% A picture.
import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot

figure, ax = pyplot.subplots(figsize=(6, 3), layout="constrained")
material.plot(ax)
figure.savefig(folder / "traces-to-material.png", dpi=80)
