"""The rig from the front, drawn from its parameters (Fig 1), for any number of links."""

import math

import numpy as np

from .moving import check_rig, link_color
from .sketch import INK, box, canvas, line, note
from .style import COLORS, angle_label, describe, look, styled

_COUNT = dict(enumerate(("one", "two", "three", "four", "five", "six"), 1))


def plural(count, word):
    return f"{_COUNT.get(count, count)} {word}{'s' * (count != 1)}"


def limit_of(rig, i):
    """The voltage limit of motor i as a formula, if it has one."""
    limit = rig.u_max[i - 1]
    return f"$|u_{i}|$ ≤ {limit:g} V" if math.isfinite(limit) else ""


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
    page = (high - low) * 7 / 5.8
    ax.set(xlim=(-0.38 * page, 0.62 * page), ylim=(low, high))
    _between(ax, 0.72 * d, low + 0.35 * d, -0.55 * d, COLORS["pale"])  # the stand and its foot
    _between(ax, 4.8 * d, low + 0.1 * d, low + 0.35 * d, COLORS["grey"])
    for i, link in enumerate(rig.links, 1):
        lower, upper = heights[i - 1 : i + 1]
        _between(ax, 0.72 * d, lower + 0.55 * d, upper - 0.55 * d * (i < n), link_color(i))
        _hinge(ax, rig, i, d, lower)
        only = " (drawn only)" if i == n else ""  # no equation knows the last link's length
        text = f"link {i}:  {link.length:g} m{only},  {link.mass:.3g} kg"
        _pointer(ax, text, 0.4 * d, 0.13 * page, (lower + upper) / 2, color=link_color(i))
    m = rig.n_motors
    return describe(
        fig,
        f"Fig 1. The {rig.name} pendulum has {plural(n, 'link')} but only {plural(m, 'motor')}: "
        f"the lowest hinge, on which everything stands, turns freely and is only measured.",
        f"Front view of {plural(n, 'tube')} one above the other on a stand, joined by hinges. "
        f"Left of each hinge a potentiometer, pot 1 to pot {n}; right of hinge 1 a tachometer; "
        f"right of {' and '.join(f'hinge {i + 1}' for i in range(1, m + 1))} "
        f"a motor with gearbox. Link lengths from below: "
        f"{', '.join(f'{length:g} m' for length in lengths)}.",
    )


def _between(ax, width, bottom, top, face):
    """A part in the middle of the page between two heights."""
    box(ax, 0, (bottom + top) / 2, width, top - bottom, face)


def _fork(ax, y, d, reach, way):
    """Two side plates from the hinge at height y down (way = -1) or up (+1), and their bridge."""
    plate, metal = 0.09 * d, dict(face="#C9CED6", zorder=4)
    for side in (-1, 1):
        box(ax, side * reach * d, y + way * 0.165 * d, plate, 0.77 * d, **metal)
    box(ax, 0, y + way * 0.55 * d, 2 * reach * d + plate, plate, **metal)


def _hinge(ax, rig, i, d, y):
    """Hinge i at height y: two forks, shafts, a pot on the left, motor or tacho on the right."""
    _fork(ax, y, d, 0.85, -1)
    _fork(ax, y, d, 0.6, 1)
    for side in (-1, 1):
        box(ax, side * 0.825 * d, y, 0.75 * d, 0.12 * d, zorder=5)
    box(ax, -1.45 * d, y, 0.6 * d, 0.5 * d, zorder=6)
    edge = 0.175 * np.ptp(ax.get_xlim())
    name = ":  ".join(filter(None, (f"pot {i}", angle_label(i))))
    _pointer(ax, name, -1.75 * d, -edge, y, ha="right", color=link_color(i))
    if i == 1:
        box(ax, 1.5 * d, y, 0.7 * d, 0.44 * d, look("rate")["color"], zorder=6)
        words = r"tachometer:  $\dot\theta_1$" + "\n(no motor: free hinge)"
        _pointer(ax, words, 1.85 * d, edge, y)
    elif i - 1 <= rig.n_motors:
        motor = rig.motors[i - 2]
        box(ax, 1.525 * d, y, 0.75 * d, 0.6 * d, COLORS["grey"], zorder=6)
        box(ax, 2.45 * d, y, 1.1 * d, 0.48 * d, "#3B3B3B", zorder=6)
        words = f"motor {i - 1} (hinge {i})\ngearbox {motor.ratio:g} : 1,  {motor.gain:.3g} N m/V"
        bound = limit_of(rig, i - 1) if rig.n_links < 5 else ""
        _pointer(ax, f"{words}\n{bound}".strip(), 3.0 * d, edge, y)
    else:
        _pointer(ax, "bearing, no motor", 1.2 * d, edge, y)


def _pointer(ax, text, start, end, y, ha="left", color=INK):
    """A label at `end` with a thin line from the part that it names, at height y."""
    gap = 0.012 * ax.get_xlim()[1] * (1 if ha == "left" else -1)
    line(ax, (start, y), (end, y), color=color, linewidth=1.0, zorder=2)
    note(ax, end + gap, y, text, ha=ha, linespacing=1.25)
