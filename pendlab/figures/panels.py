"""Panels of loop analysis in any frame: Nyquist curves, root loci, smallest singular values.

Computing is apart from drawing. `nyquist`, `full_nyquist`, `root_locus` and `sigma_min` return small
frozen values; each `draw_...(ax, values)` creates its artists once and returns ``update(values)``,
which only changes their data, so that a slider can drive it.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq, linear_sum_assignment

from .._checks import array, found, number
from ..loop import Encirclements, Margins, encirclements, frequency_grid, frequency_response, margins
from ..sampled import align
from .style import COLORS, look

HZ = 2 * np.pi  # rad/s in one hertz
CRITICAL = {1: -1.0}  # of the loop gain with one input; 0 of det(I + P G) with several


@dataclass(frozen=True)
class Nyquist:
    """A curve on the unit circle and what is read off it, up to half the sampling rate.

    Attributes
    ----------
    omega : (N,) rad/s
    curve : (N,) complex, the loop gain L of one input or det(I + L) of several
    critical : the point to go round, -1 for L and 0 for det(I + L)
    marked_omega, marked : (2,) where the curve meets the negative real axis (of L: left of -1)
        and where L meets the unit circle, each time next to the critical point; nan if nowhere
    distance, distance_omega : smallest distance from the critical point, and where (rad/s)
    count : Encirclements
    margins : Margins of a loop with one input, else None
    """

    omega: np.ndarray
    curve: np.ndarray
    critical: float
    marked_omega: np.ndarray
    marked: np.ndarray
    distance: float
    distance_omega: float
    count: Encirclements
    margins: Margins | None


def nyquist(loop, points=1500):
    """`Nyquist` of a sampled loop: L itself for one input, det(I + L) for several."""
    omega = frequency_grid(loop.dt, points)
    curve = _curve(loop, omega)
    if loop.ninputs == 1:
        m = margins(loop)
        at = np.array([m.gain_down_omega, m.phase_omega])
        nearest = m.modulus, m.modulus_omega
    else:
        m, at = None, np.array([_negative_real(loop, omega, curve), np.nan])
        k = int(np.argmin(np.abs(curve)))
        nearest = float(np.abs(curve[k])), float(omega[k])
    marked = np.full(2, complex(np.nan, np.nan))
    marked[np.isfinite(at)] = _curve(loop, at[np.isfinite(at)])
    critical = CRITICAL.get(loop.ninputs, 0.0)
    return Nyquist(omega, curve, critical, at, marked, *nearest, encirclements(loop), m)


def _curve(loop, omega):
    L = frequency_response(loop, omega)
    return L[:, 0, 0] if loop.ninputs == 1 else np.linalg.det(np.eye(loop.ninputs) + L)


def _negative_real(loop, omega, curve):
    """Where det(I + L) meets the negative real axis next to 0, rad/s."""
    imag = lambda w: _curve(loop, [w])[0].imag  # noqa: E731
    change = np.flatnonzero((curve.imag[:-1] * curve.imag[1:] < 0) & (curve.real[:-1] < 0))
    if not len(change):
        return np.nan
    k = change[np.argmax(curve.real[change])]
    return brentq(imag, omega[k], omega[k + 1])


def draw_nyquist(ax, curves, looks, frame=None, paper=None):
    """Nyquist curves near the critical point, their crossings listed in the legend.

    Parameters
    ----------
    ax : axes; curves : sequence of `Nyquist`; looks : one ``look(...)`` for each
    frame : ((left, right), (bottom, top)) of the axes
    paper : None, or for each curve the printed frequencies (real axis, unit circle), Hz, to stand
        beside ours

    Returns
    -------
    update(curves, paper=None) : same number of curves, new data
    """
    (x, y) = ((-2.5, 0.5), (-1.5, 1.5)) if frame is None else np.asarray(frame, dtype=float)
    gain = curves[0].critical == -1.0
    _cross(ax)
    lines, dots = [], []
    for style in looks:
        lines += ax.plot([], [], **style)
        dot = dict(color=style["color"], linestyle="none", markeredgecolor="white", zorder=6)
        dots.append([ax.plot([], [], marker=m, markersize=8, **dot)[0] for m in "vo"])
    if gain:
        circle = np.exp(1j * np.linspace(0, 2 * np.pi, 361))
        ax.plot(circle.real, circle.imag, **look("unit circle"))
    name = f"critical point ${curves[0].critical:g}$"
    ax.plot([curves[0].critical], [0], **look("critical", label=name))
    ax.set(xlim=x, ylim=y, xlabel="real part", ylabel="imaginary part")
    ax.set_aspect("equal", adjustable="box")
    meets = "▼ meets the real axis" + ("   ● meets the unit circle" if gain else "")
    legend = ax.legend(loc="upper left", bbox_to_anchor=(-0.02, -0.12), title=meets, frameon=False)
    legend.set_alignment("left")
    texts = legend.get_texts()

    def update(curves, paper=None):
        for i, data in enumerate(curves):
            lines[i].set_data(data.curve.real, data.curve.imag)
            for dot, value in zip(dots[i], data.marked, strict=True):
                dot.set_data([value.real], [value.imag])
            beside = (None, None) if paper is None else paper[i]
            texts[i].set_text(f"{looks[i]['label']}: {_crossings(data, beside)}")

    update(curves, paper)
    return update


def _crossings(data, beside):
    """What the legend says of one curve's marks, with the printed numbers beside ours."""
    words = []
    for sign, omega, printed in zip("▼●", data.marked_omega, beside, strict=True):
        if np.isfinite(omega):
            paper = "" if printed is None else f" (paper {printed:.2f})"
            words.append(f"{sign} {omega / HZ:.2f} Hz{paper}")
    return "   ".join(words) or "no crossing"


