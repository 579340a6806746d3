"""Writes the synthetic traces of this folder: python3 make_traces.py

Friction of the flat samples is 1.015 mu_d f(P): mu_d = 0.18, f by Persson's contact area with
E* h'rms = 12 MPa, the 1.5 % what micro-stick-slip adds to steady sliding. Repeats differ by 0.6 %,
samples by 2 %. Patterned samples have the share of it that grooves of 100/300/20 um have in the model
(0.961 at 80 N, 0.787 at 300 N) times 0.95, a discrepancy for the calibration to find. Torques are those
of three specimens at 25 mm.
"""

import math
import random

RADIUS_M, ARM_M, SPECIMENS = 0.003, 0.025, 3
DYNAMIC_MEAN, SCALE_PA, THRESHOLD_PA = 0.18, 12e6, 0.7e6
PATTERNED_OVER_FLAT = {80: 0.95 * 0.961, 300: 0.95 * 0.787}


def area(pressure_pa):
    return math.erf(math.sqrt(2) * pressure_pa / SCALE_PA)


def flat_friction(force_n):
    pressure_pa = force_n / (math.pi * RADIUS_M**2)
    factor = 1.0
    if pressure_pa > THRESHOLD_PA:
        factor = area(pressure_pa) / area(THRESHOLD_PA) / (pressure_pa / THRESHOLD_PA)
    return 1.015 * DYNAMIC_MEAN * factor


def comma(value, digits):
    return f"{value:.{digits}f}".replace(".", ",")


def write(kind, force_n, repeat, ratio):
    noise = random.Random(f"{kind} {force_n} {repeat}")
    level = ratio * flat_friction(force_n) * (1 + 0.006 * noise.gauss(0, 1))
    lines = [f"# synthetic, not measured: {kind} sample, {force_n} N, repeat {repeat}", "Zeit [s];Mz [mNm];Fz [N]"]
    for i in range(301):
        t = 0.1 * i
        mu = level * (1 - math.exp(-t / 0.4)) * (1 + 0.02 * noise.gauss(0, 1))
        load_n = SPECIMENS * force_n * (1 + 0.004 * noise.gauss(0, 1))
        lines.append(f"{comma(t, 1)};{comma(1e3 * mu * load_n * ARM_M, 1)};{comma(load_n, 2)}")
    with open(f"traces/{kind}-{force_n}N-{repeat}.csv", "w") as file:
        file.write("\n".join(lines) + "\n")


for repeat in (1, 2, 3):
    for force_n in (30, 80, 160, 300):
        write("flat", force_n, repeat, 1.0)
    for force_n, ratio in PATTERNED_OVER_FLAT.items():
        write("patterned", force_n, repeat, ratio)
