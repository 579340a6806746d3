"""Functional and spatial parameters of sums of waves that anyone can compute again, by surfalize 0.17.1.

Each surface is a sum of cosines (amplitude, waves along the lines' order, waves along a line, phase) on 96 lines of 120
points, 0.75 um and 0.5 um apart, some of it cut off or dug into; tests/validation_functional.rs makes the same. Run in
this folder:

    pip install surfalize==0.17.1
    python waves.py
"""

import json
import warnings

import numpy as np
from surfalize import Surface

warnings.simplefilter("ignore")
LINES, POINTS, STEP_LINE_UM, STEP_POINT_UM = 96, 120, 0.75, 0.5


def waves(count, most_line, most_point):
    """Waves drawn by a congruential generator; amplitudes fall with their number."""
    state, drawn = 12345, []
    for n in range(count):
        draws = []
        for _ in range(3):
            state = (1103515245 * state + 12345) % 2**31
            draws.append(state / 2**31)
        along_lines = int(draws[0] * (2 * most_line + 1)) - most_line
        along_points = 1 + int(draws[1] * most_point)
        drawn.append((1.0 / (1.0 + 0.2 * n), along_lines, along_points, 2 * np.pi * draws[2]))
    return drawn


def surface(drawn):
    i, j = np.meshgrid(np.arange(LINES), np.arange(POINTS), indexing="ij")
    return sum(
        a * np.cos(2 * np.pi * (k * i / LINES + l * j / POINTS) + phase) for a, k, l, phase in drawn
    )


oblique = [(1.0, 3, 4, 0.3), (0.6, -2, 9, 1.1), (0.5, 7, 2, 2.0), (0.45, 1, 1, 0.7)]
surfaces = {
    "isotropic": surface(waves(40, 12, 10)),
    "along": surface(waves(40, 2, 20)),
    "plateau": np.minimum(surface(waves(40, 12, 10)), 0.5),
    "oblique": surface(oblique),
}
groove = surface(waves(40, 12, 10))
groove[:, 30:38] -= 9.0
surfaces["grooved"] = groove

names = "Sk Spk Svk Smr1 Smr2 Sal Str".split()
found = {}
for name, height_um in surfaces.items():
    height_um = height_um - height_um.mean()
    measured = Surface(height_um, STEP_POINT_UM, STEP_LINE_UM)
    found[name] = {parameter: float(getattr(measured, parameter)()) for parameter in names}
    found[name]["Sq"] = float(measured.Sq())
with open("waves.json", "w") as file:
    json.dump(found, file, indent=1)
