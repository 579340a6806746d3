"""Sample files of every format and what independent programs read from them.

Written by surfalize 0.19.2, SurfaceTopography 1.27.1, gsffile and NumPy, texts as their headers are documented; read back by the package that did
not write them where two can, and described in readings.json. The ISO 25178 parameters of iso.npy are
surfalize's, its power spectrum SurfaceTopography's (iso.json). Run in this folder:

    pip install surfalize==0.19.2 SurfaceTopography==1.27.1 gsffile
    python make.py
"""

import json
import warnings

import gsffile
import numpy as np
import surfalize
import SurfaceTopography
from surfalize import Surface
from SurfaceTopography import Topography

warnings.simplefilter("ignore")

# 17 lines of 24 points, 1.5 um apart, lines 2.5 um apart; some points missing.
STEP_X_UM, STEP_Y_UM = 1.5, 2.5
lines, points = np.meshgrid(np.arange(17), np.arange(24), indexing="ij")
height_um = 0.8 * np.sin(0.31 * points) + 0.3 * np.cos(0.83 * lines) + 0.011 * points * lines - 1.7
holed_um = height_um.copy()
holed_um[3, 5] = holed_um[9, 20:23] = holed_um[16, 0] = np.nan


def described(height_um, step_x_um, step_y_um):
    """Numbers that pin a map: line by line, x along a line."""
    present = height_um[np.isfinite(height_um)]
    return {
        "lines": height_um.shape[0],
        "points": height_um.shape[1],
        "step_x_um": float(step_x_um),
        "step_y_um": float(step_y_um),
        "missing": int(np.isnan(height_um).sum()),
        "sum_um": float(present.sum()),
        "least_um": float(present.min()),
        "greatest_um": float(present.max()),
        "third_line_um": [None if np.isnan(h) else float(h) for h in height_um[3, :8]],
    }


def by_surfalize(path):
    surface = Surface.load(path)
    return described(np.asarray(surface.data), surface.step_x, surface.step_y)


def by_surface_topography(path):
    topography = SurfaceTopography.read_topography(path).to_unit("um")
    heights = np.ma.filled(topography.heights().astype(float), np.nan).T
    return described(heights, *topography.pixel_size)


readings = {}
surface = Surface(holed_um, STEP_X_UM, STEP_Y_UM)
surface.save("surfalize-binary.sdf", binary=True)
surface.save("surfalize-text.sdf", binary=False)
surface.save("surfalize-utf8.sur")
surface.save("surfalize-latin1.sur", encoding="latin-1")
surface.save("surfalize-compressed.sur", compressed=True, comment="three words here")
surface.save("surfalize.x3p")
topography = Topography(
    np.ma.masked_invalid(holed_um.T), (24 * STEP_X_UM, 17 * STEP_Y_UM), unit="um", info={}
)
for kind in "ILFD":
    topography.to_x3p(f"surface-topography-{kind}.x3p", dtype=kind)
gsffile.write_gsf(
    "gsffile.gsf",
    (holed_um * 1e-6).astype(np.float32),
    {"XReal": 24 * STEP_X_UM * 1e-6, "YReal": 17 * STEP_Y_UM * 1e-6, "XYUnits": "m", "ZUnits": "m"},
)
np.save("numpy-f4.npy", holed_um.astype("<f4"))
np.save("numpy-fortran.npy", np.asfortranarray(holed_um.astype(">f8")))


# Texts as Gwyddion and SPIP head them (nanometres in SPIP's), and points in no order, x across the lines.
def lines_of(heights, missing):
    return "".join("\t".join(missing if np.isnan(h) else f"{h:.9f}" for h in line) + "\n" for line in heights)


with open("gwyddion.asc", "w") as file:
    file.write("# Channel: Height\n# Width: 36 \u00b5m\n# Height: 42.5 \u00b5m\n# Value units: nm\n")
    file.write(lines_of(holed_um * 1e3, "nan"))
with open("spip.asc", "w", newline="\r\n") as file:
    file.write("# File Format = ASCII\n# Created by SPIP 6.7.3 2017-05-04 11:22\n# Original file: flat 3.bcr\n")
    file.write("# x-pixels = 24\n# y-pixels = 17\n# x-length = 36000\n# y-length = 42500\n# x-offset = 0\n")
    file.write("# y-offset = 0\n# Bit2nm = 0.25\n# Start of Data:\n")
    file.write(lines_of(holed_um * 4e3, "nan"))
