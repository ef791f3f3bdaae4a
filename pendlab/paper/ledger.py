"""The paper's printed numbers and how many digits of each it gives: ``data/published.toml``."""

from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from difflib import get_close_matches
from functools import cached_property, lru_cache

import numpy as np

from .._arguments import array, found, text
from ..parameters import DATA, read_toml

# Room for the rounding of binary fractions, in half digits: 0.125 holds as 0.13 and as 0.12.
SLACK = 1e-9


@dataclass(frozen=True)
class Published:
    """One number, vector or matrix as the paper prints it."""

    key: str  # short stable name, such as "eq1.A"
    place: str  # where in the paper, such as "equation (1)"
    unit: str  # SI; "1" for a pure number
    printed: str  # the digits, entries separated by spaces, one matrix row per line
    note: str = ""  # how the entry was read
    known: str = ""  # why the number is known not to be reproduced; empty where it should be

    def __post_init__(self):
        for name in FIELDS:
            text(name, getattr(self, name), empty=name not in REQUIRED)
        self._arrange(float)

    @cached_property
    def values(self):
        """The printed numbers: shape () for one, (k,) for one line of several, else rows x columns.

        >>> Published("k", "here", "1", "1 -0.50").values
        array([ 1. , -0.5])
        """
        return self._arrange(float)

    @cached_property
    def half_digit(self):
        """Half a unit of the last printed digit of each entry, in the shape of `values`.

        The last digit of 6.6684e-2 stands for 1e-6. A whole number, the 0 and 1 of a structural
        matrix included, counts as printed to the unit: its half digit is 0.5.

        >>> Published("k", "here", "1", "6.6684e-2 -0.50 12").half_digit.tolist()
        [5e-07, 0.005, 0.5]
        """
        return self._arrange(lambda entry: float(Decimal(5).scaleb(entry.as_tuple().exponent - 1)))

    def worst(self, ours):
        """Largest distance of `ours` from `values`, in half digits; up to 1 the digits agree.

        `ours` is real, has the shape of `values` up to axes of length 1, entries in printed order.

        >>> f"{pl.published('sec4.double.E').worst(0.91):.1f}"
        '0.2'
        """
        if np.iscomplexobj(ours):
            raise TypeError(f"ours: {self.key} is real, found complex numbers; take the real part.")
        ours = array("ours", ours, finite=False)
        if np.squeeze(ours).shape != np.squeeze(self.values).shape:
            raise ValueError(
                f"ours: {self.key} is printed with shape {self.values.shape}, "
                f"found shape {ours.shape}."
            )
        difference = np.abs(ours.reshape(self.values.shape) - self.values)
        return float(np.max(difference / self.half_digit))

    def holds(self, ours):
        """Whether every entry of `ours` agrees to half a unit of the last printed digit.

        >>> pl.published("eq18.eigenvalue.k_p_10").holds(0.14884)
        True
        """
        return self.worst(ours) <= 1 + SLACK

    def _arrange(self, number):
        rows = [
            [number(_decimal(entry)) for entry in row.split()] for row in self.printed.splitlines()
        ]
        if len({len(row) for row in rows}) != 1 or not rows[0]:
            lengths = ", ".join(str(len(row)) for row in rows)
            raise ValueError(f"printed: expected rows of equal length, found lengths {lengths}.")
        result = np.array(rows if len(rows) > 1 else rows[0])
        result = result.reshape(()) if result.size == 1 else result
        result.setflags(write=False)
        return result


REQUIRED = ("key", "place", "unit", "printed")
FIELDS = (*REQUIRED, "note", "known")


def published(key=None):
    """One printed number by key, or all of them as a tuple in the paper's order.

    ValueError names keys near an unknown one, or file and entry of a damaged ledger.

    >>> pl.published("sec4.double.R").values
    array(3.)
    """
    entries = _ledger(DATA / "published.toml")
    if key is None:
        return tuple(entries.values())
    if not isinstance(key, str) or key not in entries:
        near = get_close_matches(str(key), entries, n=3, cutoff=0.5)
        advice = f"near it are {', '.join(near)}" if near else "published() lists all"
        raise ValueError(f"key: no published number {key!r}; {advice}.")
    return entries[key]


@lru_cache
def _ledger(path):
    """All entries of the file by key."""
    tables = read_toml(path).get("entry")
    if not isinstance(tables, list) or not tables:
        raise ValueError(f"{path}: expected tables [[entry]], {found(tables)}; restore the file.")
    ledger = {}
    for i, table in enumerate(tables, 1):
        name = table.get("key") if isinstance(table, dict) else None
        try:
            entry = _entry(table)
            if entry.key in ledger:
                raise ValueError(f"key: {entry.key!r} is there twice; keys must differ.")
        except (TypeError, ValueError) as problem:
            raise ValueError(f"{path}: entry {i} ({name or 'without key'}): {problem}") from None
        ledger[entry.key] = entry
    return ledger


def _entry(table):
    if not isinstance(table, dict):
        raise TypeError(f"expected a table, {found(table)}.")
    wrong = [f"{name!r} is missing" for name in REQUIRED if name not in table]
    wrong += [f"{name!r} is not a field" for name in table if name not in FIELDS]
    if wrong:
        raise ValueError(f"{', '.join(wrong)}; the fields are {', '.join(FIELDS)}.")
    return Published(**table)


def _decimal(entry):
    try:
        value = Decimal(entry)
    except InvalidOperation:
        value = Decimal("nan")
    if not value.is_finite():
        raise ValueError(f"printed: expected finite numbers, found {entry!r}.")
    return value