def _cross(ax):
    """The two coordinate axes."""
    for line in (ax.axhline, ax.axvline):
        line(0, color=COLORS["grey"], linewidth=0.8, zorder=1)


@dataclass(frozen=True)
class RootLocus:
    """Eigenvalues of A - B2 k_p C_p C of equation (19) over k_p, one column for each branch.

    Attributes
    ----------
    kps : (N,) V/rad
    branches : (N, n) complex
    kp, marked : the gain to mark and its n eigenvalues
    changes : gains within `kps` at which an eigenvalue meets the unit circle
    """

    kps: np.ndarray
    branches: np.ndarray
    kp: float
    marked: np.ndarray
    changes: tuple

    @property
    def unstable(self):
        """Eigenvalues outside the unit circle at the marked gain."""
        return int(np.sum(np.abs(self.marked) > 1))


def root_locus(model, kps, kp):
    """`RootLocus` of a sampled model with two inputs or more whose last motor holds the upper link.

    `kps` are rising gains (V/rad) to sweep over, `kp` the one to mark.
    """
    kps, kp = array("kps", kps, (None,)), number("kp", kp)
    if len(kps) < 2 or np.any(np.diff(kps) <= 0):
        raise ValueError(f"kps: expected at least 2 rising gains, {found(kps)}; try a linspace.")
    none, one = align(model, 0.0).A, align(model, 1.0).A
    at = lambda gains: none + np.multiply.outer(gains, one - none)  # noqa: E731
    for _ in range(8):  # refined where branches meet and part quickly
        branches = _joined(np.linalg.eigvals(at(kps)).astype(complex))
        wide = np.flatnonzero(np.abs(np.diff(branches, axis=0)).max(axis=1) > 0.002)
        if not len(wide):
            break
        kps = np.insert(kps, wide + 1, (kps[wide] + kps[wide + 1]) / 2)
    marked = np.linalg.eigvals(at(kp)).astype(complex)
    return RootLocus(kps, branches, kp, marked[np.argsort(-np.abs(marked))], _changes(at, kps))


def _joined(values):
    """Rows reordered so that each column follows one eigenvalue."""
    values = values.copy()
    values[0] = values[0][np.argsort(-np.abs(values[0]))]
    for k in range(1, len(values)):
        # Twice the last row minus the one before: where the branch is heading.
        ahead = values[k - 1] if k == 1 else 2 * values[k - 1] - values[k - 2]
        values[k] = values[k][linear_sum_assignment(np.abs(ahead[:, None] - values[k]))[1]]
    return values


def _changes(at, kps):
    """Gains at which the number of eigenvalues outside the unit circle changes."""
    count = np.sum(np.abs(np.linalg.eigvals(at(kps))) > 1, axis=1)
    changes = []
    for k in np.flatnonzero(np.diff(count)):
        order = np.sort([count[k], count[k + 1]])[0]  # the next one by size is the one that crosses
        size = lambda gain, i=order: np.sort(np.abs(np.linalg.eigvals(at(gain))))[::-1][i] - 1
        changes.append(brentq(size, kps[k], kps[k + 1]))
    return tuple(changes)


