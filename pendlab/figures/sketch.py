"""What drawings are made of: boxes, lines, words, arrows; complex planes and their arrowheads."""

import numpy as np
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch
from matplotlib.path import Path

from .style import COLORS, look, new_figure

INK = "#222222"


def canvas(width, height):
    """A figure and axes without frame whose units are inches."""
    fig = new_figure(width, height, layout=None)
    ax = fig.add_axes((0, 0, 1, 1))
    ax.set(xlim=(0, width), ylim=(0, height))
    ax.set_axis_off()
    return fig, ax


def box(ax, x, y, width, height, face="white", rounded=0.0, **line):
    """A box centred at (x, y), its corners rounded by a radius."""
    ax.add_patch(
        FancyBboxPatch(
            (x - width / 2, y - height / 2), width, height, facecolor=face,
            boxstyle=f"round,pad=0,rounding_size={rounded}" if rounded else "square,pad=0",
            **{"edgecolor": INK, "linewidth": 1.1, "zorder": 3, **line},
        )
    )  # fmt: skip


def line(ax, *points, **style):
    """A line through points."""
    ax.plot(*np.transpose(points), **{"color": INK, **style})


def arrow(ax, *points, heads="-|>", size=15, **style):
    """A line through points with an arrowhead at its end, or at both."""
    style = {"color": INK, "linewidth": 1.5, "zorder": 2, "joinstyle": "miter", **style}
    path = Path(np.array(points))
    ax.add_patch(FancyArrowPatch(path=path, arrowstyle=heads, mutation_scale=size, **style))


def note(ax, x, y, text, **more):
    """Words centred at (x, y)."""
    ax.text(x, y, text, **{"ha": "center", "va": "center", "zorder": 5, **more})


def zero_lines(ax, axes="xy"):
    """Thin lines through 0, along x, along y or both."""
    for name, line in (("x", ax.axhline), ("y", ax.axvline)):
        if name in axes:
            line(0, color=COLORS["grey"], linewidth=0.8, zorder=1)


def unit_circle(ax, **changes):
    """The unit circle in its look."""
    circle = np.exp(1j * np.linspace(0, 2 * np.pi, 2001))
    return ax.plot(circle.real, circle.imag, **look("unit circle", **changes))[0]


def frame_plane(ax, frame):
    """Limits ((left, right), (bottom, top)) and labels of a complex plane."""
    ax.set(xlim=frame[0], ylim=frame[1], xlabel="real part", ylabel="imaginary part")


def arrowheads(ax, paths, fractions, color, least=0.2, size=0.13):
    """Arrowheads of `size` inches at fractions of the drawn length of complex paths.

    Paths below `least` inches get none. The axes must have their limits and place on the page.
    """
    ax.apply_aspect()
    places, ways = [], []
    for path in paths:
        points = ax.transData.transform(np.column_stack([path.real, path.imag]))
        on_page = points @ [1, 1j] / ax.get_figure().dpi
        length = np.concatenate([[0], np.cumsum(np.abs(np.diff(on_page)))])
        if len(path) >= 2 and length[-1] >= least:
            k = np.searchsorted(length, np.multiply(fractions, length[-1]))
            places += [*path[k]]
            ways += [*(on_page[k] - on_page[k - 1])]
    ways = np.array(ways) / np.abs(ways)
    ax.quiver(
        np.real(places), np.imag(places), ways.real, ways.imag, color=color, pivot="mid", zorder=5,
        units="inches", scale_units="inches", scale=1 / size, width=size / 8, headwidth=6.4,
        headlength=8, headaxislength=8, minlength=0,
    )  # fmt: skip
