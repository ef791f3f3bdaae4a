"""Arrowheads along drawn curves, which say in what direction they are run through."""

import numpy as np


def arrowheads(ax, count, color, size=0.13):
    """`count` arrowheads without shafts, `size` inches long, to be placed by `point`."""
    nothing = np.full(count, np.nan)
    return ax.quiver(
        nothing, nothing, np.ones(count), np.zeros(count), color=color, pivot="mid", zorder=5,
        units="inches", scale_units="inches", scale=1 / size, width=size / 8, headwidth=6.4,
        headlength=8, headaxislength=8, minlength=0,
    )  # fmt: skip


def point(ax, heads, paths, fractions, least=0.2):
    """Put arrowheads at fractions of the drawn length of complex paths of `least` inches or more."""
    (left, right), (low, high) = ax.get_xlim(), ax.get_ylim()
    width, height = ax.get_figure().get_size_inches()
    box = ax.get_position()
    sx, sy = width * box.width / (right - left), height * box.height / (high - low)
    if ax.get_aspect() == 1:
        sx = sy
    places, ways = [], []
    for path in paths:
        on_page = path.real * sx + 1j * path.imag * sy
        length = np.concatenate([[0], np.cumsum(np.abs(np.diff(on_page)))])
        for fraction in fractions:
            if len(path) < 2 or length[-1] < least:
                place, way = np.nan, 1.0
            else:
                k = int(np.clip(np.searchsorted(length, fraction * length[-1]), 1, len(path) - 1))
                place, way = path[k], on_page[k] - on_page[k - 1]
            places.append(place)
            ways.append(way / abs(way) if way else 1.0)
    places, ways = np.array(places, dtype=complex), np.array(ways, dtype=complex)
    heads.set_offsets(np.column_stack([places.real, places.imag]))
    heads.set_UVC(ways.real, ways.imag)
