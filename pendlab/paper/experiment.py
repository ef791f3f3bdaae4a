"""The paper's experiments on the simulated bench: runs, what was recorded, and how it fits."""

from functools import lru_cache

import numpy as np

from .._arguments import instance, number, one_of
from ..bench.imperfections import bench_imperfections, bench_start
from ..bench.simulation import Run, simulate
from ..models import angle_names
from .designs import paper_design
from .ledger import published


def bench_run(name, t_end=37.0):
    """The paper's rig and controller on the bench of ``data/gearbox.toml``, from its start by hand.

    >>> bench_run("double", t_end=1.0).fell
    False
    """
    paper_design(name)
    return _bench_run(name, number("t_end", t_end, least=0))


@lru_cache
def _bench_run(name, t_end):
    design = paper_design(name)
    return simulate(
        design.rig,
        design.controller,
        t_end,
        initial=bench_start(design.rig),
        imperfections=bench_imperfections(design.rig),
    )


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


def fill(run, number):
    """Panel -> (lowest, highest, frame low, frame high, share of the frame that is filled).

    Readings outside the frame show as lowest < frame low or highest > frame high.
    """
    one_of("number", str(number), ("15", "16", "17"))
    result = {}
    for panel, traces in signals(run).items():
        low, high = published(f"fig{number}{panel}.y_axis").values
        inside = _window(run, number, panel)
        values = np.concatenate([trace[inside] for trace in traces.values()])
        if not len(values):
            values = np.array([np.nan])
        share = (values.max() - values.min()) / (high - low)
        result[panel] = (values.min(), values.max(), low, high, share)
    return result


def _window(run, number, panel="a"):
    start, stop = published(f"fig{number}{panel}.t_axis").values
    return (run.t >= start) & (run.t <= stop)


def alignment(run, since=2.0):
    """Average amplitude of theta3 - theta2: mean size of its extremes after `since` seconds, rad."""
    angle = run.y[run.t >= since, 2]
    turning = (angle[1:-1] - angle[:-2]) * (angle[2:] - angle[1:-1]) < 0
    return float(np.abs(angle[1:-1][turning]).mean())


def growth_time(run, until=7.0, share=0.9):
    """Time (s) at which theta2 - theta1 first reaches `share` of its largest size before `until`."""
    early = run.t <= until
    size = np.abs(run.y[early, 1])
    return float(run.t[early][np.argmax(size >= share * size.max())])


def held_attitude(name, reference=0.3, t_end=60.0, last=10.0):
    """Smaller of the mean |theta2 - theta1| (rad) held on the bench for references of both signs.

    The paper's own controller; means over the `last` seconds. Zero where the rig falls.
    """
    design = paper_design(name)
    held = []
    for sign in (1, -1):
        run = simulate(
            design.rig,
            design.controller,
            t_end,
            initial=bench_start(design.rig),
            reference=sign * reference,
            imperfections=bench_imperfections(design.rig),
        )
        late = run.t >= t_end - last
        held.append(0.0 if run.fell else sign * run.angles[late, 1].mean())
    return float(min(held))
