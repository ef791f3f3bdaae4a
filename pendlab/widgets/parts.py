"""What a panel is made of, told apart from its widgets: sliders, switches, choices and a view."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .._arguments import number

NOTCH = 0.05  # decades between two positions of a logarithmic slider


@dataclass(frozen=True)
class Slider:
    """A number with a slider and a linked number field.

    Parameters
    ----------
    name : of the argument that the update function takes
    label : what it is, with its unit, such as ``"k_p, V/rad"``
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
        if self.clipped(self.value) != self.value:
            raise ValueError(
                f"{self.name} value: expected {self.low:g} to {self.high:g}"
                f"{' or 0' if self.zero else ''}, found {self.value:g}."
            )

    @property
    def span(self):
        """First and last slider position and the step between positions."""
        if not self.log:
            return self.low, self.high, self.step or (self.high - self.low) / 100
        first, last = np.log10(self.low), np.log10(self.high)
        return first - (NOTCH if self.zero else 0), last, NOTCH

    @property
    def stops(self):
        """The ends that tests move to."""
        return [0.0, self.low, self.high] if self.zero else [self.low, self.high]

    def clipped(self, value):
        """`value` brought between the ends."""
        return min(max(number(self.name, value), 0.0 if self.zero else self.low), self.high)

    def value_at(self, position):
        """The value at a slider position, to three digits where it moves in decades."""
        if not self.log:
            return float(f"{position:.6g}")
        if self.zero and position < np.log10(self.low) - NOTCH / 5:
            return 0.0
        return self.clipped(float(f"{10**position:.3g}"))

    def position_of(self, value):
        """The slider position of a value."""
        first, last, _ = self.span
        if self.log:
            value = np.log10(value) if value > 0 else first
        return float(min(max(value, first), last))


@dataclass(frozen=True)
class Switch:
    """Something that is on or off."""

    name: str
    label: str
    value: bool = False

    @property
    def stops(self):
        """The ends that tests move to."""
        return [not self.value]

    def clipped(self, value):
        """`value` as True or False."""
        return bool(value)


@dataclass(frozen=True)
class Choice:
    """One of several: `options` maps what is shown to the value that the update function takes."""

    name: str
    label: str
    options: dict
    value: object

    @property
    def stops(self):
        """The ends that tests move to."""
        return list(self.options.values())

    def clipped(self, value):
        """`value` itself, or a ValueError that names what can be chosen."""
        if value not in self.stops:
            known = ", ".join(map(str, self.stops))
            raise ValueError(f"{self.name}: expected one of {known}, found {value!r}.")
        return value


@dataclass(frozen=True)
class View:
    """What a panel shows: a figure, and how to move it.

    Attributes
    ----------
    figure : Agg figure, laid out once
    update : function of the controls' values by name; changes the artists and returns the caption,
        plain text with the outcome in words; raises ValueError with a sentence for values that
        cannot work, before it changes anything
    moving : artists that are redrawn on a kept background; the whole figure where it is empty
    beside : function without arguments that gives HTML to show beside the picture, such as an SVG
    """

    figure: object
    update: Callable
    moving: tuple = ()
    beside: Callable | None = None
