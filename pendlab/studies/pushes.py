"""How hard a rig may be pushed: the admissible torque disturbances that the paper left open."""

from dataclasses import dataclass

import numpy as np

from .._arguments import array, found, instance, number, numbers
from ..bench.imperfections import Imperfections, Pulse
from ..bench.many import simulate_many
from ..bench.simulation import simulate
from ..parameters import Pendulum

FIRST, LEAST = 0.1, 1e-15  # N m (or N): where the search begins, and what counts as none
DOUBLINGS = 40


@dataclass(frozen=True)
class Admissible:
    """Largest recovered pulse of each kind and length, and what was pushed."""

    lengths: np.ndarray  # (k,) s
    heights: np.ndarray  # (kinds, k) N m (or N); one that is not recovered lies within `accuracy`
    rig: Pendulum
    imperfections: Imperfections | None

    @property
    def impulses(self):
        """Height times length, N m s (or N s)."""
        return self.heights * self.lengths


def largest_pulses(
    rig, controller, lengths, imperfections=None, initial=None, *,
    levers=None, start=3.0, recovery=7.0, accuracy=0.02,
):  # fmt: skip
    """`Admissible`: the largest pulse on each link, in the worse direction, that the rig survives.

    A pulse of height h acts from `start` for its length; recovered means that no
    link has passed the horizontal `recovery` seconds after it began. h is bracketed by doubling and
    then bisected, all lengths, links and directions at once. With imperfections the answer depends
    a little on the moment within the limit cycle at which the push comes.

    Parameters
    ----------
    rig, controller, imperfections, initial : as for `simulate`
    lengths : k pulse lengths, s
    levers : (kinds, n) torque on each link per unit of each kind of push; default a torque on one
        link at a time (N m); `force_levers(rig)` for forces (N)
    start, recovery : s
    accuracy : relative, from 1e-9 to below 1

    ValueError for a rig that falls without any push, or that no push makes fall in time.

    >>> design = pl.paper_design("double")
    >>> found = pl.largest_pulses(design.rig, design.controller, [0.05], recovery=2.0, accuracy=0.1)
    >>> found.heights.round(1).tolist()
    [[1.0], [1.0]]
    """
    instance("rig", rig, Pendulum, 'pl.load("double")')
    lengths = np.array(numbers("lengths", lengths, above=0))
    if number("start", start, least=0) + number("recovery", recovery, above=0) > 3600:
        raise ValueError("start, recovery: expected an hour at most, found more seconds.")
    if not 1e-9 <= number("accuracy", accuracy) < 1:
        raise ValueError(f"accuracy: expected a number from 1e-9 to below 1, {found(accuracy)}.")
    n = rig.n_links
    levers = np.eye(n) if levers is None else array("levers", levers, (None, n))
    if not (lengths.size and levers.any(axis=1).all() and len(levers)):
        raise ValueError(
            "lengths, levers: expected at least one pulse, and kinds of push that turn a link each."
        )
    end, common = start + recovery, dict(initial=initial, imperfections=imperfections)
    if simulate(rig, controller, end, **common).fell:
        raise ValueError(
            "imperfections: this rig falls without any push; balance it first, then push."
        )
    pushes = [(lever, t, sign) for lever in levers for t in lengths for sign in (1, -1)]

    def recovers(heights, which):
        """Which of the pushes it survives; those that are not asked for count as not survived."""
        asked = [_pulses(*pushes[k], heights[k], start) for k in np.flatnonzero(which)]
        cases = [dict(disturbance=pulses) for pulses in asked]
        held = np.zeros(len(pushes), dtype=bool)
        runs = simulate_many(rig, controller, end, cases, progress=False, **common)
        held[which] = [not run.fell for run in runs]
        return held

    low, high = _bracket(recovers, len(pushes))
    low, high = _bisect(recovers, low, high, accuracy)
    heights = low.reshape(len(levers), len(lengths), 2).min(axis=2)
    return Admissible(lengths, heights, rig, imperfections)


def _pulses(lever, length, sign, height, start):
    return [
        Pulse(i + 1, start, length, float(sign * height * lever[i])) for i in np.flatnonzero(lever)
    ]


def _bracket(recovers, count):
    """Heights (recovered, not recovered), each twice the other or from zero to the first try."""
    low, high = np.zeros(count), np.full(count, FIRST)
    growing = np.ones(count, dtype=bool)
    for _ in range(DOUBLINGS):
        growing = recovers(high, growing)
        if not growing.any():
            return low, high
        low[growing], high[growing] = high[growing], 2 * high[growing]
    raise ValueError(
        f"lengths, levers, recovery: a push of {high.max() / 2:.2g} N m (or N) is not enough to make "
        "the rig fall in time; give it longer pulses, larger levers or more time."
    )


def _bisect(recovers, low, high, accuracy):
    """The brackets narrowed to `accuracy`; one that reaches LEAST is left with zero as its answer."""
    every = np.ones(len(low), dtype=bool)
    while np.any((high - low > accuracy * high) & (high > LEAST)):
        middle = (low + high) / 2
        held = recovers(middle, every)
        low, high = np.where(held, middle, low), np.where(held, high, middle)
    return low, high


def force_levers(rig):
    """Torques on the links by a horizontal force of 1 N at the centre of mass of each link.

    Upright, a force at link i turns every link below by its length and link i by its com. An (n, n)
    array, m; row i (counted from 0) for a force on link i + 1.

    >>> pl.force_levers(pl.load("double"))
    array([[0.1291, 0.    ],
           [0.174 , 0.217 ]])
    """
    n = instance("rig", rig, Pendulum, 'pl.load("double")').n_links
    lengths = [link.length for link in rig.links]
    return np.array([[*lengths[:i], rig.links[i].com, *[0.0] * (n - i - 1)] for i in range(n)])
