"""Sliders round a figure: the one module that imports ipywidgets.

A `Panel` keeps one Agg figure, lets a tested update function move its artists, and sends the picture
to an Image widget and the outcome in words to an HTML widget. What is shown needs no Output widget,
so a saved notebook keeps picture and caption, and exceptions reach the tests.
"""

import io
from collections.abc import Callable
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from html import escape

import ipywidgets as widgets
import numpy as np
from PIL import Image

from ._checks import found, number


@dataclass(frozen=True)
class Slider:
    """A number with a slider and a linked number field.

    Parameters
    ----------
    name : of the argument that the update function takes
    label : what it is, with its unit, such as ``"k_p (V/rad)"``
    low, high : ends of the slider; the field takes no other numbers
    value : where it starts
    log : the slider moves in decades; with `zero` its lowest notch stands for 0
    step : of a linear slider; log sliders move by a twentieth of a decade
    """

    name: str
    label: str
    low: float
    high: float
    value: float
    log: bool = False
    zero: bool = False
    step: float | None = None

    def __post_init__(self):
        number(f"{self.name} low", self.low, above=0 if self.log else None)
        number(f"{self.name} high", self.high, above=self.low)

    @property
    def span(self):
        """First and last slider position and the step between positions."""
        if not self.log:
            return self.low, self.high, self.step or (self.high - self.low) / 100
        first, last, step = np.log10(self.low), np.log10(self.high), 0.05
        return first - (step if self.zero else 0), last, step

    def value_at(self, position):
        """The value at a slider position, to three digits."""
        if not self.log:
            return float(f"{position:.6g}")
        if self.zero and position < np.log10(self.low) - 0.01:
            return 0.0
        return float(f"{10**position:.3g}")

    def position_of(self, value):
        """The slider position of a value."""
        first, last, _ = self.span
        if not self.log:
            return min(max(value, first), last)
        return first if value <= 0 else min(max(float(np.log10(value)), first), last)


@dataclass(frozen=True)
class Switch:
    """Something that is on or off."""

    name: str
    label: str
    value: bool = False


@dataclass(frozen=True)
class Choice:
    """One of several: `options` maps what is shown to the value that the update function takes."""

    name: str
    label: str
    options: dict
    value: object


@dataclass(frozen=True)
class View:
    """What a panel shows: a figure, and how to move it.

    Attributes
    ----------
    figure : Agg figure, laid out once
    update : function of the controls' values by name; changes the artists and returns the caption,
        plain text with the outcome in words; raises ValueError with a sentence for values that
        cannot work
    moving : artists that are redrawn on a kept background (axes whose frames stay); all of the
        figure is redrawn where it is empty
    """

    figure: object
    update: Callable
    moving: tuple = ()


