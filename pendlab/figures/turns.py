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
from .arrows import arrowheads, point
from .frequency import CRITICAL
from .style import COLORS, look

NEAR_CRITICAL, NEAR_ONE = 0.1, 1e-7  # distances below which the scale is linear
RAYS = np.radians(np.arange(2.5, 360, 5))  # directions tried for counting


@dataclass(frozen=True)
class FullNyquist:
    """Upper half of the Nyquist contour and of its image; the rest is the complex conjugate.

    Attributes
    ----------
    z : (N,) complex, from z = 1 (outside the integrator's pole there) to z = -1
    curve : (N,) complex, L(z) of one input or det(I + L(z)) of several
    critical : -1 or 0
    unstable : open-loop eigenvalues outside the unit circle
    integrators : how many open-loop eigenvalues lie on it
    count : Encirclements
    """

    z: np.ndarray
    curve: np.ndarray
    critical: float
    unstable: np.ndarray
    integrators: int
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
        phase = np.unwrap(np.angle(self.closed))
        radius = compressed(np.abs(self.closed), NEAR_CRITICAL)

        def crossings(direction):
            turn = np.floor((phase - direction) / (2 * np.pi))
            k = np.flatnonzero(np.diff(turn))
            return k, np.diff(turn)[k]

        def merit(direction):
            k, _ = crossings(direction)
            spread = np.diff(np.sort(radius[k])).min() if len(k) > 1 else 0.0
            return -len(k), spread

        best = max(RAYS, key=merit)
        k, signs = crossings(best)
        return float(best), np.abs(self.closed[k]), signs.astype(int)


def full_nyquist(loop, points=1200):
    """`FullNyquist` of a sampled loop: L for one input, det(I + L) for several."""
    z, curve = contour(loop, points)
    critical = CRITICAL.get(loop.ninputs, 0.0)
    opened = sorted_eigenvalues(loop.A)
    size = np.abs(opened)
    return FullNyquist(
        z,
        curve + (1 + critical),
        critical,
        opened[size > 1 + ON_CIRCLE],
        int(np.sum(np.abs(size - 1) <= ON_CIRCLE)),
        encirclements(loop),
    )


def compressed(distance, near):
    """log10(1 + distance / near)."""
    return np.log10(1 + np.asarray(distance) / near)


def _mapped(values, near):
    """Complex numbers with their distance from 0 compressed and their direction kept."""
    size = np.abs(values)
    return values / np.where(size == 0, 1, size) * compressed(size, near)


def draw_turns(ax, data):
    """The whole curve round the critical point, the ray and its numbered crossings.

    Returns update(data).
    """
    top = 10 ** np.ceil(np.log10(np.abs(data.closed).max()))
    _rings(ax, NEAR_CRITICAL, np.logspace(0, np.log10(top), int(np.log10(top)) + 1), 120)
    color = COLORS["black"]
    ax.plot([0], [0], **look("critical", label=f"critical point ${data.critical:g}$"))
    (upper,) = ax.plot(
        [], [], color=color, label="$0 < \\omega T_s < \\pi$, upper half of the circle"
    )
    (lower,) = ax.plot(
        [], [], color=COLORS["sky"], linestyle="--", label="lower half: its conjugate"
    )
    (around,) = ax.plot(
        [], [], color=COLORS["orange"], linewidth=2.6, label="round the pole at $z=1$"
    )
    (ray,) = ax.plot([], [], color=COLORS["vermillion"], linewidth=1.2, zorder=4,
                     label="ray on which the turns are counted")  # fmt: skip
    dots = [
        ax.text(0, 0, "", color="white", fontsize=10, ha="center", va="center", weight="bold", zorder=7,
                bbox=dict(boxstyle="circle,pad=0.2", facecolor=COLORS["vermillion"], edgecolor="white"))
        for _ in range(8)
    ]  # fmt: skip
    heads = [
        arrowheads(ax, n, c) for n, c in ((4, color), (4, COLORS["sky"]), (2, COLORS["orange"]))
    ]
    ax.set_title("its image, seen from the critical point")
    legend = ax.legend(loc="upper center", bbox_to_anchor=(0.5, 0.01), frameon=False)

    def update(data):
        half = _mapped(data.curve - data.critical, NEAR_CRITICAL)
        bend = np.abs(data.z) > 1 + 1e-12
        on = half[~bend]
        arc = half[bend]
        upper.set_data(on.real, on.imag)
        lower.set_data(on.real, -on.imag)
        far = np.concatenate([arc[::-1].conj(), arc])
        around.set_data(far.real, far.imag)
        point(ax, heads[0], [on], (0.12, 0.35, 0.6, 0.85))
        point(ax, heads[1], [on[::-1].conj()], (0.15, 0.4, 0.65, 0.88))
        point(ax, heads[2], [far], (0.25, 0.75))
        bend = "round the pole at $z=1$" if data.integrators else "no pole on the unit circle"
        legend.get_texts()[3].set_text(bend)
        direction, radii, signs = data.ray
        way, edge = np.exp(1j * direction), ax.get_xlim()[1]
        ray.set_data([0, edge * way.real], [0, edge * way.imag])
        for dot, r, k in zip(dots, list(radii) + [0] * 8, list(np.cumsum(signs)) + [""] * 8):
            at = way * compressed(r, NEAR_CRITICAL)
            dot.set(position=(at.real, at.imag), text=str(k), visible=k != "")

    update(data)
    return update


