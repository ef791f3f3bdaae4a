"""How hard a rig may be pushed: the admissible torque disturbances that the paper left open."""

from dataclasses import dataclass

import numpy as np

from .._arguments import array, number, whole
from ..bench.imperfections import Pulse
from ..bench.many import simulate_many


@dataclass(frozen=True)
class Admissible:
    """Largest recovered pulse of each kind and length.

    Attributes
    ----------
    lengths : (k,) s
    heights : (kinds, k) N m (or N, for `force_levers`), recovered, and within `accuracy` of one
        that is not
    rig, imperfections : what was pushed
    """

    lengths: np.ndarray
    heights: np.ndarray
    rig: object
    imperfections: object

    @property
    def impulses(self):
        """Height times length, N m s (or N s)."""
        return self.heights * self.lengths


def largest_pulses(
    rig, controller, lengths, imperfections=None, initial=None, levers=None, start=3.0,
    recovery=7.0, accuracy=0.02, progress=None,
):  # fmt: skip
    """Largest pulse on each link, in the worse direction, from which the rig recovers.

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
    accuracy : relative
    progress : function of (runs done, rounds of runs at most), or None

    Returns
    -------
    Admissible

    Raises
    ------
    ValueError : a rig that falls without any push
    """
    lengths = array("lengths", np.atleast_1d(lengths), (None,))
    for length in lengths:
        number("lengths", length, above=0)
    number("accuracy", accuracy, above=0)
    n, k = rig.n_links, len(lengths)
    levers = np.eye(n) if levers is None else array("levers", levers, (None, n))
    pushes = [(lever, t, sign) for lever in levers for t in lengths for sign in (1, -1)]
    common = dict(initial=initial, imperfections=imperfections, progress=False)

    def recovers(heights):
        cases = [
            dict(
                disturbance=[
                    Pulse(i + 1, start, t, sign * h * lever[i]) for i in np.flatnonzero(lever)
                ]
            )
            for (lever, t, sign), h in zip(pushes, heights)
        ]
        runs = simulate_many(rig, controller, start + recovery, cases, **common)
        return np.array([not run.fell for run in runs])

    rounds, done = _Rounds(progress, accuracy), 0
    low, high = np.zeros(len(pushes)), np.full(len(pushes), 0.1)
    if not recovers(low[:1])[0]:
        raise ValueError(
            "imperfections: this rig falls without any push; balance it first, then push."
        )
    growing = np.ones(len(pushes), dtype=bool)
    while growing.any() and high.max() < 1e4:
        held = recovers(high) & growing
        low[held], high[held] = high[held], 2 * high[held]
        growing = held
        done = rounds.tell(done)
    while np.any(high - low > accuracy * high):
        middle = (low + high) / 2
        held = recovers(middle)
        low, high = np.where(held, middle, low), np.where(held, high, middle)
        done = rounds.tell(done)
    heights = low.reshape(len(levers), k, 2).min(axis=2)
    return Admissible(lengths, heights, rig, imperfections)


def force_levers(rig):
    """Torques on the links by a horizontal force of 1 N at the centre of mass of each link.

    Upright, a force at link i turns every link below by its length and link i by its com.

    Returns
    -------
    (n, n) array, row i for a force on link i + 1, m
    """
    n = rig.n_links
    lengths = [link.length for link in rig.links]
    return np.array([[*lengths[:i], rig.links[i].com, *[0.0] * (n - i - 1)] for i in range(n)])


class _Rounds:
    """Progress in rounds of runs: some ten to bracket and to bisect."""

    def __init__(self, progress, accuracy):
        self.progress = progress
        self.all = 8 + whole("rounds", int(np.ceil(np.log2(1 / accuracy))))

    def tell(self, done):
        if self.progress is not None:
            self.progress(min(done + 1, self.all), self.all)
        return done + 1
