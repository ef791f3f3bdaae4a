"""The rig from the front, drawn from its parameters (Fig 1), for any number of links."""

import math

import numpy as np
from matplotlib.patches import Rectangle

from .blocks import INK, canvas
from .moving import check_rig, link_color
from .style import COLORS, angle_name, describe, look, styled

_ORDER = {2: ("lower", "upper"), 3: ("lower", "middle", "upper")}
_COUNT = {1: "one", 2: "two", 3: "three", 4: "four", 5: "five", 6: "six"}


def _hinge_name(rig, i):
    return f"{_ORDER[rig.n_links][i - 1]} hinge" if rig.n_links in _ORDER else f"hinge {i}"


def plural(count, word):
    return f"{_COUNT.get(count, count)} {word}{'s' * (count != 1)}"


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
    _stand(ax, d, low)
    for i in range(1, n + 1):
        _tube(ax, d, heights[i - 1], heights[i], link_color(i), last=i == n)
    for i in range(1, n + 1):
        _hinge(ax, rig, i, d, heights[i - 1])
    for i, link in enumerate(rig.links, 1):
        only = " (drawn only)" if i == n else ""  # no equation knows the last link's length
        text = f"link {i}:  {link.length:g} m{only},  {link.mass:.3g} kg"
        middle = (heights[i - 1] + heights[i]) / 2
        _pointer(ax, text, (0.4 * d, middle), (0.13 * page, middle), color=link_color(i))
    m = rig.n_motors
    return describe(
        fig,
        f"Fig 1. The {rig.name} pendulum has {plural(n, 'link')} but only {plural(m, 'motor')}: "
        f"the lowest hinge, on which everything stands, turns freely and is only measured.",
        f"Front view of {plural(n, 'tube')} one above the other on a stand, joined by hinges. "
        f"Left of each hinge a potentiometer, pot 1 to pot {n}; right of hinge 1 a tachometer; "
        f"right of the {' and the '.join(_hinge_name(rig, i + 1) for i in range(1, m + 1))} "
        f"a motor with gearbox. Link lengths from below: "
        f"{', '.join(f'{length:g} m' for length in lengths)}.",
    )


def _rect(ax, left, bottom, width, height, face, zorder=3):
    ax.add_patch(
        Rectangle(
            (left, bottom),
            width,
            height,
            facecolor=face,
            edgecolor=INK,
            linewidth=1.1,
            zorder=zorder,
        )
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
    edge = 0.175 * (ax.get_xlim()[1] - ax.get_xlim()[0])
    _pointer(
        ax,
        f"pot {i}:  {look(angle_name(i))['label']}" if i <= 6 else f"pot {i}",
        (-1.75 * d, y),
        (-edge, y),
        ha="right",
        color=link_color(i),
    )
    if i == 1:
        _rect(ax, 1.15 * d, y - 0.22 * d, 0.7 * d, 0.44 * d, look("rate")["color"], zorder=6)
        _pointer(
            ax,
            r"tachometer:  $\dot\theta_1$" + "\n(no motor: free hinge)",
            (1.85 * d, y),
            (edge, y),
        )
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
    ax.text(at[0] + gap, at[1], text, ha=ha, va="center", linespacing=1.25)
