"""What section 5 says in words of its experiments, each as the share of an ensemble of which it holds."""

from functools import lru_cache

import numpy as np

from ..bench.gearbox import bench_imperfections, bench_rig, bench_start
from ..bench.many import simulate_many
from .designs import paper_design
from .experiment import bench_ensemble
from .ledger import published

GROWS = 1.1  # a swing that counts as larger: by a tenth
SETTLED = 2.0  # s, read for "quickly"
STEADY = 0.25  # share by which the swing of a steady motion may change
ATTITUDE_STARTS = 8


def swing(run, angle, start, stop):
    """Root mean square of a reading about its mean between two times (s), rad."""
    inside = (run.t >= start) & (run.t <= stop)
    return float(run.y[inside, angle].std())


def alignment(run, since=SETTLED):
    """Average amplitude of theta3 - theta2: mean size of its extremes after `since` seconds, rad."""
    angle = run.y[run.t >= since, 2]
    turning = (angle[1:-1] - angle[:-2]) * (angle[2:] - angle[1:-1]) < 0
    return float(np.abs(angle[1:-1][turning]).mean())


def aligned(run):
    """theta3 - theta2 keeps on average within the printed range, soon after the start."""
    return alignment(run) <= published("sec5.triple.alignment").values


def growing(run):
    """theta1 and theta2 - theta1 swing more in each third of the first seven seconds."""
    end = float(published("sec5.triple.growing_until").values)
    edges = np.linspace(0, end, 4)
    sizes = np.array([[swing(run, i, *edges[k : k + 2]) for k in range(3)] for i in (0, 1)])
    return bool(np.all(sizes[:, 1:] > GROWS * sizes[:, :-1]))


def reduced(run):
    """theta1 and theta2 - theta1 swing less in Fig 16 than at the end of Fig 15."""
    start = float(published("sec5.triple.steady_after").values)
    end = float(published("sec5.triple.growing_until").values)
    return all(
        GROWS * swing(run, i, start, start + end / 3) < swing(run, i, end * 2 / 3, end)
        for i in (0, 1)
    )


def steady(run):
    """The double swings alike in both halves of Fig 17."""
    start, stop = published("fig17a.t_axis").values
    middle = (start + stop) / 2
    return all(
        abs(swing(run, i, start, middle) / swing(run, i, middle, stop) - 1) < STEADY for i in (0, 1)
    )


def share(name, holds, runs=None):
    """Share of the ensemble's runs for which ``holds(run)``; a run that falls counts as none."""
    runs = bench_ensemble(name) if runs is None else runs
    return float(np.mean([not run.fell and holds(run) for run in runs]))


@lru_cache
def attitude_share():
    """Share of starts from which the double holds the printed attitude, on average, both ways.

    The paper's own controller; means over the last ten seconds of a minute, right to the digit.
    """
    design, printed = paper_design("double"), published("sec5.attitude_range")
    stands, on = bench_rig(design.rig), bench_imperfections(design.rig)
    draw, start = np.random.default_rng(0), np.array(bench_start(design.rig))
    starts = start + draw.uniform(-1e-3, 1e-3, (ATTITUDE_STARTS, len(start)))
    held = np.ones(ATTITUDE_STARTS, bool)
    for sign in (1, -1):
        led = dict(reference=sign * float(printed.values), imperfections=on)
        cases = [dict(initial=x0, **led) for x0 in starts]
        for k, run in enumerate(
            simulate_many(stands, design.controller, 60.0, cases, progress=False)
        ):
            late = run.t >= 50.0
            held[k] &= not run.fell and printed.holds(sign * run.angles[late, 1].mean())
    return float(held.mean())
