"""Schematic of a rig from its parameters (Figs 2, 3), for any number of links.

The other drawings, apparatus (Fig 1), block diagrams (Figs 4, 5, 9) and moving pendulum, are at
hand here too.
"""

import math

import numpy as np
from matplotlib.patches import Arc

from .apparatus import apparatus, plural
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


@styled()
def schematic(rig, angles=None):
    """Figs 2 and 3: lengths l_i, centres of mass a_i, angles theta_i, torques T_i, to scale.

    Parameters
    ----------
    rig : Pendulum with n links
    angles : (n,) relative angles, rad, at which to draw it; a clear lean if None

    theta_i is the angle of link i from the vertical; T_i acts on link i+1 as drawn and with the
    opposite sign on link i. The length of the last link enters no equation.
    """
    n = check_rig(rig).n_links
    if angles is None:
        # Bent outwards, so that dimensions on the outer side do not meet.
        angles = [0.2] + [1 / n] * (n - 1)
    angles = check_angles(rig, angles)
    theta, points = np.cumsum(angles), joints(rig, angles)
    fig, ax = canvas(7, 5.8)
    unit = _frame(ax, points, min(link.length for link in rig.links))
    ground = points[0][1]
    ax.plot([-0.6 * unit, 0.6 * unit], [ground, ground], color=COLORS["grey"], linewidth=3)
    for i, link in enumerate(rig.links, 1):
        _link(ax, i, link, points[i - 1], points[i], theta[i - 1], unit, i == n, n <= 4)
    for i in range(1, n + 1):
        driven = 2 <= i <= rig.n_motors + 1
        ax.plot(
            *points[i - 1],
            marker="o",
            markersize=9,
            markeredgewidth=1.6,
            zorder=6,
            markeredgecolor="black",
            markerfacecolor="black" if driven else "white",
        )
        if driven:
            _torque(ax, i - 1, points[i - 1], theta[i - 2], unit)
        if 1 < i == n <= 3:  # elsewhere there is no room for it
            _relative(ax, i, points[i - 1], theta[i - 2 : i], unit)
    _values(fig, rig)
    mass, height = _upright_centre(rig)
    number = {2: "2", 3: "3"}.get(n)
    head = f"Fig {number}. " if number else ""
    return describe(
        fig,
        f"{head}Upright, the {rig.name} pendulum carries {mass:.3g} kg centred {height:.3g} m above "
        f"a hinge that no motor turns; its {plural(rig.n_motors, 'torque')} can only bend it, "
        f"{'each ' * (rig.n_motors > 1)}acting on two neighbouring links with opposite signs.",
        f"Schematic of {plural(n, 'link')} to scale. Each link leans by an angle theta_i from the "
        f"vertical; marked are its length l_i, the distance a_i from its lower hinge to its centre "
        f"of mass, mass m_i and moment of inertia I_i, and a torque T_i at each driven hinge. "
        + f"The relative angle of link {n} is marked from link {n - 1} drawn on. " * (1 < n <= 3)
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
    scale = min(
        (4.2 - 2 * edge - 0.3) / max(right - left, 1e-9),
        (height - 2 * edge) / max(high - low, 1e-9),
    )  # inches per metre
    x0 = left - (edge + 0.3) / scale
    y0 = (low + high) / 2 - height / 2 / scale
    ax.set(xlim=(x0, x0 + width / scale), ylim=(y0, y0 + height / scale))
    return min(shortest, 1.1 / scale)


def _link(ax, i, link, lower, upper, theta, unit, last, named):
    """One link with its dimensions; those stand on the side away from the vertical."""
    color = link_color(i)
    along = np.array([math.sin(theta), math.cos(theta)])
    side = np.array([along[1], -along[0]]) * (1 if theta >= 0 else -1)
    ax.plot(
        *zip(lower, upper),
        color=color,
        linewidth=0.55 * _size(ax, unit),
        solid_capstyle="round",
        zorder=3,
    )
    centre = lower + link.com * along
    ax.plot(*centre, marker="o", markersize=9, color="white", markeredgecolor=INK, zorder=5)
    ax.plot(*centre, marker="+", markersize=9, color=INK, zorder=6)
    # to the left of the link, above the arc of its angle
    if named:
        name = centre - 0.13 * unit * side
        ax.text(*name, f"$m_{i}, I_{i}$", ha="right" if theta >= 0 else "left", va="center")
    ax.plot(
        [lower[0]] * 2,
        [lower[1], lower[1] + 0.62 * unit],
        color=COLORS["grey"],
        linestyle="--",
        linewidth=1.1,
        zorder=2,
    )
    _angle(ax, i, lower, theta, 0.5 * unit)
    _dimension(ax, f"$a_{i}$", lower, centre, 0.17 * unit * side, unit)
    if not last:
        _dimension(ax, f"$l_{i}$", lower, upper, 0.47 * unit * side, unit)


def _size(ax, unit):
    """Font size that suits fittings of this unit (m): 11 points, less where links are short."""
    inches = unit * 7.0 / (ax.get_xlim()[1] - ax.get_xlim()[0])
    return min(11.0, max(7.5, 12.5 * inches))


def _angle(ax, i, at, theta, radius):
    """The arc from the vertical to the link."""
    first, last = sorted([90.0, 90.0 - math.degrees(theta)])
    ax.add_patch(
        Arc(at, 2 * radius, 2 * radius, theta1=first, theta2=last, color=INK, linewidth=1.3)
    )
    # A narrow angle has no room for its name, which then stands across the vertical.
    turn, reach = (theta / 2, 0.74) if abs(theta) > 0.45 else (math.copysign(0.45, -theta), 0.6)
    ax.text(
        at[0] + math.sin(turn) * reach * radius,
        at[1] + math.cos(turn) * reach * radius,
        rf"$\theta_{i}$",
        ha="center",
        va="center",
        fontsize=_size(ax, 2 * radius),
        zorder=7,
        bbox=dict(facecolor="white", edgecolor="none", pad=0.4),
    )


def _relative(ax, i, at, theta, unit):
    """Link i-1 drawn on, dotted, and the arc from there to link i: what a potentiometer reads."""
    before, after = theta
    far, radius = 1.1 * unit, 0.9 * unit
    ax.plot(
        [at[0], at[0] + far * math.sin(before)],
        [at[1], at[1] + far * math.cos(before)],
        color=link_color(i - 1),
        linestyle=":",
        linewidth=1.6,
        zorder=2,
    )
    first, last = sorted(90.0 - math.degrees(angle) for angle in (before, after))
    ax.add_patch(
        Arc(at, 2 * radius, 2 * radius, theta1=first, theta2=last, color=link_color(i), linewidth=2)
    )
    ax.text(
        at[0] + far * math.sin(before) - 0.06 * unit,
        at[1] + (far - 0.15 * unit) * math.cos(before),
        look(angle_name(i))["label"] if i <= 6 else "",
        ha="right",
        va="center",
        color=link_color(i),
        fontsize=1.15 * _size(ax, 2 * radius),
        zorder=7,
    )


def _dimension(ax, text, start, end, offset, unit):
    """A dimension line beside a link, with its two extension lines."""
    a, b = start + offset, end + offset
    for point in (start, end):
        ax.plot(
            *zip(point + 0.25 * offset, point + 1.08 * offset),
            color=COLORS["grey"],
            linewidth=0.8,
            zorder=1,
        )
    style = dict(
        arrowstyle="<|-|>", color=INK, linewidth=1.0, shrinkA=0, shrinkB=0, mutation_scale=9
    )
    ax.annotate("", b, a, arrowprops=style)
    ax.text(
        *(a + b) / 2,
        text,
        ha="center",
        va="center",
        zorder=7,
        fontsize=_size(ax, unit),
        bbox=dict(facecolor="white", edgecolor="none", pad=0.8),
    )


def _torque(ax, i, at, theta, unit):
    """A clockwise arrow round a driven hinge: positive torque on the upper of its two links."""
    radius = 0.24 * unit
    bend = np.radians(np.linspace(215, 125, 30))
    xs, ys = at[0] + radius * np.cos(bend), at[1] + radius * np.sin(bend)
    color = look("u1")["color"]
    ax.plot(xs, ys, color=color, linewidth=2, zorder=4)
    ax.annotate(
        "",
        (xs[-1] + 0.02 * unit, ys[-1] + 0.015 * unit),
        (xs[-3], ys[-3]),
        zorder=4,
        arrowprops=dict(arrowstyle="-|>", color=color, mutation_scale=14, shrinkA=0, shrinkB=0),
    )
    ax.text(
        at[0] - 1.2 * radius,
        at[1] + 0.55 * radius,
        f"$T_{i}$",
        ha="right",
        va="center",
        fontsize=_size(ax, unit),
        zorder=7,
    )


def _values(fig, rig):
    """The column of values at the right of the page, upper links above lower ones."""
    n = rig.n_links
    left, size, line = (0.645, 10, 0.038) if n <= 4 else (0.615, 9, 0.032)
    y = 0.95
    for i in range(n, 0, -1):
        link, drawn = rig.links[i - 1], " (drawn only)" if i == n else ""
        fig.text(
            left, y, f"link {i}", color=link_color(i), weight="bold", va="top", fontsize=size + 1
        )
        rows = [
            f"$l_{i}$ = {link.length:g} m{drawn}",
            f"$a_{i}$ = {link.com:.4g} m,  $m_{i}$ = {link.mass:.4g} kg",
            f"$I_{i}$ = {link.inertia:.4g} kg m²",
        ]
        if n > 4:  # two links' worth of lines in the space of one
            rows = [rows[1], f"{rows[0]},  {rows[2]}".replace(" (drawn only)", "")]
        for row, text in enumerate(rows, 1):
            fig.text(left, y - (row + 0.1) * line, text, fontsize=size, va="top")
        y -= (len(rows) + 1.55) * line
    fig.text(left, y, "motors at standstill", weight="bold", va="top", fontsize=size + 1)
    for i in range(rig.n_motors, 0, -1):
        y -= 1.1 * line
        limit = rig.u_max[i - 1]
        bound = f",  $|u_{i}|$ ≤ {limit:g} V" if math.isfinite(limit) else ""
        text = f"$T_{i}$ = {rig.motors[i - 1].gain:.3g} $u_{i}$ N m{bound}"
        fig.text(left, y, text, fontsize=size, va="top")
