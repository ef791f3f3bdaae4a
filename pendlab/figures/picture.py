"""A figure that is drawn again and again: what stays is kept, what moves is drawn on top."""

import struct
import zlib

import numpy as np
from matplotlib.artist import Artist
from matplotlib.figure import Figure

from .._arguments import instance
from ..bench.arguments import items


class Picture:
    """PNG pictures of an Agg figure whose artists move.

    Parameters
    ----------
    figure : Agg figure, laid out once
    moving : artists drawn on a kept background, which is renewed when the frame of any axes has
        changed; all of the figure is drawn each time where it is empty
    """

    def __init__(self, figure, moving=()):
        self.figure, self.moving = figure, tuple(moving)
        self._background, self._frames = None, None
        for artist in self.moving:
            artist.set_animated(True)

    @property
    def size(self):
        """Width and height in pixels."""
        return tuple(int(length) for length in self.figure.bbox.size)

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