class Panel:
    """Controls, a picture and a caption that follow each other.

    Parameters
    ----------
    title : heading of the panel
    controls : `Slider`, `Switch` and `Choice` in the order shown
    view : `View`
    legend : what each control and part of the picture does; plain text, one line each
    presets : buttons, name -> values by control name, such as ``{"Paper's values": {"k_p": 10}}``
    alt : what the picture shows, for people who do not see it
    continuous : whether the picture follows while a slider is dragged (else when it is let go)
    """

    def __init__(self, title, controls, view, legend=(), presets=None, alt="", continuous=True):
        self.title, self.view, self.alt = title, view, alt
        self.controls = {control.name: control for control in controls}
        self.presets = {**(presets or {}), "Reset": {c.name: c.value for c in controls}}
        self._quiet = False
        self._background = None
        self._fields, self._sliders = {}, {}
        rows = [self._row(control, continuous) for control in controls]
        self._image = widgets.Image(
            format="png",
            layout=widgets.Layout(
                width=f"{self.pixels[0]}px", max_width="100%", align_self="flex-start"
            ),
        )
        self._caption = widgets.HTML()
        self.caption = ""
        self._widget = widgets.VBox(
            [
                widgets.HTML(f"<b>{escape(title)}</b>"),
                widgets.HBox(rows, layout=widgets.Layout(flex_flow="row wrap")),
                widgets.HBox(
                    [self._button(name) for name in self.presets],
                    layout=widgets.Layout(flex_flow="row wrap"),
                ),
                self._image,
                self._caption,
                widgets.HTML(_legend(legend)),
            ]
        )
        self._redraw()

    @property
    def pixels(self):
        """Width and height of the picture."""
        return tuple(int(size) for size in self.view.figure.bbox.size)

    @property
    def values(self):
        """The controls' values by name."""
        return {name: field.value for name, field in self._fields.items()}

    def at(self, **values):
        """Move controls in code; the caption that results.

        Values outside a slider are brought to its nearer end, as the field would do.
        """
        for name in values:
            if name not in self._fields:
                raise ValueError(
                    f"{name}: this panel has no such control; it has {', '.join(self._fields)}."
                )
        with self._silence():
            for name, value in values.items():
                self._set(name, value)
        self._redraw()
        return self.caption

    def ends(self):
        """Move every control to its ends, one after the other, and back: all captions, for tests."""
        captions, start = [], self.values
        for name, control in self.controls.items():
            if isinstance(control, Slider):
                stops = ([0.0] if control.zero else []) + [control.low, control.high]
            elif isinstance(control, Switch):
                stops = [not control.value]
            else:
                stops = list(control.options.values())
            captions += [self.at(**{**start, name: stop}) for stop in stops]
        self.at(**start)
        return captions

    def close(self):
        """Take the panel's widgets out of the page and out of memory."""
        for widget in _tree(self._widget):
            widget.close()

    def _row(self, control, continuous):
        if isinstance(control, Switch):
            field = widgets.Checkbox(control.value, description=control.label, indent=False)
            parts = [field]
        elif isinstance(control, Choice):
            field = widgets.Dropdown(
                options=list(control.options.items()),
                value=control.value,
                description=control.label,
                style=WIDE,
            )
            parts = [field]
        else:
            first, last, step = control.span
            low = 0.0 if control.zero else control.low
            field = widgets.BoundedFloatText(
                value=control.value,
                min=low,
                max=control.high,
                step=None,
                description=control.label,
                style=WIDE,
                layout=widgets.Layout(width="220px"),
            )
            slider = widgets.FloatSlider(
                value=control.position_of(control.value),
                min=first,
                max=last,
                step=step,
                readout=False,
                continuous_update=continuous,
                layout=widgets.Layout(width="180px"),
            )
            slider.observe(partial(self._slid, control.name), "value")
            self._sliders[control.name] = slider
            parts = [field, slider]
        field.observe(partial(self._typed, control.name), "value")
        self._fields[control.name] = field
        return widgets.HBox(parts, layout=widgets.Layout(margin="0 16px 0 0"))

    def _button(self, name):
        button = widgets.Button(description=name, layout=widgets.Layout(width="auto"))
        button.on_click(partial(self._pressed, name))
        return button

    def _slid(self, name, change):
        if not self._quiet:
            with self._silence():
                self._fields[name].value = self.controls[name].value_at(change["new"])
            self._redraw()

    def _typed(self, name, _):
        if not self._quiet:
            with self._silence():
                self._set(name, self._fields[name].value)
            self._redraw()

    def _pressed(self, name, _):
        self.at(**self.presets[name])

    def _set(self, name, value):
        control = self.controls[name]
        if isinstance(control, Slider):
            low = 0.0 if control.zero else control.low
            value = min(max(number(name, value), low), control.high)
            self._sliders[name].value = control.position_of(value)
        self._fields[name].value = value

    @contextmanager
    def _silence(self):
        """Widgets that follow each other must not answer each other."""
        self._quiet = True
        try:
            yield
        finally:
            self._quiet = False

    def _redraw(self):
        try:
            self.caption = self.view.update(**self.values)
            sound = True
        except (ValueError, ArithmeticError, np.linalg.LinAlgError) as problem:
            self.caption = (
                f"These values cannot work. {problem} The picture still shows the last ones."
            )
            sound = False
        if sound or not self._image.value:
            self._image.value = self._picture()
        colour = "" if sound else "color:#B00020;font-weight:bold;"
        self._caption.value = (
            f'<p role="status" style="{colour}line-height:1.4;max-width:{self.pixels[0]}px">'
            f"{escape(self.caption)}</p>"
        )

    def _picture(self):
        canvas, moving = self.view.figure.canvas, self.view.moving
        if not moving:
            canvas.draw()
        else:
            if self._background is None:
                for artist in moving:
                    artist.set_animated(True)
                canvas.draw()
                self._background = canvas.copy_from_bbox(self.view.figure.bbox)
            canvas.restore_region(self._background)
            for artist in moving:
                (artist.axes or self.view.figure).draw_artist(artist)
        buffer = io.BytesIO()
        Image.fromarray(np.asarray(canvas.buffer_rgba())[:, :, :3]).save(
            buffer, "png", compress_level=1
        )
        return buffer.getvalue()

    def _repr_mimebundle_(self, include=None, exclude=None):
        """The live widget, a still picture where there is no kernel, and the caption as text."""
        self._replace_earlier_copy()
        bundle = self._widget._repr_mimebundle_()
        bundle = bundle[0] if isinstance(bundle, tuple) else bundle
        return {**bundle, "image/png": bytes(self._image.value), "text/plain": self.caption}

    def _replace_earlier_copy(self):
        """Close the panel that an earlier run of the same cell has left."""
        place = (_cell(), self.title)
        earlier = _SHOWN.get(place)
        if earlier is not None and earlier is not self:
            earlier.close()
        _SHOWN[place] = self

    def __repr__(self):
        return self.caption


WIDE = {"description_width": "initial"}
_SHOWN = {}  # (cell, title) -> the panel shown there, so that re-running a cell replaces it


def _cell():
    """What tells the running notebook cell from others: its id, or its text where none is sent."""
    try:
        from IPython import get_ipython

        shell = get_ipython()
        return shell.get_parent()["metadata"].get("cellId") or shell.user_ns["In"][-1]
    except (ImportError, AttributeError, KeyError, IndexError, TypeError):
        return None


def _tree(widget):
    for child in getattr(widget, "children", ()):
        yield from _tree(child)
    yield widget


def _legend(lines):
    if not lines:
        return ""
    items = "".join(f"<li>{escape(line)}</li>" for line in lines)
    keys = "Keyboard: Tab to a control; arrow keys, Page Up and Page Down move a slider."
    return f"<details><summary>What is what</summary><ul>{items}<li>{keys}</li></ul></details>"
