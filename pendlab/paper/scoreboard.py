"""The scoreboard: every number that the paper prints, ours, and the verdict."""

from dataclasses import dataclass, replace
from html import escape

import numpy as np

from .._arguments import found
from .experiment import FIGURES, tick_hits, tick_intervals
from .ledger import Published, published
from .recomputed import RECOMPUTED, SHARES

REPRODUCED, FITS, KNOWN = "reproduced", "fits", "known difference"
GIVEN, DIFFERS = "given", "DIFFERS"
HEADER = ("place", "number", "printed", "ours", "verdict")


@dataclass(frozen=True)
class Score:
    """One line of the scoreboard."""

    entry: Published
    ours: np.ndarray | None = None  # in the shape of ``entry.values``; None: the paper's
    share: float | None = None  # of the bench's runs for which it holds; None: no experiment

    @property
    def verdict(self):
        """reproduced: every printed digit; fits: at least half of the bench's runs lie in the printed
        tick, or do what the text says; known difference: neither, and the ledger says why; given: a
        choice or a fact that is taken over; DIFFERS: not reproduced, and it should be."""
        if self.share is not None and self.share >= 0.5:
            return FITS
        if self.share is None and self.ours is None:
            return GIVEN
        if self.share is None and self.entry.holds(self.ours):
            return REPRODUCED
        return KNOWN if self.entry.known else DIFFERS


@dataclass(frozen=True)
class Scoreboard:
    """All scores in the order of the paper; prints as text and shows as a table in a notebook."""

    scores: tuple

    @property
    def totals(self):
        verdicts = [score.verdict for score in self.scores]
        return {name: verdicts.count(name) for name in (REPRODUCED, FITS, KNOWN, GIVEN, DIFFERS)}

    @property
    def rows(self):
        """(place, key, printed, ours, verdict) as text, one per number or matrix."""
        return [
            (s.entry.place, s.entry.key, _short(s.entry, s.entry.values), _result(s), s.verdict)
            for s in self.scores
        ]

    def __str__(self):
        table = [HEADER, *self.rows]
        widths = [max(len(row[i]) for row in table) for i in range(5)]
        lines = [
            "  ".join(cell.ljust(w) for cell, w in zip(row, widths, strict=True)).rstrip()
            for row in table
        ]
        lines.insert(1, "-" * (sum(widths) + 8))
        reasons = [f"  {s.entry.key}: {s.entry.known}" for s in self.scores if s.verdict == KNOWN]
        if reasons:
            lines += ["", "Known differences:", *reasons]
        totals = ", ".join(f"{count} {name}" for name, count in self.totals.items())
        return "\n".join([*lines, "", f"{len(self.scores)} entries: {totals}."])

    # The fields' own repr would show unrounded numbers, which differ from machine to machine.
    __repr__ = __str__

    def _repr_html_(self):
        head = "".join(f"<th>{name}</th>" for name in HEADER)
        body = "".join(
            "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>"
            for row in self.rows
        )
        return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def scoreboard(keys=None):
    """Recompute the paper: a `Scoreboard` with a verdict for every printed number.

    Parameters
    ----------
    keys : only entries whose key starts with one of these (a string or a list of them), such as
        ``"eq23"``; all where None

    >>> pl.scoreboard("eq23").totals["reproduced"]
    1
    """
    wanted = ("",) if keys is None else (keys,) if isinstance(keys, str) else keys
    if not isinstance(wanted, (list, tuple)) or not all(isinstance(key, str) for key in wanted):
        raise TypeError(f"keys: expected the beginning of a key or a list of them, {found(keys)}.")
    wanted = tuple(wanted)
    entries = [entry for entry in published() if entry.key.startswith(wanted)]
    if not entries:
        raise ValueError(
            f"keys: no printed number has a key that starts with {keys!r}; "
            "pl.published() lists all."
        )
    return Scoreboard(tuple(score for entry in entries for score in _scores(entry)))


def _scores(entry):
    """One line for an entry; for an axis of Figs 15 to 17 one for each end, as the ticks bound it."""
    if entry.key.endswith(".y_axis"):
        yield from _ends(entry)
    elif entry.key in SHARES:
        yield Score(entry, share=SHARES[entry.key]())
    elif entry.key in RECOMPUTED:
        yield Score(entry, np.asarray(RECOMPUTED[entry.key](), dtype=float))
    else:
        yield Score(entry)


def _ends(axis):
    """Scores of the smallest and the largest reading of a panel."""
    panel = axis.key.removeprefix("fig").removesuffix(".y_axis")
    name = next(name for name, (figures, _) in FIGURES.items() if panel[:2] in figures)
    hits, intervals = tick_hits(name), tick_intervals(name)
    for end in ("min", "max"):
        low, high = intervals[f"{panel} {end}"]
        share = hits[f"{panel} {end}"]
        entry = replace(
            axis,
            key=f"{axis.key}.{end}",
            printed=f"{low:g} {high:g}",
            note="between the axis limit and the tick next to it",
            known=axis.known if share < 0.5 else "",
        )
        yield Score(entry, share=share)


def _result(score):
    """Our number, or the share of the runs, to ten per cent: another machine gives others."""
    if score.share is not None:
        return f"in {round(score.share, 1):.0%} of runs"
    if score.ours is None:
        return ""
    return _short(score.entry, score.ours, more=score.verdict != REPRODUCED)


def _short(entry, values, more=0):
    """Numbers to the printed digits and `more`; a large matrix by its misfit."""
    values = np.asarray(values, dtype=float).reshape(entry.values.shape)
    if values.size > 8:
        if values is entry.values or np.array_equal(values, entry.values):
            return " x ".join(map(str, values.shape)) + " matrix"
        return f"largest difference {entry.worst(values):.2f} half digits"
    digits = -np.floor(np.log10(2 * entry.half_digit) + 0.5).astype(int)
    digits = np.maximum(0, digits + more)
    pairs = zip(np.ravel(values), np.ravel(digits), strict=True)
    return " ".join(f"{value:.{places}f}" for value, places in pairs)
