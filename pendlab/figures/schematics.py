"""Drawings of a rig from its parameters: the apparatus (Fig 1) and its schematic (Figs 2, 3).

Both take any rig of two links or more. The block diagrams of Figs 4, 5, 9 and the moving pendulum
are at hand here too.
"""

import math

import numpy as np
from matplotlib.patches import Arc, Rectangle

from .blocks import INK, apparatus_blocks, canvas, observer_blocks, triple_loops
from .moving import animate_svg, check_angles, check_rig, draw_pendulum, joints, link_color
from .style import COLORS, angle_name, describe, look, styled

__all__ = [
    "animate_svg",
    "apparatus",
    "apparatus_blocks",
    "draw_pendulum",
    "joints",
    "observer_blocks",
    "schematic",
    "triple_loops",
]

_ORDER = {2: ("lower", "upper"), 3: ("lower", "middle", "upper")}
_COUNT = {1: "one", 2: "two", 3: "three", 4: "four", 5: "five", 6: "six"}


def _hinge_name(rig, i):
    return f"{_ORDER[rig.n_links][i - 1]} hinge" if rig.n_links in _ORDER else f"hinge {i}"


def _plural(count, word):
    return f"{_COUNT.get(count, count)} {word}{'s' * (count != 1)}"


# Fig 1


@styled()
def apparatus(rig):
    """Fig 1: the rig from the front, hinge axes across the page, link lengths to scale.

    Each hinge is split: on the left a shaft with a potentiometer, on the right the output shaft of
    a motor with gearbox, or at the lowest, free hinge a tachometer.
    """
    n = check_rig(rig).n_links
    lengths = [link.length for link in rig.links]
    heights = np.concatenate([[0.0], np.cumsum(lengths)])
    # Size of the fittings: about the tube's 50 mm, less where links are short.
    d = min(0.055 * heights[-1], 0.36 * min(lengths))
    low, high = -0.14 * heights[-1], 1.03 * heights[-1]
    fig, ax = canvas(7, 5.8)
    half = (high - low) * 7 / 5.8 / 2
    ax.set(xlim=(-half, half), ylim=(low, high))
    _stand(ax, d, low)
    for i in range(1, n + 1):
        _tube(ax, d, heights[i - 1], heights[i], link_color(i), last=i == n)
    for i in range(1, n + 1):
        _hinge(ax, rig, i, d, heights[i - 1])
    for i, link in enumerate(rig.links, 1):
        text = f"link {i}:  {link.length:g} m,  {link.mass:.3g} kg"
        middle = (heights[i - 1] + heights[i]) / 2
        _pointer(ax, text, (0.4 * d, middle), (0.26 * half, middle), color=link_color(i))
    m = rig.n_motors
    return describe(
        fig,
        f"Fig 1. The {rig.name} pendulum has {_plural(n, 'link')} but only {_plural(m, 'motor')}: "
        f"the lowest hinge, on which everything stands, turns freely and is only measured.",
        f"Front view of {_plural(n, 'tube')} one above the other on a stand, joined by hinges. "
        f"Left of each hinge a potentiometer, pot 1 to pot {n}; right of hinge 1 a tachometer; "
        f"right of {', '.join(_hinge_name(rig, i + 1) for i in range(1, m + 1))} "
        f"a motor with gearbox. Link lengths from below: "
        f"{', '.join(f'{length:g} m' for length in lengths)}.",
    )


def _rect(ax, left, bottom, width, height, face, zorder=3):
    ax.add_patch(
        Rectangle((left, bottom), width, height, facecolor=face, edgecolor=INK, linewidth=1.1,
                  zorder=zorder)  # fmt: skip
    )


def _tube(ax, d, bottom, top, color, last):
    """A link: tube between the forks of its two hinges, in the colour of its angle."""
    end = top if last else top - 0.55 * d
    _rect(ax, -0.36 * d, bottom + 0.55 * d, 0.72 * d, end - bottom - 0.55 * d, color)


