"""Primitives of the drawings: a page, boxes, lines with and without arrowheads, words."""

import numpy as np
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch
from matplotlib.path import Path

from .style import new_figure

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
