"""The bench with one thing changed: what each mechanism is needed for, and what it sets."""

from dataclasses import replace

import numpy as np

from .._arguments import number
from ..bench.arguments import one_of
from ..bench.gearbox import bench_imperfections, bench_rig, bench_start
from .designs import paper_design
from .experiment import FIGURES, bench_ensemble, extremes, tick_hits

# Mechanism -> (entry of `Imperfections`, index of the motor or None for all), or a name of its own.
PARTS = {
    "gap 1": ("gap", 0),
    "gap 2": ("gap", 1),
    "dry friction 1": ("gear_friction", 0),
    "dry friction 2": ("gear_friction", 1),
    "A/D step": ("resolution", None),
    "sensor offsets": ("offset", None),
    "damping 1": ("damping", 0),
    "start by hand": ("initial", None),
}


def changed(name, part, factor=0.0):
    """Arguments of `bench_ensemble` for the bench with one of `PARTS` multiplied by a factor.

    Factor 0 takes the part away; for the damping of motor 1 that is the data sheet's value.

    >>> pl.changed("double", "gap 1")["imperfections"].gap
    (0.0,)
    """
    one_of("part", part, PARTS)
    number("factor", factor, least=0, most=1000)
    entry, motor = PARTS[part]
    rig = paper_design(name).rig
    on, stands = bench_imperfections(rig), bench_rig(rig)
    if entry == "initial":
        return dict(initial=tuple(factor * angle for angle in bench_start(rig)))
    if entry == "damping":
        first, *others = stands.motors
        damping = factor * first.damping if factor else rig.motors[0].damping
        return dict(rig=replace(stands, motors=(replace(first, damping=damping), *others)))
    values = np.array(getattr(on, entry), dtype=float)
    values[slice(None) if motor is None else slice(motor, motor + 1)] *= factor
    return dict(imperfections=replace(on, **{entry: tuple(values.tolist())}))


def hits_without(count=16):
    """Mechanism -> `tick_hits` of both rigs together with that mechanism taken away.

    From `count` runs for each; "the bench" itself from its whole ensemble.
    """
    table = {"the bench": {}} | {part: {} for part in PARTS}
    for name in FIGURES:
        table["the bench"] |= tick_hits(name)
        for part in PARTS:
            table[part] |= tick_hits(name, bench_ensemble(name, count, **changed(name, part)))
    return table


def hertz(run, since=10.0):
    """Frequency at which theta2 - theta1 swings from `since` (s) on; nan below one whole swing."""
    bend = run.angles[run.t >= since, 1]
    above = bend >= bend.mean()
    up = np.flatnonzero(~above[:-1] & above[1:])
    return (len(up) - 1) / (run.dt * np.ptp(up)) if len(up) > 1 else np.nan


def quantities(name, run):
    """What can be read off Fig 16 or 17: sizes (rad, V), frequency (Hz)."""
    figure, ends = FIGURES[name][0][-1], extremes(name, run)
    since = 0.0 if run.fell else 10.0
    late = run.t >= since

    def size(panel):
        return (ends[f"{figure}{panel} max"] - ends[f"{figure}{panel} min"]) / 2

    values = {
        "size of θ2−θ1": np.ptp(run.y[late, 1]) / 2,
        "its frequency": hertz(run, since),
        "rate of link 1": size("b"),
        "voltage 1": size("c"),
    }
    if name == "triple":
        values |= {"size of θ3−θ2": np.ptp(run.y[late, 2]) / 2, "voltage 2": size("d")}
    return dict.fromkeys(values, np.nan) if run.fell else values


def exponents(name, count=12, by=4 / 3):
    """Part -> {quantity: p}, where the quantity goes as the p-th power of the part.

    From two ensembles with the part divided and multiplied by `by`; p = 1 is in proportion, p = 0
    no effect. Medians over the runs; nan where a run falls.
    """
    number("by", by, above=1, most=1000)
    table = {}
    for part, (_, motor) in PARTS.items():
        if part == "start by hand" or (motor or 0) >= paper_design(name).rig.n_motors:
            continue
        low, high = (
            _medians(name, bench_ensemble(name, count, **changed(name, part, factor)))
            for factor in (1 / by, by)
        )
        table[part] = {key: np.log(high[key] / low[key]) / (2 * np.log(by)) for key in low}
    return table


def _medians(name, runs):
    rows = [quantities(name, run) for run in runs]
    return {key: float(np.median([row[key] for row in rows])) for key in rows[0]}