def draw_contour(ax, data):
    """The contour round the unit circle with the open-loop poles, seen from z = 1.

    Returns update(data).
    """
    _rings(ax, NEAR_ONE, [1e-4, 1e-2, 1], 55)
    (upper,) = ax.plot([], [], color=COLORS["black"])
    (lower,) = ax.plot([], [], color=COLORS["sky"], linestyle="--")
    (around,) = ax.plot([], [], color=COLORS["orange"], linewidth=2.6)
    (inside,) = ax.plot([], [], "x", color=COLORS["orange"], markersize=9, markeredgewidth=2.2,
                        label="integrator, $z=1$")  # fmt: skip
    (poles,) = ax.plot([], [], **look("unstable", label="unstable", zorder=6))
    heads = [arrowheads(ax, 2, COLORS[c]) for c in ("black", "sky", "orange")]
    ax.set_title("contour in the $z$-plane, seen from $z=1$")
    legend = ax.legend(loc="upper center", bbox_to_anchor=(0.5, 0.01), frameon=False)

    def update(data):
        half = _mapped(data.z - 1, NEAR_ONE)
        bend = np.abs(data.z) > 1 + 1e-12
        on = half[~bend]
        upper.set_data(on.real, on.imag)
        lower.set_data(on.real, -on.imag)
        far = np.concatenate([half[bend][::-1].conj(), half[bend]])
        around.set_data(far.real, far.imag)
        inside.set_data([0.0] if data.integrators else [], [0.0] if data.integrators else [])
        at = _mapped(data.unstable - 1, NEAR_ONE)
        poles.set_data(at.real, at.imag)
        point(ax, heads[0], [on], (0.3, 0.75))
        point(ax, heads[1], [on[::-1].conj()], (0.25, 0.7))
        point(ax, heads[2], [far], (0.25, 0.75))
        at_one = "integrator, $z=1$" if data.integrators else "no integrator at $z=1$"
        legend.get_texts()[0].set_text(at_one)
        legend.get_texts()[1].set_text(f"{len(data.unstable)} unstable open-loop poles")

    update(data)
    return update


def _rings(ax, near, distances, down):
    """Circles of equal distance, labelled `down` degrees below the real axis, axes off."""
    edge = compressed(distances[-1], near)
    round_ = np.exp(1j * np.linspace(0, 2 * np.pi, 181))
    for distance in distances:
        ring = compressed(distance, near) * round_
        ax.plot(ring.real, ring.imag, color="#CFCFCF", linewidth=0.8, zorder=0.5)
        at = np.exp(-1j * np.radians(down)) * abs(ring[0])
        ax.text(at.real, at.imag, _power(distance), fontsize=9, color=COLORS["grey"], ha="center",
                va="center", zorder=2, bbox=dict(facecolor="white", edgecolor="none", pad=0.8))  # fmt: skip
    ax.plot([-1.08 * edge, 1.08 * edge], [0, 0], color=COLORS["grey"], linewidth=0.8, zorder=1)
    ax.text(1.08 * edge, 0.03 * edge, "real", ha="right", va="bottom", fontsize=9)
    ax.set(xlim=(-1.1 * edge, 1.1 * edge), ylim=(-1.1 * edge, 1.1 * edge))
    ax.set_aspect("equal")
    ax.set_axis_off()


def _power(value):
    exponent = round(np.log10(value))
    return f"${value:g}$" if 0 <= exponent < 3 else f"$10^{{{exponent}}}$"
