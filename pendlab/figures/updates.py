"""Figures that move: how each of them gets its ``update``."""

import numpy as np
from matplotlib.lines import Line2D

from .style import describe, freeze_layout


def live(fig, draw, compute, say, *subject, ghosts=False):
    """Draw a figure once and give it ``fig.update(*subject)``, so that sliders can drive it.

    Parameters
    ----------
    fig : CaptionedFigure, still without its curves
    draw : function of the computed data that creates artists in the figure and returns its moves:
        functions of the data that change the artists and return those that moved (or nothing)
    compute : function of the subject, such as a design; what cannot be is refused here, before
        anything has moved
    say : function of (data, *subject) that gives caption and description, and for a panel a dict of
        what is told apart: ``verdict`` (word, whether it is good), ``table`` (rows of text, heads
        first), ``lead`` (the sentences that the table leaves)
    subject : what is drawn at first
    ghosts : whether the curves of that first subject stay, pale, while others move

    Returns
    -------
    the figure, laid out; ``fig.moving`` holds the artists that moved
    """
    data = compute(*subject)
    moves = draw(data)
    freeze_layout(fig)
    fig.moving = tuple(artist for move in moves for artist in move(data) or ())
    if ghosts:
        _leave_ghosts(fig.moving)

    def speak(data, *subject):
        caption, alt, *apart = say(data, *subject)
        describe(fig, caption, alt)
        fig.caption = caption  # its lines stay apart
        for name, value in (apart[0] if apart else {}).items():
            setattr(fig, name, value)
        return fig

    def update(*subject):
        data = compute(*subject)
        for move in moves:
            move(data)
        return speak(data, *subject)

    fig.update = update
    return speak(data, *subject)


def _leave_ghosts(moving):
    """A pale copy of every curve and mark where it is now."""
    for line in moving:
        if isinstance(line, Line2D):
            ghost = Line2D(*line.get_data())
            ghost.update_from(line)
            ghost.set(alpha=0.28, zorder=1.5, label="_")
            line.axes.add_line(ghost)


def part(move, key):
    """`move` for a part of the computed data: ``data[key]``."""

    def moved(data):
        return move(data[key])

    return moved


def moving(ax, looks, data, points):
    """Lines that follow the data, one for each of `looks`, keyword arguments of ``ax.plot``.

    `points(data)` gives for each line its (x, y) or complex values. Returns update(data) -> lines.
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
