"""Nyquist contour and encirclements of a sampled loop, counted on the curve; it is broken at x:

--x---> G(z) ---> P(z) --- -1 ---+        L(z) = P(z) G(z)
  |                              |
  +------------------------------+
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.linalg import eig, matrix_balance

from .loop import check_loop, on_circle, prepared


class Encirclements(NamedTuple):
    """Anticlockwise turns of det(I + L) about 0 (one input: of L about -1), and the poles."""

    turns: int
    unstable_open: int
    unstable_closed: int

    @property
    def stable(self):
        return self.unstable_closed == 0


def encirclements(loop):
    """Turns of det(I + L(z)) about 0 as z goes once round the unit circle, counted on the curve.

    `loop` comes from `open_loop`, `broken_at` or `state_feedback_loop`. The contour leaves the
    circle outward round poles on it (the integrator at z = 1), which so count as stable. By the
    argument principle turns = unstable open-loop poles - unstable closed-loop poles; the count is
    held against both sets of eigenvalues.

    ValueError for a closed-loop eigenvalue on the unit circle (the curve meets the critical point),
    and for poles that rounding does not let us tell from each other.

    >>> pl.encirclements(pl.paper_design("triple").loop(1))  # Fig 11, the integrator's included
    Encirclements(turns=3, unstable_open=3, unstable_closed=0)
    """
    check_loop(loop)
    opened, (closed, doubt) = on_circle(loop.A), _with_doubt(loop.A - loop.B @ loop.C)
    if np.any(np.abs(np.abs(closed) - 1) <= doubt):
        raise ValueError(
            "loop: a closed-loop eigenvalue lies on the unit circle, so the curve goes through "
            "the critical point and no count exists; change the gain a little."
        )
    det, segments = _determinant(loop), _segments(loop, opened, closed)
    turns = 2 * sum(_phase_change(det, z_of) for z_of in segments) / (2 * np.pi)
    outside = [int(np.sum(np.abs(values) > 1 + 1e-15)) for values in (opened, closed)]
    if not abs(turns - (outside[0] - outside[1])) < 1e-3:
        raise ValueError(
            f"loop: counted {turns:.4f} turns, but {outside[0]} open-loop and {outside[1]} "
            "closed-loop poles lie outside the unit circle: rounding hides some of them; "
            "use another gain or better scaled states."
        )
    return Encirclements(round(turns), *outside)


def _with_doubt(A):
    """Eigenvalues of A, and how far rounding may have moved each (to first order)."""
    A, _ = matrix_balance(A)
    values, left, right = eig(A, left=True)
    overlap = np.abs(np.sum(left.conj() * right, axis=0))
    return values, 1e-15 * np.linalg.norm(A, 2) / np.maximum(overlap, 1e-300)


def contour(loop, points=400):
    """Upper half of the Nyquist contour: z, and det(I + L(z)) - 1 (L itself for one input)."""
    check_loop(loop)
    segments = _segments(loop, on_circle(loop.A), np.linalg.eigvals(loop.A - loop.B @ loop.C))
    z = np.concatenate([z_of(np.linspace(0, 1, points)) for z_of in segments])
    return z, _determinant(loop)(z) - 1


def _determinant(loop):
    """det(I + L(z)) as a function of z."""
    L = prepared(loop)

    def det(z):
        R = np.eye(loop.ninputs) + L(z)
        return R[:, 0, 0] if loop.ninputs == 1 else np.linalg.det(R)

    return det


def _segments(loop, opened, closed):
    """Pieces z(t), 0 <= t <= 1, of the upper half contour from z = 1 to z = -1."""
    on = np.abs(np.abs(opened) - 1) <= 1e-15
    computed = np.linalg.eigvals(loop.A)
    stops = _distinct(np.abs(np.angle(opened[on])))
    poles = np.exp(1j * stops)
    off = np.concatenate([opened[~on], closed])
    others = np.concatenate([off, poles, poles.conj()])
    # The curve turns fast where an eigenvalue is near; arcs begin there, as they are dense at ends.
    near = _distinct(np.abs(np.angle(off[np.abs(np.abs(off) - 1) < 0.3])))
    pieces, here = [], 0.0
    for stop, pole in zip(stops, poles):
        distances = np.abs(others - pole)
        nearest = distances[distances > 1e-12].min(initial=1.0)
        # Outside the places to which rounding moves a multiple pole, inside all others.
        moved = np.sort(np.abs(computed - pole))[np.sum(np.abs(opened - pole) < 1e-12) - 1]
        radius = max(0.1 * min(1e-4, nearest), 4 * moved)
        if radius > 0.3 * nearest:
            raise ValueError(
                f"loop: rounding moves the multiple pole at {pole:.6g} by {moved:.1g} and the next "
                f"pole is {nearest:.1g} away, so no count can be trusted; use another gain."
            )
        half = 2 * np.arcsin(radius / 2)  # the circle is met at the angles stop -+ half
        first, last = max(stop - half, 0.0), min(stop + half, np.pi)
        pieces += _arcs(here, first, near)
        pieces.append(_indentation(pole, radius, first, last, stop))
        here = last
    return pieces + _arcs(here, np.pi, near)


def _arcs(start, stop, near):
    """Arcs of the circle from start to stop, parted at the angles `near`; none where start is stop."""
    inside = [angle for angle in near if start + 1e-6 < angle < stop - 1e-6]
    corners = [start, *inside, stop] if start < stop else []
    return [_arc_of_circle(a, b) for a, b in pairwise(corners)]


def _arc_of_circle(start, stop):
    """Angles from start to stop, dense towards both ends."""

    def z_of(t):
        t = np.asarray(t)
        width, least = stop - start, 1e-7
        near = np.where(t < 0.5, t, 1 - t)
        offset = least * ((width / (2 * least)) ** (2 * near) - 1) * width / (width - 2 * least)
        return np.exp(1j * np.where(t < 0.5, start + offset, stop - offset))

    return z_of


def _indentation(pole, radius, first, last, stop):
    """Outward arc round a pole on the unit circle, from e^(j first) to e^(j last)."""
    begin = pole * radius if first == stop else np.exp(1j * first) - pole
    end = pole * radius if last == stop else np.exp(1j * last) - pole
    turn = np.angle(end / begin) % (2 * np.pi)  # anticlockwise about the pole: outside the circle

    def z_of(t):
        return pole + begin * np.exp(1j * turn * np.asarray(t))

    return z_of


def _distinct(angles):
    """The angles from 0 to pi in order, one of those that rounding parts."""
    angles = np.sort(angles)
    return angles[np.diff(angles, prepend=-1.0) > 1e-6]


def _phase_change(det, z_of, largest=0.3):
    """Change of arg det(I + L) along one piece, refined until no step exceeds `largest` rad."""
    t = np.linspace(0, 1, 201)
    values = det(z_of(t))
    for _ in range(40):
        steps = np.angle(values[1:] / values[:-1])
        wide = np.flatnonzero(np.abs(steps) > largest)
        if not len(wide):
            break
        middle = (t[wide] + t[wide + 1]) / 2
        t = np.insert(t, wide + 1, middle)
        values = np.insert(values, wide + 1, det(z_of(middle)))
    return float(np.sum(np.angle(values[1:] / values[:-1])))
