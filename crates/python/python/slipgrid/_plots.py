"""Plots on axes of Matplotlib. Each takes axes or makes new ones, and returns them."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ._designs import DesignResult, Prediction
    from ._maps import AreaLaw, Map
    from ._materials import FittedMaterial, Trials
    from ._scenes import SimulationResult

PRESSURE = "nominal pressure in MPa"
RATIO = "friction, textured over flat"


def axes(ax: Axes | None) -> Axes:
    """The given axes, or new ones."""
    if ax is not None:
        return ax
    try:
        pyplot = importlib.import_module("matplotlib.pyplot")
    except ImportError as error:
        raise ImportError(f"plot() needs matplotlib ({error}): pip install slipgrid[plot]") from error
    made: Axes = pyplot.subplots(layout="constrained")[1]
    return made


def heights(surface: Map, ax: Axes | None) -> Axes:
    ax = axes(ax)
    (dx_um, dy_um), (rows, columns) = surface.pixel_um, surface.heights_m.shape
    extent = (0.0, columns * dx_um, rows * dy_um, 0.0)
    image = ax.imshow(1e6 * surface.heights_m, extent=extent, cmap="viridis", interpolation="nearest")
    ax.figure.colorbar(image, ax=ax, label="height in µm")
    ax.set(xlabel="x in µm (sliding direction)", ylabel="y in µm")
    return ax


def area_law(law: AreaLaw, ax: Axes | None) -> Axes:
    ax = axes(ax)
    ax.errorbar(law.pressure_mpa, law.factor, yerr=np.nan_to_num(law.factor_std), fmt="o-", capsize=2)
    ax.set(xscale="log", xlabel=PRESSURE, ylabel="factor f(P) of the local coefficient")
    return ax


def simulation(found: SimulationResult, ax: Axes | None) -> Axes:
    ax = axes(ax)
    is_flat = np.isnan(found.ratio).all()
    ax.plot(found.pressure_mpa, found.mu_dynamic if is_flat else found.ratio, "o-")
    ax.set(xlabel=PRESSURE, ylabel="dynamic friction" if is_flat else RATIO)
    return ax


def prediction(found: Prediction, ax: Axes | None) -> Axes:
    ax = axes(ax)
    if found.median.ndim != 1:
        raise ValueError(f"a plot shows one texture, and these have the shape {found.median.shape[:-1]}: choose one by its index")
    off = np.abs(np.stack([found.low_95, found.high_95]) - found.median)
    ax.errorbar(found.pressure_mpa, found.median, yerr=off, fmt="o-", capsize=3, label="expected, 95 % of samples")
    ax.set(xlabel=PRESSURE, ylabel=RATIO if found.quantity == "ratio" else "dynamic friction")
    ax.legend()
    return ax


def design(found: DesignResult, ax: Axes | None) -> Axes:
    ax = axes(ax)
    rows = sorted(found.expected, key=lambda row: row.pressure_mpa)
    pressure_mpa = [row.pressure_mpa for row in rows]
    off = [[row.median - row.low_95 for row in rows], [row.high_95 - row.median for row in rows]]
    ax.errorbar(pressure_mpa, [row.median for row in rows], yerr=off, fmt="o", capsize=3, label="expected, 95 % of samples")
    for row in rows:
        if row.target_low is not None and row.target_high is not None:
            ends = [row.target_low, row.target_high]
            ax.plot([row.pressure_mpa] * 2, ends, color="tab:green", linewidth=8, alpha=0.3, solid_capstyle="butt")
    ax.set(xlabel=PRESSURE, ylabel=RATIO if found.target.quantity == "ratio" else "dynamic friction")
    ax.legend()
    return ax


def trials(ledger: Trials, ax: Axes | None) -> Axes:
    ax = axes(ax)
    for trial in ledger.trials:
        known = [row.without_trial for row in trial.measured]
        measured = [row.measured for row in trial.measured]
        off = [[of.ratio - of.interval_95[0] for of in known], [of.interval_95[1] - of.ratio for of in known]]
        ax.errorbar(measured, [of.ratio for of in known], yerr=off, fmt="o", capsize=2, label=trial.name)
    ax.axline((1.0, 1.0), slope=1.0, color="grey", linewidth=0.8)
    ax.set(xlabel="measured ratio", ylabel="ratio predicted by the other trials, 95 %")
    if ledger.trials:
        ax.legend()
    return ax


def fit(material: FittedMaterial, ax: Axes | None) -> Axes:
    ax = axes(ax)
    parameters = material.fit.parameters
    for place, own in enumerate(reversed(parameters)):
        ends = own.interval_95 or [own.value, own.value]
        ax.plot(ends, [place, place], color="tab:blue")
        ax.plot([own.value], [place], "o", color="tab:blue")
    ax.set(xlabel="value, 95 %", yticks=range(len(parameters)), yticklabels=[own.name for own in reversed(parameters)])
    return ax