def draw_root_locus(ax, data, frame=None):
    """Branches with their start and direction, eigenvalues at the marked gain, unit circle.

    `frame` as for `draw_nyquist`; returns update(data) for as many branches.
    """
    (x, y) = ((-1.2, 1.2), (-1.2, 1.2)) if frame is None else np.asarray(frame, dtype=float)
    angle = np.linspace(-np.pi, np.pi, 2001)
    ax.axhline(0, color=COLORS["grey"], linewidth=0.8, zorder=1)
    ax.plot(np.cos(angle), np.sin(angle), **look("unit circle"))
    lines = [ax.plot([], [], color=COLORS["blue"], zorder=3)[0] for _ in data.marked]
    circle = ax.lines[1]
    (start,) = ax.plot([], [], "o", color=COLORS["blue"], markerfacecolor="white", zorder=4)
    (marks,) = ax.plot([], [], "x", color=COLORS["vermillion"], markersize=10, markeredgewidth=2.4,
                       zorder=6)  # fmt: skip
    ax.set(xlim=x, ylim=y, xlabel="real part", ylabel="imaginary part")
    heads = arrowheads(ax, len(data.marked), COLORS["blue"])
    legend = ax.legend([start, marks, circle], [" ", " ", "unit circle"], loc="upper right")

    def update(data):
        for line, branch in zip(lines, data.branches.T, strict=True):
            line.set_data(branch.real, branch.imag)
        start.set_data(data.branches[0].real, data.branches[0].imag)
        marks.set_data(data.marked.real, data.marked.imag)
        inside = lambda b: b[(b.real > x[0]) & (b.real < x[1]) & (b.imag > y[0]) & (b.imag < y[1])]
        point(ax, heads, [inside(b) for b in data.branches.T], (0.5,), least=0.4)
        legend.get_texts()[0].set_text(f"$k_p = {data.kps[0]:g}$")
        legend.get_texts()[1].set_text(f"$k_p = {data.kp:g}$: {data.unstable} outside")

    update(data)
    return update


def sigma_min(loop, omega):
    """Smallest singular value of I + L at `omega` (rad/s): shape (len(omega),)."""
    Rd = np.eye(loop.ninputs) + frequency_response(loop, omega)
    return np.linalg.svd(Rd, compute_uv=False)[:, -1]


def draw_sigma_min(ax, omega, sigmas, looks, dt, frame=None):
    """Smallest singular values in dB over Hz, with the Nyquist frequency 1 / (2 dt).

    Parameters
    ----------
    omega : (N,) rad/s; sigmas : curves (N,); looks : one ``look(...)`` for each
    dt : sampling time, s
    frame : ((lowest, highest) Hz, (lowest, highest) dB)

    Returns
    -------
    update(sigmas)
    """
    (x, y) = ((1e-3, 1e2), (-40, 10)) if frame is None else np.asarray(frame, dtype=float)
    ax.axhline(0, color=COLORS["grey"], linewidth=0.8, zorder=1)
    ax.axvline(0.5 / dt, color=COLORS["grey"], linestyle="-.", linewidth=1.0)
    ax.text(0.48 / dt, y[0], f" Nyquist frequency {0.5 / dt:g} Hz", ha="right", va="bottom",
            rotation=90, fontsize=10, color=COLORS["grey"])  # fmt: skip
    lines = [ax.plot([], [], **style)[0] for style in looks]
    lowest = [
        ax.plot([], [], "o", color=style["color"], markeredgecolor="white", markersize=8, zorder=6)[0]
        for style in looks
    ]
    ax.set(xscale="log", xlim=x, ylim=y, xlabel="frequency in Hz", ylabel="smallest singular value in dB")
    legend = ax.legend(loc="lower left")

    def update(sigmas):
        for i, sigma in enumerate(sigmas):
            dB, k = 20 * np.log10(sigma), int(np.argmin(sigma))
            lines[i].set_data(omega / HZ, dB)
            lowest[i].set_data([omega[k] / HZ], [dB[k]])
            text = f"{looks[i]['label']}: lowest {dB[k]:.1f} dB at {omega[k] / HZ:.2f} Hz"
            legend.get_texts()[i].set_text(text)

    update(sigmas)
    return update


def arrowheads(ax, count, color, size=0.13):
    """`count` arrowheads without shafts, `size` inches long, to be placed by `point`."""
    nothing = np.full(count, np.nan)
    return ax.quiver(
        nothing, nothing, np.ones(count), np.zeros(count), color=color, pivot="mid", zorder=5,
        units="inches", scale_units="inches", scale=1 / size, width=size / 8, headwidth=6.4,
        headlength=8, headaxislength=8, minlength=0,
    )  # fmt: skip


def point(ax, heads, paths, fractions, least=0.2):
    """Put arrowheads at fractions of the drawn length of complex paths of `least` inches or more."""
    (left, right), (low, high) = ax.get_xlim(), ax.get_ylim()
    width, height = ax.get_figure().get_size_inches()
    box = ax.get_position()
    sx, sy = width * box.width / (right - left), height * box.height / (high - low)
    if ax.get_aspect() == 1:
        sx = sy
    places, ways = [], []
    for path in paths:
        on_page = path.real * sx + 1j * path.imag * sy
        length = np.concatenate([[0], np.cumsum(np.abs(np.diff(on_page)))])
        for fraction in fractions:
            if len(path) < 2 or length[-1] < least:
                place, way = np.nan, 1.0
            else:
                k = int(np.clip(np.searchsorted(length, fraction * length[-1]), 1, len(path) - 1))
                place, way = path[k], on_page[k] - on_page[k - 1]
            places.append(place)
            ways.append(way / abs(way) if way else 1.0)
    places, ways = np.array(places, dtype=complex), np.array(ways, dtype=complex)
    heads.set_offsets(np.column_stack([places.real, places.imag]))
    heads.set_UVC(ways.real, ways.imag)
