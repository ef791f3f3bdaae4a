"""Curves over frequency: Nyquist near the critical point, smallest singular value.

Computing is apart from drawing: `nyquist` and `sigma_min` return frozen values, `draw_loops` and
`draw_sigma_min` create their artists once and return ``update(values)``, which only moves them.
"""

from dataclasses import dataclass

import numpy as np

from ..loop import Margins, frequency_response, least, margins
from ..nyquist import Encirclements, encirclements
from ..paper.recomputed import det_crossing
from .picture import follow
from .sketch import frame_plane, unit_circle, zero_lines
from .style import COLORS, look

LOOKS = [look("nominal", label="without filters"), look("filters")]  # of one loop's curves
HZ = 2 * np.pi  # rad/s in one hertz
CRITICAL = {1: -1.0}  # of the loop gain with one input; 0 of det(I + P G) with several


@dataclass(frozen=True)
class Nyquist:
    """A curve on the unit circle and what is read off it, up to half the sampling rate."""

    omega: np.ndarray  # (N,) rad/s
    curve: np.ndarray  # (N,) complex, the loop gain L of one input or det(I + L) of several
    critical: float  # the point to go round: -1 for L, 0 for det(I + L)
    # (2,) where the curve meets the negative real axis (of L: left of -1) and where L meets the
    # unit circle, each time next to the critical point; nan if nowhere
    marked_omega: np.ndarray
    marked: np.ndarray
    distance: float  # smallest distance from the critical point, and where
    distance_omega: float
    count: Encirclements
    margins: Margins | None  # of a loop with one input


def filter_lag(filters, hz):
    """Phase lag in degrees of the slowest input and output filter in a row at `hz`."""
    slowest = min(filters.input_hz), min(filters.output_hz)
    return sum(np.degrees(np.arctan(hz / cut_off)) for cut_off in slowest)


def frequencies(dt, points=3000):
    """Frequencies (rad/s) up to pi/dt for drawing: dense in the three decades that show."""
    top = np.pi / dt
    few = points // 10
    low = np.geomspace(1e-6 * top, 1e-3 * top, few, endpoint=False)
    return np.concatenate([low, np.geomspace(1e-3 * top, top, points - few)])


def nyquist(loop, points=3000):
    """`Nyquist` of a sampled loop: L itself for one input, det(I + L) for several."""
    omega = frequencies(loop.dt, points)
    curve = _curve(loop, omega)
    if loop.ninputs == 1:
        m = margins(loop)
        at = np.array([m.gain_down_omega, m.phase_omega])
        nearest = m.modulus, m.modulus_omega
    else:
        m, at = None, np.array([det_crossing(loop, omega, curve), np.nan])
        nearest = least(lambda w: np.abs(_curve(loop, w)), omega)
    marked = np.full(2, complex(np.nan, np.nan))
    marked[np.isfinite(at)] = _curve(loop, at[np.isfinite(at)])
    critical = CRITICAL.get(loop.ninputs, 0.0)
    return Nyquist(omega, curve, critical, at, marked, *nearest, encirclements(loop), m)


def _curve(loop, omega):
    L = frequency_response(loop, omega)
    return L[:, 0, 0] if loop.ninputs == 1 else np.linalg.det(np.eye(loop.ninputs) + L)


def draw_loops(ax, curves, looks, frame):
    """Nyquist curves with their marks near the critical point; as `follow`.

    A look for each of the curves, the frame ((left, right), (bottom, top)) of the axes.
    """
    frame_plane(ax, frame)
    ax.set_aspect("equal", adjustable="box")
    zero_lines(ax)
    styles = []
    for style in looks:
        dot = dict(color=style["color"], markeredgecolor="white", markersize=7, zorder=4)
        styles += [style, *({**dot, "marker": marker, "linestyle": "none"} for marker in "vo")]

    def points(curves):
        return [part for data in curves for part in (data.curve, *data.marked)]

    update = follow(ax, styles, curves, points)
    critical = curves[0].critical
    if critical == -1.0:
        unit_circle(ax)
    ax.plot([critical], [0], **look("critical", label=f"critical point ${critical:g}$"))
    return update


@dataclass(frozen=True)
class SmallestSingularValue:
    """Smallest singular value of I + L up to pi/dt, its lowest value and where."""

    omega: np.ndarray  # (N,) rad/s
    sigma: np.ndarray
    lowest: float
    lowest_omega: float


def sigma_min(loop, points=1200):
    """`SmallestSingularValue` of I + L(e^(j omega dt)), equation (35), for a sampled loop."""

    def smallest(omega):
        Rd = np.eye(loop.ninputs) + frequency_response(loop, omega)
        return np.linalg.svd(Rd, compute_uv=False)[:, -1]

    omega = frequencies(loop.dt, points)
    sigma = smallest(omega)
    return SmallestSingularValue(omega, sigma, *least(smallest, omega))


def decibels(ratio):
    """20 log10 of a ratio."""
    return 20 * np.log10(ratio)


def draw_sigma_min(ax, curves, looks, frame):
    """Smallest singular values, dB over Hz, lowest points, Nyquist frequency; as `follow`."""
    zero_lines(ax, "x")
    ax.set(xscale="log", xlim=frame[0], ylim=frame[1])
    ax.set(xlabel="frequency in Hz", ylabel="smallest singular value in dB")
    dot = dict(marker="o", linestyle="none", markeredgecolor="white", markersize=7, zorder=6)
    lowest = [{**dot, "color": style["color"]} for style in looks]
    end = dict(color=COLORS["grey"], linestyle="-.", linewidth=1.0)

    def points(curves):
        top = curves[0].omega[-1] / HZ
        yield [top, top], frame[1]
        yield from ((data.omega / HZ, decibels(data.sigma)) for data in curves)
        yield from (([data.lowest_omega / HZ], [decibels(data.lowest)]) for data in curves)

    return follow(ax, [end, *looks, *lowest], curves, points)
