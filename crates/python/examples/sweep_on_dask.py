"""A sweep of scenes on a Dask cluster, here of two processes: ``python sweep_on_dask.py FOLDER``."""

from __future__ import annotations

import sys
from pathlib import Path

from slipgrid import campaign

# %% A campaign: a scene, and the keys that vary.
SCENE = """
[material]
youngs_modulus_gpa = 0.38
density_g_cm3 = 0.9
friction = { static_mean = 0.30, dynamic_mean = 0.27 }
area_law = { pressure_mpa = [0.7, 1.3, 2.6, 10.0], factor = [1.0, 0.9, 0.7, 0.3] }
[pattern]
planform = "groove"
width_um = 100.0
spacing_um = 200.0
depth_um = 10.0
[sample]
layer_um = 100.0
[load]
pressure_mpa = [0.65, 2.6]
speed_mm_s = 2.0
[run]
fidelity = "steady"
extent = "cell"
"""
SWEEP = """
base = "scene.toml"
[[grid]]
key = "pattern.width_um"
values = [40.0, 80.0, 120.0, 160.0]
[[grid]]
key = "pattern.spacing_um"
values = [100.0, 200.0, 300.0]
"""


def main(folder: Path) -> None:
    from dask.distributed import Client, LocalCluster

    folder.mkdir(parents=True, exist_ok=True)
    (folder / "scene.toml").write_text(SCENE)
    (folder / "sweep.toml").write_text(SWEEP)
    tasks = campaign.plan(folder / "sweep.toml")

    # %% On a cluster of yours: Client("scheduler:8786").
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        found = campaign.run(tasks, client)
    print(found.counts)
    (folder / "sweep.csv").write_text(found.csv)

    # %% A picture.
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    table = found.frame()
    figure, ax = pyplot.subplots(figsize=(5, 3.5), layout="constrained")
    for spacing_um, rows in table[table["pressure_mpa"] == 2.6].groupby("pattern.spacing_um"):
        ax.plot(rows["pattern.width_um"], rows["ratio"], "o-", label=f"{spacing_um:g} µm apart")
    ax.set(xlabel="width in µm", ylabel="friction, textured over flat, at 2.6 MPa")
    ax.legend()
    figure.savefig(folder / "sweep-on-dask.png", dpi=80)


# Dask starts processes that import this file.
if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "out"))
