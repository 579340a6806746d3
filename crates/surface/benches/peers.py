"""What the scripts that stand our rough-contact solver beside other codes share: the map, our own answer, the corrected area."""

import argparse
import json
import os
import platform
import resource
import statistics
import subprocess
import tempfile

import numpy

YOUNGS_MODULUS_PA = 0.38e9
POISSON_RATIO = 1.0 / 3.0
SIDE_M = 1e-3
RUNS = 3
SWEEP_MPA = "0.1,0.2,0.4,0.7,1,1.3,1.6,2,2.6,3.3,4.1,5"


def arguments(description):
    """The arguments of either script; the whole process stays on one processor, where the system allows."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    parser = argparse.ArgumentParser(description=description.splitlines()[0])
    parser.add_argument("--pixels", type=int, default=512)
    parser.add_argument("--pressures-mpa", default=SWEEP_MPA)
    parser.add_argument("--tolerance", type=float, default=1e-8)
    parser.add_argument("--max-iterations", type=int, default=20000)
    parser.add_argument("--program", default="target/release/slipgrid")
    return parser.parse_args()


def corrected_area(contact):
    """Yastrebov's perimeter correction on square pixels."""
    edges = sum(int((contact != numpy.roll(contact, 1, axis)).sum()) for axis in (0, 1))
    return contact.mean() - (numpy.pi - 1 + numpy.log(2)) / 24 * edges / contact.size


def by_slipgrid(given):
    """Heights in metres, the report of `slipgrid area-law` of them, and median processor seconds: of the whole program, of reading
    alone."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "map.asc")
        command = [given.program, "synthesize", "--pixels", str(given.pixels), "--waves", waves(given), "-o", path]
        subprocess.run(command, check=True, capture_output=True)
        heights = numpy.loadtxt(path) * 1e-9  # written in nm
        # The file was read once before, so that the program does not wait for the disk.
        runs = [area_law(given, path, given.pressures_mpa) for _ in range(RUNS)]
        # In full contact, the threshold of the law as well, nothing is left to solve.
        reading = statistics.median(area_law(given, path, "1e5", "--threshold-mpa", "1e5")[1] for _ in range(RUNS))
    return heights, runs[0][0], statistics.median(whole for _, whole in runs), reading


def waves(given):
    """Wave numbers of the map, from the longest to eight pixels a wave."""
    return f"4:{given.pixels // 8}"


def area_law(given, path, pressures_mpa, *options):
    """The report of `slipgrid area-law` and the processor seconds of the whole program."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [given.program, "area-law", path, "--threads", "1", "--tolerance", str(given.tolerance), "--quiet", "--json"]
    # The map alone, as the peers solve it, and all of it anew.
    command += ["--windows", "0", "--no-cache"]
    command += ["--youngs-modulus-gpa", str(YOUNGS_MODULUS_PA / 1e9), "--pressures-mpa", pressures_mpa, *options]
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


def heading(given, peer, report):
    """What is compared, on what."""
    return (f"{given.pixels} x {given.pixels} pixels, waves {waves(given)}, tolerance {given.tolerance:g}; {peer}, "
            f"slipgrid {report['version']}; {processor()}, one thread each")


def compare(name, theirs, report, whole, reading):
    """Rows of both by pressure, their sums, and the ratio of times. `theirs`: area, corrected area, iterations, seconds."""
    print(f"   P MPa  {name}: area corrected iterations  seconds  slipgrid: area corrected iterations  difference")
    worst = 0.0
    for ours, (area, corrected, iterations, seconds) in zip(report["results"], theirs):
        difference = max(abs(ours["area_fraction"] - area), abs(ours["area_fraction_corrected"] - corrected))
        worst = max(worst, difference)
        print(f"{ours['pressure_mpa']:8g} {area:13.6f} {corrected:9.6f} {iterations:10d} {seconds:8.2f}"
              f" {ours['area_fraction']:15.6f} {ours['area_fraction_corrected']:9.6f} {ours['iterations']:10d}"
              f" {difference:11.1e}")
    seconds, ours = sum(row[3] for row in theirs), whole - reading
    print(f"sum: {name} {sum(row[2] for row in theirs)} iterations, {seconds:.2f} s; "
          f"slipgrid {sum(row['iterations'] for row in report['results'])} iterations, {ours:.2f} s "
          f"({whole:.2f} s with the reading of the map)")
    print(f"ratio {seconds / ours:.1f} ({seconds / whole:.1f} with the reading); largest difference of area {worst:.1e}")
