"""Controls round a picture that follow each other, in a page that is live and in one that is saved.

A `Panel` keeps one Agg figure, lets a tested update function move its artists, and sends picture,
verdict and words to its `Face` in the browser. Beside the live panel stands its last picture with
alternative text and caption, hidden while the panel lives: what a saved notebook shows without a kernel.
"""

import asyncio
import time
from functools import wraps
from html import escape
from secrets import token_hex
from textwrap import fill
from threading import RLock
from weakref import finalize, proxy

import numpy as np

from .._arguments import flag, found, instance, text
from ..bench.arguments import function, items, mapping
from ..figures.picture import Picture
from ..figures.style import image_html, small_png
from .face import KEYS, Face, running_cell
from .parts import Choice, Slider, Switch, View

SLOW = 0.4  # s; updates that take longer announce themselves
REST = 1.0  # s after the last move until the page's stored picture follows
_CANNOT = (ValueError, ArithmeticError, np.linalg.LinAlgError)
_DRAWING = RLock()


def _one_at_a_time(method):
    """Matplotlib draws in one thread; JupyterLab has moves handled in a second one."""

    @wraps(method)
    def alone(*arguments):
        with _DRAWING:
            return method(*arguments)

    return alone


class Panel:
    """Controls, a picture and a caption that follow each other.

    Parameters
    ----------
    title : heading of the panel
    controls : `Slider`, `Switch` and `Choice` in the order shown; or a dict of such lists by
        heading, each folded under it
    view : `View`
    legend : what each control and part of the picture does; plain text, one line each
    presets : buttons, name -> values by control name, such as ``{"Paper's values": {"k_p": 10}}``
    actions : buttons for what takes longer, name -> function of (values, progress) that returns a
        sentence to add to the caption and calls ``progress(done, all)`` on the way
    continuous : whether the picture follows while a slider is dragged (else when it is let go)
    first : names of the controls that are in sight at once, the rest is folded; all of up to four,
        else three

    Raises
    ------
    TypeError, ValueError : parts that are none, names that come twice or are not known
    """

    def __init__(
        self,
        title,
        controls,
        view,
        legend=(),
        presets=None,
        *,
        actions=None,
        continuous=True,
        first=None,
    ):
        groups = controls if isinstance(controls, dict) else {"More": controls}
        lines = items("legend", legend, "texts")
        self.title, self.view = text("title", title), instance("view", view, View)
        self.controls = _named(groups)
        self._values = {name: control.value for name, control in self.controls.items()}
        self.presets = {**self._known({} if presets is None else presets), "Reset": self.values}
        self.actions = {} if actions is None else dict(mapping("actions", actions, "{}", least=0))
        for name, action in self.actions.items():
            function(f"actions[{name!r}]", action, "a function of (values, progress)")
        self.caption = ""
        self._picture = Picture(view.figure, view.moving)
        self._seconds, self._still, self._rest, self._sound = 0.0, None, None, True
        self._widget = Face(
            face={
                "title": title,
                "groups": self._groups(groups, first),
                "buttons": [*self.presets, *self.actions],
                "legend": [*(text("legend", line) for line in lines), KEYS],
                "width": int(view.figure.bbox.width),
                "still": f"pendlab-{token_hex(4)}",
                "continuous": flag("continuous", continuous),
            }
        )
        panel = proxy(self)
        self._widget.observe(lambda change: panel._moved(change["new"]), "hand")
        # ipywidgets remembers every widget; when nobody holds the panel any more, it may go.
        finalize(self, self._widget.close).atexit = False
        self._redraw()

    @property
    def picture(self):
        """The PNG that is shown."""
        return bytes(self._widget.picture)

    @property
    def values(self):
        """The controls' values by name."""
        return dict(self._values)

    def at(self, **values):
        """Move controls in code; the caption that results.

        Raises
        ------
        ValueError : a control that is not there, or a value that it cannot take
        """
        self._redraw(self._checked(values))
        return self.caption

    def tell(self, **values):
        """The caption with other values of some controls, in short lines; the panel stays as it is.

        >>> import pendlab as pl
        >>> panel = pl.sampling_panel()
        >>> panel.tell(dt=30.0)[:19], panel.values["dt"]
        ('Sampled every 30 ms', 10.0)
        """
        start = self.values
        lines = self.at(**values).splitlines()
        self.at(**start)
        return "\n".join(fill(line, 96, break_on_hyphens=False) for line in lines)

    def act(self, name):
        """Press the button of an action in code; the caption that results."""
        if not isinstance(name, str) or name not in self.actions:
            raise ValueError(
                f"name: expected one of {', '.join(self.actions) or 'no'} actions, {found(name)}."
            )
        try:
            sentence = self.actions[name](self.values, self._show_progress)
        except _CANNOT as problem:
            sentence = f"{name}: {problem}"
        self.caption = f"{self.caption}\n{sentence}"
        self._show(sentence)
        return self.caption

    def close(self):
        """Take the panel's widget out of the page and out of memory."""
        self._widget.close()

    # From the page

    @_one_at_a_time
    def _moved(self, hand):
        """What a hand did in the browser."""
        dots = min(max(float(hand.get("ratio", 1)), 1.0), 2.0)  # of the screen for each of ours
        if 100 * dots != self.view.figure.dpi:
            self.view.figure.set_dpi(100 * dots)
            self._picture = Picture(self.view.figure, self.view.moving)
        if hand.get("button") in self.actions:
            self.act(hand["button"])
        else:
            try:
                values = self._wanted(hand)
            except _CANNOT as problem:
                self._show(f"{problem} It stays as it was.", sound=False)
            else:
                self._redraw(values)
        self._store_soon()

    def _wanted(self, hand):
        """The values that a hand asks for."""
        if "button" in hand:
            return self.presets[hand["button"]]
        if "name" not in hand:
            return {}
        control = self.controls[hand["name"]]
        if "text" in hand:
            return {control.name: control.read(hand["text"])}
        at = control.value_at if isinstance(control, Slider) else control.stops.__getitem__
        return {control.name: at(hand["position"])}

    def _checked(self, values):
        for name in values:
            if name not in self.controls:
                raise ValueError(
                    f"{name}: this panel has no such control; it has {', '.join(self.controls)}."
                )
        return {name: self.controls[name].checked(value) for name, value in values.items()}

    def _known(self, presets):
        """The presets, if each moves controls that are there to values that they can take."""
        known = dict(mapping("presets", presets, '{"Start": {"k_p": 10}}', least=0))
        for name, values in known.items():
            try:
                known[name] = self._checked(mapping("values", values, '{"k_p": 10}'))
            except (TypeError, ValueError) as problem:
                raise type(problem)(f"presets[{name!r}]: {problem}") from None
        return known

    # What is shown

    @_one_at_a_time
    def _redraw(self, values=None):
        """Compute and draw with these values changed."""
        start = time.perf_counter()
        self._values.update(values or {})
        if self._seconds > SLOW:
            self._widget.state = {**self._widget.state, "busy": True}
        try:
            self.caption, self._sound = self.view.update(**self._values), True
        except _CANNOT as problem:
            self.caption, self._sound = f"These values cannot work. {problem}", False
            if self.picture:
                self.caption += " The picture still shows the last ones."
        with self._widget.hold_sync():
            self._show()
            if self._sound or not self.picture:
                self._widget.picture = self._picture.png()
                if self.view.beside is not None:
                    self._widget.beside = self.view.beside()
        self._seconds = time.perf_counter() - start

    def _show(self, more="", sound=None):
        """Send values, verdict and words; `more` is said after them."""
        drawn = vars(self.view.figure)
        told = drawn if self._sound else {"verdict": ("cannot work", False)}
        words = (told.get("lead") or self.caption).split("\n")
        self._widget.state = {
            "values": {
                name: _sent(self.controls[name], self._values[name]) for name in self._values
            },
            "idle": self.view.idle(self.values) if self.view.idle else {},
            "verdict": told.get("verdict"),
            "table": told.get("table", []),
            "words": [*words, more] if more and more not in words else words,
            "sound": self._sound if sound is None else sound,
            "alt": drawn.get("alt") or self.caption,
            "progress": None,
            "count": self._widget.hand.get("count"),
        }

    def _show_progress(self, done, total):
        self._widget.state = {**self._widget.state, "progress": [done, total]}

    def _groups(self, groups, first):
        """What the page shows of the controls: first those in sight, then the rest by heading."""
        names = list(self.controls)
        first = names[: 4 if len(names) <= 4 else 3] if first is None else first
        for name in items("first", first, "names of controls"):
            if name not in names:
                raise ValueError(f"first: expected names of controls, found {name!r}.")
        rest = [(head, [c for c in group if c.name not in first]) for head, group in groups.items()]
        return [
            {"heading": head, "controls": [_told(control) for control in group]}
            for head, group in [("", [self.controls[name] for name in first]), *rest]
            if group or not head
        ]

    # In the page

    def _ipython_display_(self):
        """The live panel, and after it the picture that stays."""
        from IPython.display import display

        # What an earlier run of the cell has left goes, unless it shows elsewhere.
        place = (running_cell(), self.title)
        earlier = _SHOWN.pop(place, None)
        _SHOWN[place] = self
        if earlier is not None and all(earlier is not panel for panel in _SHOWN.values()):
            earlier.close()
        view = self._widget._repr_mimebundle_()
        view = view[0] if isinstance(view, tuple) else view
        display({**view, "text/plain": self.title}, raw=True)
        self._still = display(self.still(), raw=True, display_id=True)

    @_one_at_a_time
    def still(self):
        """The picture with its words as a notebook stores it, hidden where the panel lives."""
        picture = small_png(self.view.figure, self.view.moving)
        mark, alt = self._widget.face["still"], self._widget.state["alt"]
        image = image_html(picture, alt, width=self._widget.face["width"])
        words = "<br>".join(escape(line) for line in self.caption.split("\n"))
        # Without a kernel JupyterLab would show an error in the place of the live panel.
        empty = f".jp-OutputArea-child:has(+ .jp-OutputArea-child .{mark}):not(:has(.pendlab-face))"
        return {
            "text/html": f"<style>{empty} {{ display: none }}</style>"
            f'<div class="{mark}"><b>{escape(self.title)}</b><br>{image}<p>{words}</p></div>',
            "image/png": picture,
            "text/plain": self.caption,
        }

    def _store_soon(self):
        """Let the stored picture follow once the hand rests."""
        if self._still is None:
            return
        try:
            loop = asyncio.get_running_loop()
        except RuntimeError:
            return  # no kernel's loop, as in a script
        if self._rest is not None:
            self._rest.cancel()
        self._rest = loop.call_later(REST, lambda: self._still.update(self.still(), raw=True))

    def __repr__(self):
        return self.caption


# (cell, title) -> the panel shown there. A page shows its panels whether or not a variable holds
# them; running the cell again replaces its entry.
_SHOWN = {}


def _named(groups):
    """The controls by name, checked."""
    kinds, controls = "pl.Slider, pl.Switch or pl.Choice", {}
    for control in (c for group in groups.values() for c in items("controls", group, kinds)):
        if not isinstance(control, (Slider, Switch, Choice)):
            raise TypeError(f"controls: expected {kinds}, {found(control)}.")
        if control.name in controls:
            raise ValueError(f"controls: expected names that differ, found {control.name!r} twice.")
        controls[control.name] = control
    return controls


def _told(control):
    """One control for the page."""
    told = {"name": control.name, "label": control.label, "kind": type(control).__name__.lower()}
    if isinstance(control, Slider):
        start = control.position_of(control.value)
        return {**told, "last": control.last, "start": start, "ticks": control.ticks}
    return {**told, "options": list(map(str, getattr(control, "options", ())))}


def _sent(control, value):
    """A value for the page: its position, and of a slider how it is written and spoken."""
    if isinstance(control, Slider):
        return [control.position_of(value), f"{value:g}", control.spoken(value)]
    return [control.stops.index(value)]
