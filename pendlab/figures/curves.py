"""Curves side by side: what a notebook or a homework draws with, in one call."""

from itertools import cycle

import numpy as np

from .._arguments import flag, found, text
from ..bench.arguments import interval, items, mapping, one_of
from .style import COLORS, LINES, describe, new_figure, styled

# For curves that are no signal of the rig, in this order.
COLOURS = ("black", "vermillion", "blue", "green", "orange", "sky", "purple")
PENS = [
    dict(color=COLORS[color], linestyle=stroke, linewidth=2)
    for color, stroke in zip(COLOURS, cycle(("-", "--", ":", "-.")))
]


@styled()
def lines(
    panels, x_label, caption="", alt="", *, log="", width=9.0, height=3.4, sharey=False, frame=None
):
    """Curves in panels side by side, as a figure for ``pl.show`` that can still be changed.

    Parameters
    ----------
    panels : dict, label of the y axis -> dict of curves, label -> (x, y) or (x, y, look). A `look`
        is a dict for ``ax.plot``, such as ``pl.look("theta1")``; a curve whose label is the name of
        a signal ("theta1", "u1", "reference", ...) wears its look without being told. `y` of shape
        (N, k) is one curve in k pieces
    x_label : of the x axis; one for all panels or a list of one for each
    caption, alt : what the figure claims, and what it shows to readers who do not see it
    log : the axes that are logarithmic, "x", "y" or "xy"
    width, height : of the figure, inches
    sharey : whether all panels have the same y axis
    frame : ((left, right), (bottom, top)) of every panel; None for an end that follows the curves

    Raises
    ------
    TypeError, ValueError : panels or curves that are not laid out like that, with what was found

    >>> t = np.linspace(0, 1, 50)
    >>> fig = lines({"angle, rad": {"theta1": (t, t**2)}}, "time, s", "A parabola.")
    >>> fig.axes[0].get_xlabel(), fig.caption
    ('time, s', 'A parabola.')
    """
    example = '{"angle, rad": {"theta1": (t, angle)}}'
    panels = mapping("panels", panels, example)
    panels = {label: _curves(label, curves) for label, curves in panels.items()}
    if isinstance(x_label, str):
        x_label = [x_label] * len(panels)
    x_labels = [text("x_label", one, empty=True) for one in items("x_label", x_label, "texts")]
    if len(x_labels) != len(panels):
        raise ValueError(
            f"x_label: expected one text or one for each of {len(panels)} panels, {found(x_label)}."
        )
    one_of("log", log, ("", "x", "y", "xy"))
    flag("sharey", sharey)
    frame = {} if frame is None else dict(zip(("xlim", "ylim"), _frame(frame)))
    fig = new_figure(width, height)
    axes = fig.subplots(1, len(panels), sharey=sharey, squeeze=False)[0]
    for ax, x_label, (y_label, curves) in zip(axes, x_labels, panels.items(), strict=True):
        for curve, pen in zip(curves, cycle(PENS)):
            _draw(ax, *curve, pen)
        ax.set(xlabel=x_label, ylabel="" if sharey and ax is not axes[0] else y_label)
        ax.set(**{f"{axis}scale": "log" for axis in log}, **frame)
        if len(curves) > 1:
            ax.legend()
    return describe(fig, caption, alt)


def _frame(frame):
    try:
        (left, right), (bottom, top) = frame
    except (TypeError, ValueError):
        raise ValueError(
            f"frame: expected ((left, right), (bottom, top)) with None for a free end, {found(frame)}."
        ) from None
    return interval("frame", (left, right), free=True), interval("frame", (bottom, top), free=True)


def _draw(ax, label, x, y, given, pen):
    pieces = ax.plot(x, y, **{**LINES.get(label, pen), **given})
    if label not in LINES:
        pieces[0].set_label(label)
    for piece in pieces[1:]:
        piece.set(color=pieces[0].get_color(), label="_")


def _curves(panel, curves):
    """(label, x, y, look) of each curve of a panel, checked."""
    checked = []
    curves = mapping(f"panels[{panel!r}]", curves, '{"theta1": (t, angle)}', least=0)
    for label, curve in curves.items():
        name = f"panels[{panel!r}][{label!r}]"
        if not isinstance(curve, (tuple, list)) or len(curve) not in (2, 3):
            raise TypeError(f"{name}: expected (x, y) or (x, y, look), {found(curve)}.")
        x, y, given = (*curve, {})[:3]
        if not isinstance(given, dict):
            raise TypeError(f'{name}: expected a look as pl.look("theta1") gives, {found(given)}.')
        try:
            x, y = (np.ma.filled(np.ma.asarray(part, dtype=float), np.nan) for part in (x, y))
        except (TypeError, ValueError):
            raise TypeError(f"{name}: expected numbers, {found(curve)}.") from None
        x, y = np.atleast_1d(x, y)
        if len(x) != len(y):
            sizes = f"{x.shape} and {y.shape}"
            raise ValueError(f"{name}: expected x and y of one length, found {sizes}.")
        checked.append((label, x, y, given))
    return checked