def _stand(ax, d, low):
    _rect(ax, -0.36 * d, low + 0.35 * d, 0.72 * d, -low - 0.9 * d, COLORS["pale"])
    _rect(ax, -2.4 * d, low + 0.1 * d, 4.8 * d, 0.25 * d, COLORS["grey"])


def _fork(ax, y, d, reach, way):
    """Two side plates from the hinge at height y down (way = -1) or up (+1), and their bridge."""
    plate = 0.09 * d
    bottom = y - 0.55 * d if way < 0 else y - 0.22 * d
    for side in (-1, 1):
        _rect(ax, side * reach * d - plate / 2, bottom, plate, 0.77 * d, "#C9CED6", zorder=4)
    bridge = y + way * 0.55 * d - plate / 2
    _rect(ax, -reach * d - plate / 2, bridge, 2 * reach * d + plate, plate, "#C9CED6", zorder=4)


def _hinge(ax, rig, i, d, y):
    """Hinge i at height y: two forks, shafts, a pot on the left, motor or tacho on the right."""
    shaft = 0.12 * d
    _fork(ax, y, d, 0.85, -1)
    _fork(ax, y, d, 0.6, 1)
    _rect(ax, -1.2 * d, y - shaft / 2, 0.75 * d, shaft, "white", zorder=5)
    _rect(ax, 0.45 * d, y - shaft / 2, 0.75 * d, shaft, "white", zorder=5)
    _rect(ax, -1.75 * d, y - 0.25 * d, 0.6 * d, 0.5 * d, "white", zorder=6)
    edge = ax.get_xlim()[1] * 0.36
    _pointer(ax, f"pot {i}:  {look(angle_name(i))['label']}" if i <= 6 else f"pot {i}",
             (-1.75 * d, y), (-edge, y), ha="right", color=link_color(i))  # fmt: skip
    if i == 1:
        _rect(ax, 1.15 * d, y - 0.22 * d, 0.7 * d, 0.44 * d, look("rate")["color"], zorder=6)
        _pointer(ax, r"tachometer:  $\dot\theta_1$" + "\n(no motor: free hinge)",
                 (1.85 * d, y), (edge, y))  # fmt: skip
    elif i - 1 <= rig.n_motors:
        motor, limit = rig.motors[i - 2], rig.u_max[i - 2]
        _rect(ax, 1.15 * d, y - 0.3 * d, 0.75 * d, 0.6 * d, COLORS["grey"], zorder=6)
        _rect(ax, 1.9 * d, y - 0.24 * d, 1.1 * d, 0.48 * d, "#3B3B3B", zorder=6)
        place = f" ({_hinge_name(rig, i)})" if rig.n_links in _ORDER else ""
        text = f"motor {i - 1}{place}"
        values = f"gearbox {motor.ratio:g} : 1,  {motor.gain:.3g} N m/V"
        bound = f"\n$|u_{i - 1}|$ ≤ {limit:g} V" if math.isfinite(limit) and rig.n_links < 5 else ""
        _pointer(ax, f"{text}\n{values}{bound}", (3.0 * d, y), (edge, y))
    else:
        _pointer(ax, "bearing, no motor", (1.2 * d, y), (edge, y))


def _pointer(ax, text, start, at, ha="left", color=INK):
    """A label at `at` with a thin line from the part it names."""
    gap = 0.012 * ax.get_xlim()[1] * (1 if ha == "left" else -1)
    ax.plot([start[0], at[0]], [start[1], at[1]], color=color, linewidth=1.0, zorder=2)
    ax.text(at[0] + gap, at[1], text, ha=ha, va="center", fontsize=10, linespacing=1.25)


# Figs 2 and 3


