"""What trial samples teach, and which samples to cut next: ``python learn_from_trials.py FOLDER``."""

# %% A calibration with a trial: what was predicted of it by what was known without it.
from __future__ import annotations

import sys
from pathlib import Path

import slipgrid

folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
folder.mkdir(parents=True, exist_ok=True)
ROOT = Path(__file__).resolve().parents[3]
calibration = slipgrid.Calibration.read(ROOT / "calibration" / "synthetic-polymer" / "calibration.toml")
ledger = calibration.trials()
for trial in ledger.trials:
    for row in trial.measured:
        low, high = row.without_trial.interval_95
        print(f"{trial.name}, {row.pressure_mpa:.2f} MPa: measured {row.measured:.3f}, predicted {low:.3f} to {high:.3f}")

# %% The two samples to cut next, for a target.
design = slipgrid.Design(
    name="after one trial",
    material=calibration,
    condition={"speed_mm_s": 5.0, "humidity_pct": 50.0},
    target={"quantity": "ratio", "pressure_mpa": [0.75, 2.8], "value": 0.92, "tolerance": 0.04},
    bounds={"width_um": [60, 200], "spacing_um": [100, 400], "depth_um": 20},
    specimen={"shape": "disc", "diameter_mm": 3},
    sample={"layer_um": 100, "block_um": 20},
)
chosen = design.next(2)
for sample in chosen.samples:
    print(f"{sample.design.width_um}/{sample.design.spacing_um}/{sample.design.depth_um} um, chance {sample.chance}")

# %% A picture.
import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot

figure, ax = pyplot.subplots(figsize=(5, 4), layout="constrained")
ledger.plot(ax)
figure.savefig(folder / "learn-from-trials.png", dpi=80)
