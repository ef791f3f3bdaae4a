"""What a panel is made of, told apart from its widgets: sliders, switches, choices and a view."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .._arguments import flag, found, number, text
from ..bench.arguments import function, mapping, one_of
from ..figures.picture import check_artists

NOTCH = 0.05  # decades between two positions of a logarithmic slider


@dataclass(frozen=True)
class Slider:
    """A number with a slider and a linked number field.

    Parameters
    ----------
    name : of the argument that the update function takes
    label : what it is, with its unit behind the last comma, such as ``"k_p, V/rad"``
    low, high : ends of the slider; the field takes no other numbers
    value : where it starts; marked on the slider
    log : the slider moves in decades; with `zero` its lowest notch stands for 0
    step : of a linear slider; log sliders move by a twentieth of a decade

    >>> Slider("k_p", "k_p, V/rad", 0.1, 100, 10, log=True).spoken(10.0)
    '10 V/rad'
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
        _named(self)
        flag(f"{self.name} log", self.log)
        flag(f"{self.name} zero", self.zero)
        number(f"{self.name} low", self.low, above=0 if self.log else None)
        number(f"{self.name} high", self.high, above=self.low)
        if self.step is not None:
            number(f"{self.name} step", self.step, above=0)
        self._checked(f"{self.name} value", self.value)

    @property
    def last(self):
        """The highest position; positions are whole numbers from 0 on."""
        return max(1, self.position_of(self.high))

    @property
    def _step(self):
        return self.step or (self.high - self.low) / 100

    def checked(self, value):
        """`value` as a number between the ends, or a sentence on why not."""
        return self._checked(self.name, value)

    def _checked(self, name, value):
        value = number(name, value)
        if self.low <= value <= self.high or (self.zero and value == 0):
            return value
        raise ValueError(
            f"{name}: expected {self.low:g} to {self.high:g}"
            f"{' or 0' if self.zero else ''}, found {value:g}."
        )

    def value_at(self, position):
        """The value at a position, to three digits where it moves in decades."""
        place = int(min(max(number("position", position), 0), self.last)) - self.zero
        if place < 0:
            return 0.0
        value = self.low * 10 ** (NOTCH * place) if self.log else self.low + place * self._step
        return min(max(float(f"{value:.{3 if self.log else 6}g}"), self.low), self.high)

    def position_of(self, value):
        """The position nearest to a value."""
        value = min(number("value", value), self.high)
        if value < self.low:
            return 0
        place = np.log10(value / self.low) / NOTCH if self.log else (value - self.low) / self._step
        return round(place) + self.zero

    @property
    def ticks(self):
        """Positions to mark, with what to write there: ends, decades or zero."""
        marks = sorted({self.low, min(max(0.0, self.low), self.high), self.high})
        if self.log:
            first, last = np.ceil(np.log10(self.low)), np.floor(np.log10(self.high))
            marks = [10.0**decade for decade in np.arange(first, last + 1)]
        return [(0, "0")] * self.zero + [(self.position_of(value), "") for value in marks]

    def spoken(self, value):
        """The value with its unit, as a screen reader says it."""
        value = number("value", value)
        _, _, unit = self.label.rpartition(", ")
        return f"{value:g} {unit}" if unit != self.label else f"{value:g}"

    def read(self, text):
        """The value that was typed; a comma may stand for the point."""
        try:
            value = float(str(text).strip().replace(",", "."))
        except ValueError:
            raise ValueError(f"{self.name}: expected a number, {found(text)}.") from None
        return self.checked(value)


@dataclass(frozen=True)
class Switch:
    """Something that is on or off."""

    name: str
    label: str
    value: bool = False
    stops = (False, True)  # the value at each position

    def __post_init__(self):
        _named(self)
        flag(f"{self.name} value", self.value)

    def checked(self, value):
        """`value` as True or False."""
        return flag(self.name, value)


@dataclass(frozen=True)
class Choice:
    """One of several: `options` maps what is shown to the value that the update function takes."""

    name: str
    label: str
    options: dict
    value: object

    def __post_init__(self):
        _named(self)
        mapping(f"{self.name} options", self.options, '{"shown": value}')
        one_of(f"{self.name} value", self.value, self.stops)

    @property
    def stops(self):
        """The value at each position."""
        return list(self.options.values())

    def checked(self, value):
        """`value` itself, or a ValueError that names what can be chosen."""
        return one_of(self.name, value, self.stops)


def _named(control):
    """The name and the label of a control are text."""
    text("name", control.name)
    text(f"{control.name} label", control.label)


@dataclass(frozen=True)
class View:
    """What a panel shows: a figure, and how to move it.

    Attributes
    ----------
    figure : Agg figure, laid out once. What it carries is shown with it: ``alt``, the description;
        ``verdict``, (word, whether it is good); ``table``, rows of text, the first one the heads;
        ``lead``, the sentences that the table leaves
    update : function of the controls' values by name; changes the artists and returns the caption,
        plain text with the outcome in words; raises ValueError with a sentence for values that
        cannot work, before it changes anything
    moving : artists that are redrawn on a kept background; the whole figure where it is empty
    beside : function without arguments that gives HTML to show beside the picture, such as an SVG
    idle : function of the values that names the controls that move nothing now, and says why
    """

    figure: object
    update: Callable
    moving: tuple = ()
    beside: Callable | None = None
    idle: Callable | None = None

    def __post_init__(self):
        check_artists(self.figure, self.moving)
        function("update", self.update)
        for name, value in (("beside", self.beside), ("idle", self.idle)):
            if value is not None:
                function(name, value)
