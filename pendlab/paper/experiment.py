"""The paper's experiments on the simulated bench, judged by the printed ticks and words.

Motion in a gap is chaotic: runs from starts a micrometre apart differ after seconds. So the bench is
judged by an ensemble of runs, never by one.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from .._arguments import found, instance, number, whole
from ..bench.arguments import one_of
from ..bench.gearbox import bench_imperfections, bench_rig, bench_start
from ..bench.imperfections import Imperfections
from ..bench.inputs import initial_state
from ..bench.many import simulate_many
from ..bench.simulation import Run, simulate
from ..models import angle_names
from ..parameters import Pendulum
from .designs import paper_design
from .ledger import published

# Pendulum -> its figures and the time at which the last of them ends, s.
FIGURES = {"triple": (("15", "16"), 37.0), "double": (("17",), 18.0)}


def bench_run(name, t_end=37.0):
    """The paper's rig and controller on the bench of ``data/gearbox.toml``, from its start by hand.

    >>> pl.bench_run("double", t_end=1.0).fell
    False
    """
    paper_design(name)
    return _bench_run(name, number("t_end", t_end, least=0))


@lru_cache
def _bench_run(name, t_end):
    rig, controller = paper_design(name).rig, paper_design(name).controller
    start, on = bench_start(rig), bench_imperfections(rig)
    return simulate(bench_rig(rig), controller, t_end, start, imperfections=on)


def bench_ensemble(
    name, count=50, spread=1e-3, seed=0, *, rig=None, initial=None, imperfections=None
):
    """`Runs` of the paper's experiment from starts near the bench's own, to the end of its figures.

    Equal calls give the same runs.

    Parameters
    ----------
    name : "double" or "triple"
    count : number of runs
    spread : each start angle is off by up to this, evenly distributed, rad
    seed : of the starts; run k also takes seed + k for its noise
    rig, initial, imperfections : instead of `bench_rig`, `bench_start`, `bench_imperfections`

    >>> len(pl.bench_ensemble("double", count=2))
    2
    """
    paper = paper_design(_known(name)).rig
    whole("count", count, least=1, most=10_000)
    number("spread", spread, least=0, most=np.pi)
    whole("seed", seed, most=2**62)
    own = rig is None and initial is None and imperfections is None
    rig = instance("rig", bench_rig(paper) if rig is None else rig, Pendulum, "pl.bench_rig(...)")
    on = bench_imperfections(paper) if imperfections is None else imperfections
    instance("imperfections", on, Imperfections)
    start = initial_state(bench_start(paper) if initial is None else initial, paper.n_links)
    ensemble = _ensemble if own else _ensemble.__wrapped__
    return ensemble(name, count, float(spread), seed, rig, tuple(start.tolist()), on)


@lru_cache(maxsize=4)  # some 30 MB each: the bench as it is, not its changes
def _ensemble(name, count, spread, seed, rig, start, imperfections):
    draw, n = np.random.default_rng(seed), rig.n_links
    starts = np.tile(start, (count, 1))
    starts[:, :n] += draw.uniform(-spread, spread, (count, n))
    noisy = [replace(imperfections, seed=seed + k) for k in range(count)]
    cases = [dict(initial=x0, imperfections=on) for x0, on in zip(starts, noisy)]
    controller, t_end = paper_design(name).controller, FIGURES[name][1]
    return simulate_many(rig, controller, t_end, cases, progress=False)


def tick_intervals(name):
    """``"15a min"`` -> (low, high): where each extreme of the printed figures must lie.

    Every limit of the axes is a multiple of their tick. As automatic axes are made, a limit is the
    first tick that encloses the data, so the largest reading lies within one tick below the
    upper limit, and the smallest within one tick above the lower.

    >>> pl.tick_intervals("double")["17c max"]
    (2.0, 3.0)
    """
    intervals = {}
    for figure in FIGURES[_known(name)][0]:
        for panel in "abcd"[: 2 + paper_design(name).rig.n_motors]:
            low, high = map(float, published(f"fig{figure}{panel}.y_axis").values)
            tick = float(published(f"fig{figure}{panel}.y_tick").values)
            intervals[f"{figure}{panel} min"] = (low, round(low + tick, 9))
            intervals[f"{figure}{panel} max"] = (round(high - tick, 9), high)
    return intervals


def tick_hits(name, runs=None):
    """``"15a min"`` -> share of the ensemble's runs whose extreme lies within its printed tick.

    Parameters
    ----------
    name : "double" (Fig 17, 6 extremes) or "triple" (Figs 15 and 16, 16 extremes)
    runs : runs to judge; default ``bench_ensemble(name)``. A run that falls before the end of a
        panel meets none of its extremes

    >>> list(pl.tick_hits("double"))
    ['17a min', '17a max', '17b min', '17b max', '17c min', '17c max']
    """
    intervals = tick_intervals(name)
    runs = bench_ensemble(name) if runs is None else runs
    if not isinstance(runs, Sequence) or not runs or not all(isinstance(run, Run) for run in runs):
        raise TypeError(f"runs: expected runs such as pl.bench_ensemble({name!r}), {found(runs)}.")
    values = [extremes(name, run) for run in runs]
    return {
        key: float(np.mean([low <= value[key] <= high for value in values]))
        for key, (low, high) in intervals.items()
    }


def extremes(name, run):
    """``"15a min"`` -> the extreme of all traces of that panel; nan where the run falls before."""
    result = {}
    for figure in FIGURES[_known(name)][0]:
        for panel, traces in signals(run).items():
            inside = window(run, figure, panel)
            values = np.stack([trace[inside] for trace in traces.values()])
            judged = values if not run.fell and values.size else np.array([np.nan])
            result[f"{figure}{panel} min"] = float(judged.min())
            result[f"{figure}{panel} max"] = float(judged.max())
    return result


def signals(run):
    """Panel -> {look: trace}, as recorded by the paper's computer: readings and sent voltages."""
    n = instance("run", run, Run, "pl.simulate(...)").rig.n_links
    panels = {
        "a": {name: run.y[:, i] for i, name in enumerate(angle_names(n))},
        "b": {"rate": run.y[:, n]},
    }
    for motor in range(min(run.rig.n_motors, 2)):
        panels["cd"[motor]] = {f"u{motor + 1}": run.u[:, motor]}
    return panels


def window(run, figure, panel="a"):
    """Which samples of a run a panel of the paper shows."""
    start, stop = published(f"fig{figure}{panel}.t_axis").values
    return (run.t > start - 1e-9) & (run.t < stop + 1e-9)


def _known(name):
    return one_of("name", name, FIGURES)
