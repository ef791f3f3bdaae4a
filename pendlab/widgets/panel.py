"""Controls round a picture: the one module that imports ipywidgets.

A `Panel` keeps one Agg figure, lets a tested update function move its artists, and sends the picture
to an Image widget and the outcome in words to an HTML widget. What is shown needs no Output widget,
so a saved notebook keeps picture and caption, and exceptions reach the tests.
"""

import time
from collections import deque
from contextlib import contextmanager
from html import escape
from weakref import finalize

import ipywidgets as widgets
import numpy as np

from .._arguments import found
from ..figures.picture import Picture
from .notebook import close_all, legend_html, running_cell, weakly
from .parts import Choice, Switch

SLOW = 0.4  # s; updates that take longer announce themselves
WIDTH = 1120  # px; what JupyterLab leaves of a 1366 px screen


class Panel:
    """Controls, a picture and a caption that follow each other.

    Parameters
    ----------
    title : heading of the panel
    controls : `Slider`, `Switch` and `Choice` in the order shown; or a dict of such lists by
        heading, shown as tabs
    view : `View`
    legend : what each control and part of the picture does; plain text, one line each
    presets : buttons, name -> values by control name, such as ``{"Paper's values": {"k_p": 10}}``
    actions : buttons for what takes longer, name -> function of (values, progress) that returns a
        sentence to add to the caption and calls ``progress(done, all)`` on the way
    continuous : whether the picture follows while a slider is dragged (else when it is let go)
    """

    def __init__(
        self, title, controls, view, legend=(), presets=None, actions=None, continuous=True
    ):
        groups = controls if isinstance(controls, dict) else {"": controls}
        self.title, self.view = title, view
        self.controls = {c.name: c for group in groups.values() for c in group}
        start = {name: control.value for name, control in self.controls.items()}
        self.presets = {**(presets or {}), "Reset": start}
        self.actions = dict(actions or {})
        self.caption = ""
        self._picture = Picture(view.figure, view.moving)
        self._quiet, self._seconds = False, 0.0
        self._fields, self._sliders = {}, {}
        self._sent = {}  # positions that the code gave each slider since a hand last moved it
        width = self._picture.size[0]
        self._image = widgets.Image(
            format="png",
            layout=_layout(width=f"{width}px", max_width="100%", align_self="flex-start"),
        )
        self._beside, self._words = widgets.HTML(), widgets.HTML()
        self._progress = widgets.IntProgress(layout=_layout(display="none", width="160px"))
        buttons = [self._button(name, self._preset) for name in self.presets]
        buttons += [self._button(name, self._act) for name in self.actions]
        self._widget = widgets.VBox(
            [
                widgets.HTML(f"<b>{escape(title)}</b>"),
                self._arranged(groups, continuous),
                widgets.HBox(
                    [*buttons, self._progress],
                    layout=_layout(flex_flow="row wrap"),
                ),
                widgets.HBox([self._image, self._beside], layout=_layout(align_items="flex-start")),
                self._words,
                widgets.HTML(legend_html(legend)),
            ]
        )
        # ipywidgets remembers every widget; when nobody holds the panel any more, they may go.
        finalize(self, close_all, self._widget).atexit = False
        self._redraw()

    @property
    def picture(self):
        """The PNG that is shown."""
        return bytes(self._image.value)

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
        clipped = {name: self.controls[name].clipped(value) for name, value in values.items()}
        with self._silence():
            for name, value in clipped.items():
                self._set(name, value)
        self._redraw()
        return self.caption

    def ends(self):
        """Move every control to its ends, one after the other, and back: all captions, for tests."""
        captions, start = [], self.values
        for name, control in self.controls.items():
            captions += [self.at(**{**start, name: stop}) for stop in control.stops]
        self.at(**start)
        return captions

    def act(self, name):
        """Press the button of an action in code; the caption that results."""
        if name not in self.actions:
            raise ValueError(
                f"name: expected one of {', '.join(self.actions) or 'no'} actions, {found(name)}."
            )
        self._progress.layout.display = "flex"
        try:
            sentence = self.actions[name](self.values, self._show_progress)
        except _CANNOT as problem:
            sentence = f"{name}: {problem}"
        finally:
            self._progress.layout.display = "none"
        self._say(f"{self.caption}\n{sentence}")
        return self.caption

    def close(self):
        """Take the panel's widgets out of the page and out of memory."""
        close_all(self._widget)

    # Controls

    def _arranged(self, groups, continuous):
        boxes = [
            widgets.GridBox(
                [self._row(control, continuous) for control in group],
                layout=_layout(
                    grid_template_columns="repeat(auto-fill, minmax(270px, 1fr))",
                    grid_gap="0 14px",
                    width="100%",
                    max_width=f"{WIDTH}px",
                ),
            )
            for group in groups.values()
        ]
        if len(boxes) == 1:
            return boxes[0]
        return widgets.Tab(boxes, titles=list(groups), layout=_layout(max_width=f"{WIDTH}px"))

    def _row(self, control, continuous):
        style = {"description_width": "initial"}
        if isinstance(control, Switch):
            field = widgets.Checkbox(control.value, description=control.label, indent=False)
            parts = [field]
        elif isinstance(control, Choice):
            field = widgets.Dropdown(
                options=list(control.options.items()),
                value=control.value,
                description=control.label,
                style=style,
            )
            parts = [field]
        else:
            field = widgets.BoundedFloatText(
                value=control.value,
                min=min(control.stops),
                max=control.high,
                step=None,
                description=control.label,
                style=style,
                layout=_layout(width=f"{6.4 * len(control.label) + 88:.0f}px", flex="0 0 auto"),
            )
            self._sliders[control.name] = self._slider(control, continuous)
            self._sent[control.name] = deque([control.position_of(control.value)], maxlen=20)
            parts = [field, self._sliders[control.name]]
        field.observe(weakly(self._typed, control.name), "value")
        self._fields[control.name] = field
        return widgets.HBox(parts)

    def _slider(self, control, continuous):
        first, last, step = control.span
        slider = widgets.FloatSlider(
            value=control.position_of(control.value),
            min=first,
            max=last,
            step=step,
            readout=False,
            continuous_update=continuous,
            layout=_layout(flex="1 1 60px", width="auto", min_width="60px"),
        )
        slider.observe(weakly(self._slid, control.name), "value")
        return slider

    def _button(self, name, pressed):
        button = widgets.Button(description=name, layout=_layout(width="auto"))
        button.on_click(weakly(pressed, name))
        return button

    def _slid(self, name, change):
        control, position = self.controls[name], change["new"]
        # The browser puts a slider onto its nearest step when it appears, and may say so after the
        # code has moved on. That is not a move: it must not change a value such as 3 that lies
        # between two steps, nor bring an earlier value back.
        near = 0.51 * control.span[2]
        if self._quiet:
            return
        echo = next((sent for sent in self._sent[name] if abs(position - sent) <= near), None)
        if echo is not None:
            current = control.position_of(self._fields[name].value)
            if echo != current:
                self._sent[name].remove(echo)  # said once; the next time it is a hand
            with self._silence():
                self._sliders[name].value = current
            return
        self._sent[name].clear()  # a hand is on the slider now
        with self._silence():
            self._fields[name].value = control.value_at(position)
        self._sent[name].append(position)
        self._redraw()

    def _typed(self, name, _):
        if not self._quiet:
            with self._silence():
                self._set(name, self._fields[name].value)
            self._redraw()

    def _preset(self, name, _):
        self.at(**self.presets[name])

    def _act(self, name, _):
        self.act(name)

    def _set(self, name, value):
        if name in self._sliders:
            position = self.controls[name].position_of(value)
            self._sent[name].append(position)
            self._sliders[name].value = position
        self._fields[name].value = value

    @contextmanager
    def _silence(self):
        """Widgets that follow each other must not answer each other."""
        self._quiet = True
        try:
            yield
        finally:
            self._quiet = False

    # What is shown

    def _redraw(self):
        start = time.perf_counter()
        if self._seconds > SLOW:
            self._words.value = "<p>Computing ... <progress></progress></p>"
        try:
            caption, sound = self.view.update(**self.values), True
        except _CANNOT as problem:
            caption, sound = f"These values cannot work. {problem}", False
            if self.picture:
                caption += " The picture still shows the last ones."
        if sound or not self.picture:
            self._image.value = self._picture.png()
            if self.view.beside is not None:
                self._beside.value = self.view.beside()
        self._say(caption, sound)
        self._seconds = time.perf_counter() - start

    def _say(self, caption, sound=True):
        self.caption = caption
        colour = "" if sound else "color:#B00020;font-weight:bold;"
        lines = escape(caption).replace("\n", "<br>")
        self._words.value = (
            f'<p role="status" style="{colour}line-height:1.35;margin:0;max-width:{WIDTH}px">'
            f"{lines}</p>"
        )

    def _show_progress(self, done, total):
        self._progress.max, self._progress.value = total, done

    def _repr_mimebundle_(self, include=None, exclude=None):
        """The live widget, a still picture where there is no kernel, and the caption as text."""
        self._replace_earlier_copy()
        bundle = self._widget._repr_mimebundle_()
        bundle = bundle[0] if isinstance(bundle, tuple) else bundle
        return {**bundle, "image/png": self.picture, "text/plain": self.caption}

    def _replace_earlier_copy(self):
        """Close the panel that an earlier run of the same cell has left, unless it shows elsewhere."""
        place = (running_cell(), self.title)
        earlier = _SHOWN.pop(place, None)
        _SHOWN[place] = self
        if earlier is not None and all(earlier is not panel for panel in _SHOWN.values()):
            earlier.close()

    def __repr__(self):
        return self.caption


_CANNOT = (ValueError, ArithmeticError, np.linalg.LinAlgError)
# (cell, title) -> the panel shown there. A page shows its panels whether or not a variable holds
# them; running the cell again replaces its entry.
_SHOWN = {}


def _layout(**settings):
    return widgets.Layout(**settings)
