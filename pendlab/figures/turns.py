"""The whole Nyquist curve and its contour, on a scale that shows every turn.

Distances from the critical point are drawn as log10(1 + distance / NEAR): directions, and so the
turns, stay true, while the far arc that closes the curve comes onto the page. The contour in the
z-plane is drawn in the same way round z = 1, where the integrator and the slow poles crowd.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..loop import ON_CIRCLE, sorted_eigenvalues
from ..nyquist import Encirclements, contour, encirclements
from .frequency import CRITICAL
from .sketch import arrowheads
from .style import COLORS, look

NEAR_CRITICAL, NEAR_ONE = 0.1, 1e-7  # distances below which the scale is linear
RAYS = np.radians(np.arange(2.5, 360, 5))  # directions tried for counting


@dataclass(frozen=True)
class FullNyquist:
    """Upper half of the Nyquist contour and of its image; the rest is the complex conjugate."""

    z: np.ndarray  # (N,) from z = 1 (outside the integrator's pole there) to z = -1
    curve: np.ndarray  # (N,) L(z) of one input or det(I + L(z)) of several
    critical: float  # -1 or 0
    unstable: np.ndarray  # open-loop eigenvalues outside the unit circle
    integrators: int  # how many open-loop eigenvalues lie on it
    count: Encirclements

    @cached_property
    def closed(self):
        """The whole curve relative to the critical point, in the order of anticlockwise z."""
        half = self.curve - self.critical
        return np.concatenate([half, half[::-1].conj()])

    @cached_property
    def ray(self):
        """(direction in rad, distances, signs) of the crossings of one ray from the critical point.

        Anticlockwise crossings count +1; of the directions tried, the one with fewest crossings and
        among these the widest spaced.
        """
        phase, distance = np.unwrap(np.angle(self.closed)), np.abs(self.closed)
        signs = np.diff(np.floor((phase - RAYS[:, None]) / (2 * np.pi))).astype(int)
        crossings = [np.flatnonzero(row) for row in signs]

        def merit(i):
            places = np.sort(compressed(distance[crossings[i]], NEAR_CRITICAL))
            return -len(places), np.diff(places).min(initial=np.inf)

        best = max(range(len(RAYS)), key=merit)
        k = crossings[best]
        return float(RAYS[best]), distance[k], signs[best, k]


def full_nyquist(loop, points=1200):
    """`FullNyquist` of a sampled loop: L for one input, det(I + L) for several."""
    z, curve = contour(loop, points)
    critical = CRITICAL.get(loop.ninputs, 0.0)
    opened = sorted_eigenvalues(loop.A)
    beyond = np.abs(opened) - 1
    unstable, on_it = opened[beyond > ON_CIRCLE], int(np.sum(np.abs(beyond) <= ON_CIRCLE))
    curve = curve + (1 + critical)
    return FullNyquist(z, curve, critical, unstable, on_it, encirclements(loop))


def compressed(distance, near):
    """log10(1 + distance / near)."""
    return np.log10(1 + np.asarray(distance) / near)


def _mapped(values, near):
    """Complex numbers with their distance from 0 compressed and their direction kept."""
    size = np.abs(values)
    return values / np.where(size == 0, 1, size) * compressed(size, near)


HALVES = [  # of contour and image: upper, lower, and the arc round the pole at z = 1
    dict(color=COLORS["black"], label="$0 < \\omega T_s < \\pi$, upper half of the circle"),
    dict(color=COLORS["sky"], linestyle="--", label="lower half: its conjugate"),
    dict(color=COLORS["orange"], linewidth=2.6, label="round the pole at $z=1$"),
]
UNDER = dict(loc="upper center", bbox_to_anchor=(0.5, 0.01), frameon=False)  # the axes: a legend


def _draw_halves(ax, data, near, values, heads):
    """Both halves and the arc of the upper half's `values`, with arrowheads at fractions of each."""
    half = _mapped(values, near)
    bend = np.abs(data.z) > 1 + 1e-12
    on, arc = half[~bend], half[bend]
    pieces = on, on[::-1].conj(), np.concatenate([arc[::-1].conj(), arc])
    for piece, style, at in zip(pieces, HALVES, heads, strict=True):
        ax.plot(piece.real, piece.imag, **style)
        arrowheads(ax, [piece], at, style["color"])


