#!/usr/bin/env python3
"""The rough-contact solver beside ASPHER: same map, pressures, tolerance and machine, one thread each.

Needs ASPHER (PyPI: pip install aspher, which compiles it and needs cmake and Eigen) and the built program:

    cargo build --release
    python crates/surface/benches/against_aspher.py --pixels 1024

Its periodic operator, with each of its settings that may be the fastest: on one grid or on nested ones, in double precision or first
in single. The one that is fastest over all pressures is compared. Seconds are processor seconds of the solves alone on either side;
those of the whole program `slipgrid area-law`, with the reading of the map, stand below.
"""

import os
import sys
import time
from importlib.metadata import version

os.environ["OMP_NUM_THREADS"] = "1"

import aspher
import numpy

import peers

SETTINGS = {
    "one grid": {"nested": False},
    "nested": {"nested": True},
    "one grid, single then double": {"nested": False, "precision": "float_then_double"},
    "nested, single then double": {"nested": True, "precision": "float_then_double"},
}


def coarsest(pixels):
    """Side of the coarsest of the nested grids, each half the one before, not below 64 pixels; the side itself if it is odd."""
    while pixels % 2 == 0 and pixels >= 128:
        pixels //= 2
    return pixels


def by_aspher(heights, given, nested, precision="double"):
    """Area, corrected area, iterations on the finest grid and processor seconds of each pressure, from a uniform start."""
    pixels = heights.shape[0]
    gap = heights.max() - heights
    contact_modulus_pa = peers.YOUNGS_MODULUS_PA / (1 - peers.POISSON_RATIO**2)
    rows = []
    for pressure_mpa in given.pressures_mpa.split(","):
        start = time.process_time()
        found = aspher.solve_nested(
            pixels, gap, float(pressure_mpa) * 1e6, domain_size=peers.SIDE_M, E_star=contact_modulus_pa,
            coarsest=coarsest(pixels) if nested else pixels, backend="periodic", precision=precision,
            tol=given.tolerance, max_iter=given.max_iterations,
        )
        seconds = time.process_time() - start
        if not found.converged:
            sys.exit(f"ASPHER ended as {found.status} at {pressure_mpa} MPa: {found.status_reason}")
        contact = numpy.asarray(found.pressure).reshape(heights.shape) > 0
        rows.append((contact.mean(), peers.corrected_area(contact), found.iterations, seconds))
    return rows


def main():
    given = peers.arguments(__doc__)
    heights, report, whole, reading = peers.by_slipgrid(given)
    print(peers.heading(given, f"ASPHER {version('aspher')}", report))
    by_setting = {}
    for name, setting in SETTINGS.items():
        by_setting[name] = by_aspher(heights, given, **setting)
        print(f"ASPHER, {name}: {sum(row[3] for row in by_setting[name]):.2f} s")
    best = min(by_setting, key=lambda name: sum(row[3] for row in by_setting[name]))
    print(f"ASPHER's fastest setting: {best}")
    peers.compare("ASPHER", by_setting[best], report, whole, reading)


if __name__ == "__main__":
    main()