order = np.random.default_rng(3).permutation(17 * 24)
with open("points.xyz", "w") as file:
    for line, point in zip(*np.divmod(order, 24)):
        file.write(f"{line * STEP_Y_UM:.4f} {point * STEP_X_UM:.4f} {height_um[line, point]:.9f}\n")

# The reader that did not write the file, where there are two.
for path in ["surfalize-latin1.sur", "surfalize.x3p"]:
    readings[path] = by_surface_topography(path)
# SurfaceTopography leaves the z offset of a .sur file out.
readings["surfalize-latin1.sur"]["without_offset"] = True
# SurfaceTopography knows no mark for missing doubles, and no compressed surface.
for path in ["surfalize-binary.sdf", "surfalize-text.sdf", "surfalize-utf8.sur", "surfalize-compressed.sur"]:
    readings[path] = by_surfalize(path)
for kind in "ILFD":
    readings[f"surface-topography-{kind}.x3p"] = by_surface_topography(f"surface-topography-{kind}.x3p")
for path in ["gwyddion.asc", "spip.asc"]:
    readings[path] = by_surface_topography(path)
# Grids of points are complete there.
points = SurfaceTopography.read_topography("points.xyz", format="xyz", unit="um")
readings["points.xyz"] = described(points.heights(), points.pixel_size[1], points.pixel_size[0])
data, _ = gsffile.read_gsf("gsffile.gsf")
readings["gsffile.gsf"] = described(data.astype(float) * 1e6, STEP_X_UM, STEP_Y_UM)
for path in ["numpy-f4.npy", "numpy-fortran.npy"]:
    readings[path] = described(np.load(path).astype(float), STEP_X_UM, STEP_Y_UM)
with open("readings.json", "w") as file:
    json.dump(readings, file, indent=1)

# A rough map that is not periodic, for the parameters: correlated noise with few deep scratches.
generator = np.random.default_rng(25178)
noise = generator.standard_normal((96 + 40, 120 + 40))
window = np.exp(-0.5 * (np.arange(-20, 21)[:, None] / 5.0) ** 2 - 0.5 * (np.arange(-20, 21)[None, :] / 3.0) ** 2)
rough = sum(
    window[i, j] * noise[i : i + 96, j : j + 120] for i in range(41) for j in range(41)
)
rough = 0.2 * rough / rough.std()
rough[:, 40:42] -= 0.8
rough[50:53, :] -= 0.5
rough = (rough - rough.mean()).astype("<f4")
np.save("iso.npy", rough)
surface = Surface(rough.astype(float), 0.5, 0.75)
names = "Sa Sq Ssk Sku Sp Sv Sz Sdq Sdr Sal Str Sk Spk Svk Smr1 Smr2".split()
iso = {name: float(getattr(surface, name)()) for name in names}
# surfalize sums the areas beyond the core up to the nearest of its 10000 classes and leaves the last one out; the
# mean of what exceeds its line is the whole area.
curve = surface.get_abbott_firestone_curve()
above, below = rough.astype(float) - curve._yupper, curve._ylower - rough.astype(float)
iso["Spk whole"] = float(2 * np.maximum(above, 0).mean() / (above > 0).mean())
iso["Svk whole"] = float(2 * np.maximum(below, 0).mean() / (below > 0).mean())

# Radial spectra in um^4 against rad/um, as one period without window and with the Hann window, on given bins.
periodic = Topography(rough.astype(float).T, (120 * 0.5, 96 * 0.75), unit="um", periodic=True)
edges = np.geomspace(0.1, 4.0, 13)
spectra = {}
for name, window_name in [("none", "None"), ("hann", "hann")]:
    q, c = periodic.power_spectrum_from_area(
        window=None if window_name == "None" else window_name, collocation=edges, reliable=False
    )
    spectra[name] = [None if np.ma.is_masked(v) or not np.isfinite(v) else float(v) for v in c]
iso["edges_per_um"] = [float(edge) for edge in edges]
iso["spectrum_um4"] = spectra
with open("iso.json", "w") as file:
    json.dump(iso, file, indent=1)
