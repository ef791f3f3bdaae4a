"""A figure that is drawn again and again: what stays is kept, what moves is drawn on top."""

import io

import numpy as np
from PIL import Image


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
        buffer = io.BytesIO()
        pixels = np.asarray(canvas.buffer_rgba())[:, :, :3]
        Image.fromarray(pixels).save(buffer, "png", compress_level=1)
        return buffer.getvalue()
