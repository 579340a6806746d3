#!/usr/bin/env python3
"""The rough-contact solver beside Tamaas: same map, pressures, tolerance and machine, one thread each.

Needs Tamaas (PyPI: pip install tamaas) and the built program:

    cargo build --release
    python crates/surface/benches/against_tamaas.py --pixels 512
    python crates/surface/benches/against_tamaas.py --pixels 1024 --pressures-mpa 0.2,1,2.6

`slipgrid synthesize` writes the map. Seconds are processor seconds of the solves alone on either side; those of the whole
program `slipgrid area-law`, with the reading of the map, stand below. Iterations of the two are not alike: one of
Tamaas applies the operator twice (gap and step), ours once, beside a preconditioner on two grids.
"""

import os
import sys
import time

os.environ["OMP_NUM_THREADS"] = "1"

import tamaas

import peers


def by_tamaas(heights, pressures_mpa, tolerance, max_iterations):
    """Area, corrected area, iterations and processor seconds of each pressure, from a uniform start."""
    tamaas.initialize(1)
    tamaas.set_log_level(tamaas.LogLevel.error)
    rows = []
    for pressure_mpa in pressures_mpa:
        model = tamaas.Model(tamaas.model_type.basic_2d, [peers.SIDE_M, peers.SIDE_M], list(heights.shape))
        model.E, model.nu = peers.YOUNGS_MODULUS_PA, peers.POISSON_RATIO
        solver = tamaas.PolonskyKeerRey(model, heights, tolerance)
        solver.max_iter = max_iterations
        iterations = Iterations()
        solver.addFunctionalTerm(iterations)
        start = time.process_time()
        error = solver.solve(pressure_mpa * 1e6)
        seconds = time.process_time() - start
        if error > tolerance:
            sys.exit(f"Tamaas ended at {error} at {pressure_mpa} MPa: raise --max-iterations")
        contact = model.traction > 0
        rows.append((contact.mean(), peers.corrected_area(contact), iterations.count, seconds))
    return rows


class Iterations(tamaas.Functional):
    """A functional of no energy: one gradient is asked for in each iteration."""

    count = 0

    def computeF(self, primal, dual):
        return 0.0

    def computeGradF(self, primal, gradient):
        self.count += 1


def main():
    given = peers.arguments(__doc__)
    heights, report, whole, reading = peers.by_slipgrid(given)
    pressures_mpa = [float(pressure) for pressure in given.pressures_mpa.split(",")]
    theirs = by_tamaas(heights, pressures_mpa, given.tolerance, given.max_iterations)
    print(peers.heading(given, f"Tamaas {tamaas.TamaasInfo.version}", report))
    peers.compare("Tamaas", theirs, report, whole, reading)


if __name__ == "__main__":
    main()
