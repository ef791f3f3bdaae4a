"""Schematic of a rig from its parameters (Figs 2, 3), for any number of links."""

import math

import numpy as np
from matplotlib.patches import Arc

from .._arguments import array
from .apparatus import limit_of, plural
from .moving import check_rig, joints, link_color
from .sketch import INK, arrow, canvas, line, note
from .style import COLORS, angle_label, describe, look, styled

ON_WHITE = dict(facecolor="white", edgecolor="none", pad=0.8)


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
    angles = array("angles", angles, (n,))
    theta, points = np.cumsum(angles), joints(rig, angles)
    fig, ax = canvas(7, 5.8)
    unit, size = _frame(ax, points, min(link.length for link in rig.links))
    line(ax, (-0.6 * unit, 0), (0.6 * unit, 0), color=COLORS["grey"], linewidth=3)
    for i, link in enumerate(rig.links, 1):
        _link(ax, i, link, points[i - 1 : i + 1], theta[i - 1], unit, size, rig)
        driven = 2 <= i <= rig.n_motors + 1
        _mark(ax, points[i - 1], color="black" if driven else "white", markeredgewidth=1.6)
        if driven:
            _torque(ax, i - 1, points[i - 1], unit, size)
        if 1 < i == n <= 3:  # elsewhere there is no room for it
            _relative(ax, i, points[i - 1], theta[i - 2 : i], unit)
    _values(fig, rig)
    mass, height = _upright_centre(rig)
    head = f"Fig {n}. " if n in (2, 3) else ""
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
    masses = np.array([link.mass for link in rig.links])
    heights = joints(rig, np.zeros(rig.n_links))[:-1, 1] + [link.com for link in rig.links]
    return masses.sum(), masses @ heights / masses.sum()


def _frame(ax, points, shortest):
    """Limits that put the drawing on the left of the page; unit (m) and font size of its fittings."""
    low, high = points.min(axis=0), points.max(axis=0)
    scale = min((2.9, 4.8) / np.maximum(high - low, 1e-9))  # inches per metre
    left, bottom = low[0] - 0.8 / scale, (low[1] + high[1]) / 2 - 2.9 / scale
    ax.set(xlim=(left, left + 7 / scale), ylim=(bottom, bottom + 5.8 / scale))
    unit = min(shortest, 1.1 / scale)
    return unit, min(11.0, max(7.5, 12.5 * unit * scale))  # smaller words where links are short


def _away(theta, distance):
    """The step of a distance in the direction that leans by theta from the vertical."""
    return distance * np.array([math.sin(theta), math.cos(theta)])


def _link(ax, i, link, ends, theta, unit, size, rig):
    """One link with its dimensions; those stand on the side away from the vertical."""
    lower, upper = ends
    side = _away(theta + math.copysign(math.pi / 2, theta), unit)
    line(ax, *ends, color=link_color(i), linewidth=0.55 * size, solid_capstyle="round", zorder=3)
    centre = lower + _away(theta, link.com)
    _mark(ax, centre, color="white", markeredgecolor=INK, zorder=5)
    _mark(ax, centre, marker="+")
    # to the left of the link, above the arc of its angle
    if rig.n_links <= 4:
        above = 0.25 * unit if i == rig.n_links else 0  # clear of the relative angle's name
        name = centre - 0.13 * side + _away(theta, above)
        note(ax, *name, f"$m_{i}, I_{i}$", ha="right" if theta >= 0 else "left", zorder=7)
    upright = lower + _away(0, 0.62 * unit)
    line(ax, lower, upright, color=COLORS["grey"], linestyle="--", linewidth=1.1, zorder=2)
    _angle(ax, i, lower, theta, 0.5 * unit, size)
    _dimension(ax, f"$a_{i}$", lower, centre, 0.17 * side, size)
    if i < rig.n_links:
        _dimension(ax, f"$l_{i}$", lower, upper, 0.47 * side, size)


def _mark(ax, at, **style):
    """A hinge or a centre of mass."""
    style = {"marker": "o", "markersize": 9, "markeredgecolor": "black", "zorder": 6, **style}
    ax.plot(*at, **style)


