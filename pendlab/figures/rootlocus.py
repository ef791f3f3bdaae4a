"""Root locus of the aligned pendulum over k_p, equation (19): computed apart from drawn."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq, linear_sum_assignment

from .._arguments import array, found, number
from ..loop import sorted_eigenvalues
from ..sampled import align
from .picture import follow
from .sketch import arrowheads, frame_plane, unit_circle, zero_lines
from .style import COLORS, freeze_layout, look


@dataclass(frozen=True)
class RootLocus:
    """Eigenvalues of A - B2 k_p C_p C of equation (19) over k_p, one column for each branch."""

    kps: np.ndarray  # (N,) V/rad
    branches: np.ndarray  # (N, n) complex
    kp: float  # the gain to mark, and its n eigenvalues
    marked: np.ndarray
    changes: tuple  # gains within `kps` at which an eigenvalue meets the unit circle

    @property
    def unstable(self):
        """How many eigenvalues lie outside the unit circle at the marked gain."""
        return int(np.sum(np.abs(self.marked) > 1))

    def outside(self, frame):
        """Branches (M, N) that never enter ((left, right), (low, high))."""
        return self.branches.T[~_within(self.branches, frame).any(axis=0)]


def root_locus(model, kps, kp):
    """`RootLocus` of a sampled model with two inputs or more whose last motor holds the last link.

    `kps` are rising gains (V/rad) to sweep over, `kp` the one to mark.
    """
    kps, kp = array("kps", kps, (None,)), number("kp", kp)
    if len(kps) < 2 or np.any(np.diff(kps) <= 0) or np.abs(kps).max() > 1e6:
        raise ValueError(
            f"kps: expected at least 2 rising gains up to 1e6 V/rad, {found(kps)}; try a linspace."
        )
    none, one = align(model, 0.0).A, align(model, 1.0).A

    def eigenvalues(gains):
        return np.linalg.eigvals(none + np.multiply.outer(gains, one - none)).astype(complex)

    kps, branches = _swept(eigenvalues, kps)
    marked = sorted_eigenvalues(align(model, kp).A)
    return RootLocus(kps, branches, kp, marked, _changes(eigenvalues, kps))


def _swept(eigenvalues, kps, step=0.002, rounds=12, most=20_000):
    """`kps` refined where branches meet and part quickly, and the branches there."""
    for _ in range(rounds):
        branches = _joined(eigenvalues(kps))
        wide = np.flatnonzero(np.abs(np.diff(branches, axis=0)).max(axis=1) > step)
        if not len(wide) or len(kps) + len(wide) > most:
            return kps, branches
        kps = np.insert(kps, wide + 1, (kps[wide] + kps[wide + 1]) / 2)
    return kps, _joined(eigenvalues(kps))


def _joined(values):
    """Rows reordered so that each column follows one eigenvalue."""
    values[0] = values[0][np.argsort(-np.abs(values[0]))]
    for k in range(1, len(values)):
        # Twice the last row minus the one before: where the branch is heading.
        ahead = values[k - 1] if k == 1 else 2 * values[k - 1] - values[k - 2]
        values[k] = values[k][linear_sum_assignment(np.abs(ahead[:, None] - values[k]))[1]]
    return values


def _changes(eigenvalues, kps):
    """Gains at which the number of eigenvalues outside the unit circle changes."""

    def excess(gain, rank):
        return np.sort(np.abs(eigenvalues(gain)))[::-1][rank] - 1

    count = np.sum(np.abs(eigenvalues(kps)) > 1, axis=1)
    change = np.flatnonzero(np.diff(count))
    # Sorted by size, the eigenvalue after those that stay outside is the one that crosses.
    return tuple(
        brentq(excess, kps[k], kps[k + 1], args=(min(count[k], count[k + 1]),)) for k in change
    )


def draw_root_locus(ax, data, frame):
    """Branches with their start and direction, eigenvalues at the marked gain, unit circle."""
    frame_plane(ax, frame)
    zero_lines(ax, "x")
    draw_branches(ax, data, COLORS["blue"])
    ax.plot(data.marked.real, data.marked.imag, "x", color=COLORS["vermillion"], markersize=10,
            markeredgewidth=2.4, zorder=6, label=f"$k_p = {data.kp:g}$: {data.unstable} outside")  # fmt: skip
    unit_circle(ax)
    ax.legend(loc="upper right")
    rest = [f"{_short(b[0])} → {_short(b[-1])}" for b in data.outside(frame)]
    if rest:
        rest = "\n".join(["outside the frame:", *rest])
        ax.text(0.02, 0.03, rest, transform=ax.transAxes, fontsize=10)
    freeze_layout(ax.get_figure())  # where a branch is half way depends on it
    ends = [_last_stretch(branch, frame) for branch in data.branches.T]
    arrowheads(ax, ends, [0.5], COLORS["blue"], least=0.4)


def draw_branches(ax, data, color):
    """Branches, and open circles where they start."""
    ax.plot(data.branches.real, data.branches.imag, color=color, zorder=3)
    start = data.branches[0]
    ax.plot(start.real, start.imag, "o", color=color, markerfacecolor="white", zorder=4,
            label=f"$k_p = {data.kps[0]:g}$")  # fmt: skip


def draw_eigenvalues(ax, values, frame):
    """Eigenvalues in the z-plane, those outside the unit circle in their own look; as `follow`."""
    frame_plane(ax, frame)
    zero_lines(ax)
    unit_circle(ax, label="_")
    edge = dict(markeredgecolor="white", markeredgewidth=0.8, zorder=6)

    def parts(values):
        out = np.abs(values) > 1
        return values[~out], values[out]

    return follow(ax, [look(name, **edge) for name in ("stable", "unstable")], values, parts)


def _last_stretch(branch, frame):
    """The part of a branch inside the frame, after it has left the real axis if it has."""
    b = branch[_within(branch, frame)]
    return b[np.abs(b.imag) > 1e-9] if len(b) and abs(b[-1].imag) > 1e-9 else b


def _within(values, frame):
    (left, right), (low, high) = frame
    return (values.real > left) & (values.real < right) & (values.imag > low) & (values.imag < high)


def _short(value):
    return f"{value.real:.4f}" if abs(value.imag) < 1e-9 else f"{value:.4f}"
