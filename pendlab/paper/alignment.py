"""Gains of motor 2's position loop between which it helps, (18) and (19)."""

import numpy as np
from scipy.optimize import bisect

from ..sampled import align


def alignment_interval(model):
    """Gains k_p between which alignment leaves the fewest unstable eigenvalues: (lower, upper).

    The ends are where an eigenvalue of A - B2 k_p C_p C meets the unit circle (or the imaginary
    axis), found by counting over a grid of k_p from 1e-3 to 1e4 V/rad and bisection.

    Parameters
    ----------
    model : control.StateSpace with at least two inputs, as for `pl.align`

    >>> [round(kp, 3) for kp in pl.alignment_interval(pl.sample(pl.linearize(pl.load("triple"))))]
    [0.785, 72.36]
    """

    def unstable(kp):
        values = np.linalg.eigvals(align(model, kp).A)
        return int(np.sum(np.abs(values) > 1 if model.dt else values.real > 0))

    gains = np.geomspace(1e-3, 1e4, 141)
    counts = np.array([unstable(kp) for kp in gains])

    def inside(kp):
        return 0.5 if unstable(kp) == counts.min() else -0.5

    best = np.flatnonzero(counts == counts.min())
    first, last = best[0], best[0] + np.argmax(np.append(np.diff(best) > 1, True))
    lower = 0.0 if first == 0 else bisect(inside, gains[first - 1], gains[first])
    upper = np.inf if last == len(gains) - 1 else bisect(inside, gains[last], gains[last + 1])
    return float(lower), float(upper)