def _arc(ax, at, radius, angles, **style):
    """An arc between two angles from the vertical, rad."""
    ends = sorted(90.0 - math.degrees(angle) for angle in angles)
    ax.add_patch(Arc(at, 2 * radius, 2 * radius, theta1=ends[0], theta2=ends[1], **style))


def _angle(ax, i, at, theta, radius, size):
    """The arc from the vertical to the link."""
    _arc(ax, at, radius, (0.0, theta), color=INK, linewidth=1.3)
    # A narrow angle has no room for its name, which then stands across the vertical.
    turn, reach = (theta / 2, 0.74) if abs(theta) > 0.45 else (math.copysign(0.45, -theta), 0.6)
    place = at + _away(turn, reach * radius)
    note(ax, *place, rf"$\theta_{i}$", fontsize=size, zorder=7, bbox={**ON_WHITE, "pad": 0.4})


def _relative(ax, i, at, theta, unit):
    """Link i-1 drawn on, dotted, and the arc from there to link i: what a potentiometer reads."""
    on = at + _away(theta[0], 1.1 * unit)
    line(ax, at, on, color=link_color(i - 1), linestyle=":", linewidth=1.6, zorder=2)
    _arc(ax, at, 0.9 * unit, theta, color=link_color(i), linewidth=2)
    x, y = on - [0.14 * unit, 0.15 * unit * math.cos(theta[0])]
    note(ax, x, y, angle_label(i), ha="right", color=link_color(i), fontsize=12.65, zorder=7)


def _dimension(ax, text, start, end, offset, size):
    """A dimension line beside a link, with its two extension lines."""
    for at in (start, end):
        beside = at + 0.25 * offset, at + 1.08 * offset
        line(ax, *beside, color=COLORS["grey"], linewidth=0.8, zorder=1)
    ends = start + offset, end + offset
    arrow(ax, *ends, heads="<|-|>", size=9, linewidth=1.0)
    note(ax, *np.mean(ends, axis=0), text, fontsize=size, zorder=7, bbox=ON_WHITE)


def _torque(ax, i, at, unit, size):
    """A clockwise arrow round a driven hinge: positive torque on the upper of its two links."""
    radius = 0.24 * unit
    bend = [at + _away(angle, radius) for angle in np.radians(np.linspace(-125, -28, 10))]
    arrow(ax, *bend, size=10, color=look("u1")["color"], linewidth=2, zorder=4)
    x, y = at + [-1.2 * radius, 0.55 * radius]
    note(ax, x, y, f"$T_{i}$", ha="right", fontsize=size, zorder=7)


def _values(fig, rig):
    """The column of values at the right of the page, upper links above lower ones."""
    n = rig.n_links
    left, size, pitch = (0.645, 10, 0.038) if n <= 4 else (0.615, 9, 0.032)
    head = dict(weight="bold", va="top", fontsize=size + 1)
    y = 0.95
    for i in range(n, 0, -1):
        link, drawn = rig.links[i - 1], " (drawn only)" if i == n else ""
        fig.text(left, y, f"link {i}", color=link_color(i), **head)
        rows = [
            f"$l_{i}$ = {link.length:g} m{drawn}",
            f"$a_{i}$ = {link.com:.4g} m,  $m_{i}$ = {link.mass:.4g} kg",
            f"$I_{i}$ = {link.inertia:.4g} kg m²",
        ]
        if n > 4:  # two links' worth of lines in the space of one
            rows = [rows[1], f"{rows[0]},  {rows[2]}".replace(" (drawn only)", "")]
        for row, text in enumerate(rows, 1):
            fig.text(left, y - (row + 0.1) * pitch, text, fontsize=size, va="top")
        y -= (len(rows) + 1.55) * pitch
    fig.text(left, y, "motors at standstill", **head)
    for i in range(rig.n_motors, 0, -1):
        y -= 1.1 * pitch
        torque = f"$T_{i}$ = {rig.motors[i - 1].gain:.3g} $u_{i}$ N m"
        text = ",  ".join(filter(None, (torque, limit_of(rig, i))))
        fig.text(left, y, text, fontsize=size, va="top")