def draw_turns(ax, data):
    """The whole curve round the critical point, its ray and numbered crossings."""
    top = np.ceil(np.log10(np.abs(data.closed).max()))
    _rings(ax, NEAR_CRITICAL, np.logspace(0, top, int(top) + 1), 150)
    ax.plot([0], [0], **look("critical", label=f"critical point ${data.critical:g}$"))
    heads = (0.12, 0.35, 0.6, 0.85), (0.15, 0.4, 0.65, 0.88), (0.25, 0.75)
    _draw_halves(ax, data, NEAR_CRITICAL, data.curve - data.critical, heads)
    if not data.integrators:
        ax.lines[-1].set_label("no pole on the unit circle")
    direction, radii, signs = data.ray
    way = np.exp(1j * direction)
    end = way * ax.get_xlim()[1]
    ax.plot([0, end.real], [0, end.imag], color=COLORS["vermillion"], linewidth=1.2, zorder=4,
            label="ray on which the turns are counted")  # fmt: skip
    disk = dict(boxstyle="circle,pad=0.2", facecolor=COLORS["vermillion"], edgecolor="white")
    name = dict(color="white", fontsize=10, ha="center", va="center", weight="bold", zorder=7)
    for at, count in zip(way * compressed(radii, NEAR_CRITICAL), np.cumsum(signs)):
        ax.text(at.real, at.imag, str(count), bbox=disk, **name)
    ax.set_title("its image, seen from the critical point")
    ax.legend(**UNDER)


def draw_contour(ax, data):
    """The contour round the unit circle with the open-loop poles, seen from z = 1."""
    _rings(ax, NEAR_ONE, [1e-4, 1e-2, 1], 55)
    _draw_halves(ax, data, NEAR_ONE, data.z - 1, ((0.3, 0.75), (0.25, 0.7), (0.25, 0.75)))
    cross = dict(marker="x", linestyle="none", markersize=9, markeredgewidth=2.2)
    one = [0.0] if data.integrators else []
    poles = _mapped(data.unstable - 1, NEAR_ONE)
    marks = ax.plot(one, one, color=COLORS["orange"], **cross)
    marks += ax.plot(poles.real, poles.imag, **look("unstable", zorder=6))
    integrator = "integrator, $z=1$" if data.integrators else "no integrator at $z=1$"
    ax.legend(marks, [integrator, f"{len(poles)} unstable open-loop poles"], **UNDER)
    ax.set_title("contour in the $z$-plane, seen from $z=1$")


def _rings(ax, near, distances, down):
    """Circles of equal distance, labelled `down` degrees below the real axis, axes off."""
    edge = compressed(distances[-1], near)
    round_ = np.exp(1j * np.linspace(0, 2 * np.pi, 181))
    for distance in distances:
        ring = compressed(distance, near) * round_
        ax.plot(ring.real, ring.imag, color="#CFCFCF", linewidth=0.8, zorder=0.5)
        at = np.exp(-1j * np.radians(down)) * abs(ring[0])
        ax.text(at.real, at.imag, _power(distance), fontsize=9, color=COLORS["grey"], ha="center",
                va="center", zorder=3, bbox=dict(facecolor="white", edgecolor="none", pad=0.8))  # fmt: skip
    ax.plot([-1.08 * edge, 1.08 * edge], [0, 0], color=COLORS["grey"], linewidth=0.8, zorder=1)
    ax.text(1.08 * edge, 0.03 * edge, "real", ha="right", va="bottom", fontsize=9)
    ax.set(xlim=(-1.1 * edge, 1.1 * edge), ylim=(-1.1 * edge, 1.1 * edge))
    ax.set_aspect("equal")
    ax.set_axis_off()


def _power(value):
    exponent = round(np.log10(value))
    return f"${value:g}$" if 0 <= exponent < 3 else f"$10^{{{exponent}}}$"
