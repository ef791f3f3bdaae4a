"""Figures that move: how each of them gets its ``update``."""

from .style import describe, freeze_layout


def live(fig, draw, compute, say, *subject):
    """Draw a figure once and give it ``fig.update(*subject)``, so that sliders can drive it.

    Parameters
    ----------
    fig : CaptionedFigure, still without its curves
    draw : function of the computed data that creates artists in the figure and returns its moves:
        functions of the data that change the artists and return those that moved (or nothing)
    compute : function of the subject, such as a design; what cannot be is refused here, before
        anything has moved
    say : function of (data, *subject) that gives caption and description
    subject : what is drawn at first

    Returns
    -------
    the figure, laid out; ``fig.moving`` holds the artists that moved
    """
    data = compute(*subject)
    moves = draw(data)
    freeze_layout(fig)
    fig.moving = tuple(artist for move in moves for artist in move(data) or ())

    def speak(data, *subject):
        caption, alt = say(data, *subject)
        describe(fig, caption, alt)
        fig.caption = caption  # its lines stay apart
        return fig

    def update(*subject):
        data = compute(*subject)
        for move in moves:
            move(data)
        return speak(data, *subject)

    fig.update = update
    return speak(data, *subject)


def part(move, *keys):
    """`move` for a part of the computed data, such as ``data[1]``."""

    def moved(data):
        for key in keys:
            data = data[key]
        return move(data)

    return moved