@styled()
def schematic(rig, angles=None):
    """Figs 2 and 3: lengths l_i, centres of mass a_i, angles theta_i, torques T_i, to scale.

    Parameters
    ----------
    rig : Pendulum with n links
    angles : (n,) relative angles, rad, at which to draw it; a slight bend if None

    theta_i is the angle of link i from the vertical; T_i acts on link i+1 as drawn and with the
    opposite sign on link i. The length of the last link enters no equation.
    """
    n = check_rig(rig).n_links
    if angles is None:
        angles = [0.34] + [0.16 if i % 2 else -0.16 for i in range(1, n)]
    angles = check_angles(rig, angles)
    theta, points = np.cumsum(angles), joints(rig, angles)
    fig, ax = canvas(7, 5.8)
    unit = _frame(ax, points, min(link.length for link in rig.links))
    ground = points[0][1]
    ax.plot([-0.6 * unit, 0.6 * unit], [ground, ground], color=COLORS["grey"], linewidth=3)
    for i, link in enumerate(rig.links, 1):
        _link(ax, i, link, points[i - 1], points[i], theta[i - 1], unit, last=i == n)
    for i in range(1, n + 1):
        driven = 2 <= i <= rig.n_motors + 1
        ax.plot(*points[i - 1], marker="o", markersize=9, markeredgewidth=1.6, zorder=6,
                markeredgecolor="black", markerfacecolor="black" if driven else "white")  # fmt: skip
        if driven:
            _torque(ax, i - 1, points[i - 1], theta[i - 2], unit)
    _values(fig, rig)
    mass, height = _upright_centre(rig)
    number = {2: "2", 3: "3"}.get(n)
    head = f"Fig {number}. " if number else ""
    return describe(
        fig,
        f"{head}Upright, the {rig.name} pendulum carries {mass:.3g} kg centred {height:.3g} m above "
        f"a hinge that no motor turns; each of the {_plural(rig.n_motors, 'torque')} only bends it, "
        f"acting on two neighbouring links with opposite signs.",
        f"Schematic of {_plural(n, 'link')} to scale. Each link leans by an angle theta_i from the "
        f"vertical; marked are its length l_i, the distance a_i from its lower hinge to its centre "
        f"of mass, mass m_i and moment of inertia I_i, and a torque T_i at each driven hinge. "
        + " ".join(
            f"Link {i}: a = {link.com:.4g} m, m = {link.mass:.4g} kg, I = {link.inertia:.4g} kg m^2, "
            f"drawn at theta = {angle:.2f} rad."
            for i, (link, angle) in enumerate(zip(rig.links, theta), 1)
        ),
    )


def _upright_centre(rig):
    """Mass (kg) and height of the centre of mass above hinge 1 (m) of the upright rig."""
    below = np.concatenate([[0.0], np.cumsum([link.length for link in rig.links])])
    mass = sum(link.mass for link in rig.links)
    moment = sum(link.mass * (y + link.com) for link, y in zip(rig.links, below))
    return mass, moment / mass


def _frame(ax, points, shortest):
    """Limits that put the drawing on the left of the page; returns the unit of its fittings."""
    (left, low), (right, high) = points.min(axis=0), points.max(axis=0)
    width, height = 7.0, 5.8
    edge = 0.5
    scale = min((4.2 - 2 * edge - 0.3) / max(right - left, 1e-9),
                (height - 2 * edge) / max(high - low, 1e-9))  # inches per metre  # fmt: skip
    x0 = left - (edge + 0.3) / scale
    y0 = (low + high) / 2 - height / 2 / scale
    ax.set(xlim=(x0, x0 + width / scale), ylim=(y0, y0 + height / scale))
    return min(shortest, 1.1 / scale)


def _link(ax, i, link, lower, upper, theta, unit, last):
    """One link with its dimensions; those stand on the side away from the vertical."""
    color = link_color(i)
    along = np.array([math.sin(theta), math.cos(theta)])
    side = np.array([along[1], -along[0]]) * (1 if theta >= 0 else -1)
    ax.plot(*zip(lower, upper), color=color, linewidth=6, solid_capstyle="round", zorder=3)
    centre = lower + link.com * along
    ax.plot(*centre, marker="o", markersize=9, color="white", markeredgecolor=INK, zorder=5)
    ax.plot(*centre, marker="+", markersize=9, color=INK, zorder=6)
    # to the left of the link, above the arc of its angle
    name = centre - 0.13 * unit * side
    ax.text(*name, f"$m_{i}, I_{i}$", ha="right" if theta >= 0 else "left", va="center", zorder=7)
    ax.plot([lower[0]] * 2, [lower[1], lower[1] + 0.62 * unit], color=COLORS["grey"],
            linestyle="--", linewidth=1.1, zorder=2)  # fmt: skip
    _angle(ax, i, lower, theta, 0.5 * unit)
    _dimension(ax, f"$a_{i}$", lower, centre, 0.17 * unit * side)
    if not last:
        _dimension(ax, f"$l_{i}$", lower, upper, 0.47 * unit * side)


