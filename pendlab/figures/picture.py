"""Figures that move: how each gets its ``update``, and how it is drawn again and again."""

import struct
import zlib

import numpy as np
from matplotlib.artist import Artist
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from .._arguments import instance
from ..bench.arguments import items
from .style import describe, freeze_layout


def live(fig, draw, compute, say, *subject, ghosts=False):
    """Draw a figure once and give it ``fig.update(*subject)``, so that sliders can drive it.

    `compute(*subject)` gives a list of data; what cannot be is refused there, before anything moves.
    `draw(data)` creates artists and returns a move for each part of the data: a function of it that
    changes artists and returns them. `say(data, *subject)` gives caption, description, and for a
    panel a dict of what is told apart: ``verdict`` (word, whether it is good), ``table`` (rows of
    text, heads first), ``lead`` (the sentences that the table leaves). With `ghosts` the curves of
    the first subject stay, pale. The figure is laid out; ``fig.moving`` are the artists that move.
    """

    def show(data, *subject):
        fig.moving = tuple(artist for move, part in zip(moves, data) for artist in move(part))
        caption, alt, *apart = say(data, *subject)
        describe(fig, caption, alt)
        fig.caption = caption  # its lines stay apart
        vars(fig).update(*apart)
        return fig

    def update(*subject):
        return show(compute(*subject), *subject)

    data = compute(*subject)
    moves = draw(data)
    fig.update = update
    show(data, *subject)
    if ghosts:
        _leave_ghosts(fig.moving)
    return freeze_layout(fig)


def _leave_ghosts(moving):
    """A pale copy of every curve and mark where it is now."""
    for line in moving:
        if isinstance(line, Line2D):
            ghost = Line2D(*line.get_data())
            ghost.update_from(line)
            ghost.set(alpha=0.28, zorder=1.5, label="_")
            line.axes.add_line(ghost)


def follow(ax, looks, data, points):
    """Lines that follow the data, one for each of `looks`, keyword arguments of ``ax.plot``.

    `points(data)` gives for each line its (x, y) or complex values. Returns update(data), which moves
    the lines inside the frame of the axes and returns them.
    """
    lines = [ax.plot([], [], **look)[0] for look in looks]

    def update(data):
        for line, values in zip(lines, points(data), strict=True):
            if not isinstance(values, tuple):
                values = np.atleast_1d(np.real(values)), np.atleast_1d(np.imag(values))
            line.set_data(*values)
        return lines

    update(data)
    return update


class Picture:
    """PNG pictures of an Agg figure whose artists move: what stays is kept, the rest drawn on top.

    The background of the artists in `moving` is renewed when the frame of any axes has changed; all
    of the figure is drawn each time where there are none.
    """

    def __init__(self, figure, moving=()):
        self.figure, self.moving = figure, tuple(moving)
        self._background, self._frames = None, None
        for artist in self.moving:
            artist.set_animated(True)

    def png(self):
        """The figure as it is now."""
        canvas = self.figure.canvas
        if not self.moving:
            canvas.draw()
        else:
            frames = [(*ax.get_xlim(), *ax.get_ylim()) for ax in self.figure.axes]
            if frames != self._frames:
                canvas.draw()
                self._background = canvas.copy_from_bbox(self.figure.bbox)
                self._frames = frames
            canvas.restore_region(self._background)
            for artist in self.moving:
                (artist.axes or self.figure).draw_artist(artist)
        return png_bytes(np.asarray(canvas.buffer_rgba())[:, :, :3])


def check_artists(figure, moving):
    """A sentence on what is no figure, or no artist among those that move."""
    instance("figure", figure, Figure, "pl.new_figure()")
    for i, artist in enumerate(items("moving", moving, "artists")):
        instance(f"moving[{i}]", artist, Artist)


def png_bytes(pixels):
    """RGB pixels (height, width, 3) as a PNG without row filters.

    Image libraries try several filters on each row. That suits photographs; for lines on white it
    takes half of the time from slider to picture and makes the file no smaller.
    """
    height, width, _ = pixels.shape
    rows = np.zeros((height, 1 + 3 * width), np.uint8)  # each begins with its filter: none
    rows[:, 1:] = pixels.reshape(height, -1)
    chunks = (
        (b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)),
        (b"IDAT", zlib.compress(rows, 1)),
        (b"IEND", b""),
    )
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        for kind, data in chunks
    )
