#!/usr/bin/env python3
"""The rough-contact solver beside Tamaas: same map, pressures, tolerance and machine, one thread each.

Needs Tamaas (PyPI: pip install tamaas) and the built program:

    cargo build --release
    python crates/contact/benches/against_tamaas.py --pixels 512
    python crates/contact/benches/against_tamaas.py --pixels 1024 --pressures-mpa 0.2,1,2.6

`slipgrid synthesize` writes the map. Seconds are processor seconds of the solves alone on either side; those of the whole
program `slipgrid area-law`, with the reading of the map, stand below. Iterations of the two are not alike: one of
Tamaas applies the operator twice (gap and step), ours two to three times, one of them the preconditioner.
"""

import argparse
import json
import os
import platform
import resource
import subprocess
import sys
import tempfile
import time

os.environ["OMP_NUM_THREADS"] = "1"

import numpy
import tamaas

YOUNGS_MODULUS_PA = 0.38e9
POISSON_RATIO = 1.0 / 3.0
SIDE_M = 1e-3
SWEEP_MPA = "0.1,0.2,0.4,0.7,1,1.3,1.6,2,2.6,3.3,4.1,5"


def corrected_area(contact):
    """Yastrebov's perimeter correction on square pixels."""
    edges = sum(int((contact != numpy.roll(contact, 1, axis)).sum()) for axis in (0, 1))
    return contact.mean() - (numpy.pi - 1 + numpy.log(2)) / 24 * edges / contact.size


def by_tamaas(heights, pressures_mpa, tolerance, max_iterations):
    """Area, corrected area, iterations and processor seconds of each pressure, from a uniform start."""
    tamaas.initialize(1)
    tamaas.set_log_level(tamaas.LogLevel.error)
    rows = []
    for pressure_mpa in pressures_mpa:
        model = tamaas.Model(tamaas.model_type.basic_2d, [SIDE_M, SIDE_M], list(heights.shape))
        model.E, model.nu = YOUNGS_MODULUS_PA, POISSON_RATIO
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
        rows.append((contact.mean(), corrected_area(contact), iterations.count, seconds))
    return rows


class Iterations(tamaas.Functional):
    """A functional of no energy: one gradient is asked for in each iteration."""

    count = 0

    def computeF(self, primal, dual):
        return 0.0

    def computeGradF(self, primal, gradient):
        self.count += 1


def by_slipgrid(program, path, pressures_mpa, tolerance):
    """The report of `slipgrid area-law` and the processor seconds of the whole program."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [program, "area-law", path, "--threads", "1", "--tolerance", str(tolerance), "--quiet", "--json"]
    command += ["--youngs-modulus-gpa", str(YOUNGS_MODULUS_PA / 1e9), "--pressures-mpa", pressures_mpa]
    report = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return report, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def processor():
    """The processor's name where the system tells it."""
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as lines:
            return next(line.split(":")[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or platform.machine()


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--pixels", type=int, default=512)
    arguments.add_argument("--pressures-mpa", default=SWEEP_MPA)
    arguments.add_argument("--tolerance", type=float, default=1e-8)
    arguments.add_argument("--max-iterations", type=int, default=20000)
    arguments.add_argument("--program", default="target/release/slipgrid")
    arguments = arguments.parse_args()
    # One processor for both, where the system allows.
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    pressures = [float(pressure) for pressure in arguments.pressures_mpa.split(",")]

    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "map.asc")
        waves = f"4:{arguments.pixels // 8}"
        command = [arguments.program, "synthesize", "--pixels", str(arguments.pixels), "--waves", waves, "-o", path]
        subprocess.run(command, check=True, capture_output=True)
        heights = numpy.loadtxt(path) * 1e-9  # written in nm
        # Read once before, so that neither waits for the disk.
        report, whole = by_slipgrid(arguments.program, path, arguments.pressures_mpa, arguments.tolerance)
        _, reading = by_slipgrid(arguments.program, path, "1e5", arguments.tolerance)
    theirs = by_tamaas(heights, pressures, arguments.tolerance, arguments.max_iterations)

    print(f"{arguments.pixels} x {arguments.pixels} pixels, waves {waves}, tolerance {arguments.tolerance:g}; "
          f"Tamaas {tamaas.TamaasInfo.version}, slipgrid {report['version']}; {processor()}, one thread each")
    print("   P MPa  Tamaas: area corrected iterations  seconds  slipgrid: area corrected iterations  difference")
    worst = 0.0
    for ours, (area, corrected, iterations, seconds) in zip(report["results"], theirs):
        difference = max(abs(ours["area_fraction"] - area), abs(ours["area_fraction_corrected"] - corrected))
        worst = max(worst, difference)
        print(f"{ours['pressure_mpa']:8g} {area:13.6f} {corrected:9.6f} {iterations:10d} {seconds:8.2f}"
              f" {ours['area_fraction']:15.6f} {ours['area_fraction_corrected']:9.6f} {ours['iterations']:10d}"
              f" {difference:11.1e}")
    seconds, ours = sum(row[3] for row in theirs), whole - reading
    print(f"sum: Tamaas {sum(row[2] for row in theirs)} iterations, {seconds:.2f} s; "
          f"slipgrid {sum(row['iterations'] for row in report['results'])} iterations, {ours:.2f} s "
          f"({whole:.2f} s with the reading of the map)")
    print(f"ratio {seconds / ours:.1f} ({seconds / whole:.1f} with the reading); largest difference of area {worst:.1e}")


if __name__ == "__main__":
    main()