def _angle(ax, i, at, theta, radius):
    """The arc from the vertical to the link."""
    first, last = sorted([90.0, 90.0 - math.degrees(theta)])
    ax.add_patch(Arc(at, 2 * radius, 2 * radius, theta1=first, theta2=last, color=INK, linewidth=1.3))
    ax.text(at[0] + math.sin(theta / 2) * 0.74 * radius, at[1] + math.cos(theta / 2) * 0.74 * radius,
            rf"$\theta_{i}$", ha="center", va="center", fontsize=11, zorder=7)  # fmt: skip


def _dimension(ax, text, start, end, offset):
    """A dimension line beside a link, with its two extension lines."""
    a, b = start + offset, end + offset
    for point in (start, end):
        ax.plot(*zip(point + 0.25 * offset, point + 1.08 * offset), color=COLORS["grey"],
                linewidth=0.8, zorder=1)  # fmt: skip
    style = dict(arrowstyle="<|-|>", color=INK, linewidth=1.0, shrinkA=0, shrinkB=0,
                 mutation_scale=9)  # fmt: skip
    ax.annotate("", b, a, arrowprops=style)
    ax.text(*(a + b) / 2, text, ha="center", va="center", zorder=7,
            bbox=dict(facecolor="white", edgecolor="none", pad=1.0))  # fmt: skip


def _torque(ax, i, at, theta, unit):
    """A clockwise arrow round a driven hinge: positive torque on the upper of its two links."""
    radius = 0.24 * unit
    bend = np.radians(np.linspace(215, 125, 30))
    xs, ys = at[0] + radius * np.cos(bend), at[1] + radius * np.sin(bend)
    color = look("u1")["color"]
    ax.plot(xs, ys, color=color, linewidth=2, zorder=4)
    ax.annotate("", (xs[-1] + 0.02 * unit, ys[-1] + 0.015 * unit), (xs[-3], ys[-3]), zorder=4,
                arrowprops=dict(arrowstyle="-|>", color=color, mutation_scale=14, shrinkA=0,
                                shrinkB=0))  # fmt: skip
    ax.text(at[0] - 1.35 * radius, at[1], f"$T_{i}$", ha="right", va="center", zorder=7)


def _values(fig, rig):
    """The column of values at the right of the page, upper links above lower ones."""
    n, m = rig.n_links, rig.n_motors
    step = min(0.19, 0.9 / (n + 0.6 + m * 0.28))
    for row, i in enumerate(range(n, 0, -1)):
        link, y = rig.links[i - 1], 0.93 - row * step
        drawn = f"$l_{i}$ = {link.length:g} m" + (" (drawn only)" if i == n else "")
        fig.text(0.645, y, f"link {i}", color=link_color(i), weight="bold", va="top")
        fig.text(0.645, y - 0.042,
                 f"{drawn}\n$a_{i}$ = {link.com:.4g} m,  $m_{i}$ = {link.mass:.4g} kg\n"
                 f"$I_{i}$ = {link.inertia:.4g} kg m²",
                 fontsize=10, va="top", linespacing=1.3)  # fmt: skip
    y = 0.93 - n * step
    lines = [
        f"$T_{i}$ = {motor.gain:.3g} $u_{i}$ N m"
        + (f",  $|u_{i}|$ ≤ {limit:g} V" if math.isfinite(limit) else "")
        for i, (motor, limit) in reversed(list(enumerate(zip(rig.motors, rig.u_max), 1)))
    ]
    fig.text(0.645, y, "motors at standstill", weight="bold", va="top")
    fig.text(0.645, y - 0.042, "\n".join(lines), fontsize=10, va="top", linespacing=1.4)
