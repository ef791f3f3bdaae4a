"""The scoreboard: every number that the paper prints, ours, and the verdict."""

from dataclasses import dataclass, replace
from html import escape

import numpy as np

from .._arguments import found
from ..loop import frequency_response, margins, sorted_eigenvalues
from ..nyquist import encirclements
from ..parameters import load
from ..sampled import align
from . import words
from .alignment import alignment_interval
from .designs import estimating_rows, paper_design
from .experiment import FIGURES, tick_hits, tick_intervals
from .ledger import Published, published

REPRODUCED, FITS, KNOWN = "reproduced", "fits", "known difference"
GIVEN, DIFFERS = "given", "DIFFERS"


@dataclass(frozen=True)
class Score:
    """One line of the scoreboard.

    Attributes
    ----------
    entry : Published
    ours : our numbers in the shape of ``entry.values``, or None where the paper's are taken over
    share : of the bench's runs for which the entry holds, where an experiment is judged, or None
    """

    entry: Published
    ours: np.ndarray | None = None
    share: float | None = None

    @property
    def verdict(self):
        """reproduced: every printed digit; fits: at least half of the bench's runs lie in the printed
        tick, or do what the text says; known difference: neither, and the ledger says why; given: a
        choice or a fact that is taken over; DIFFERS: not reproduced, and it should be."""
        if self.share is not None:
            if self.share >= 0.5:
                return FITS
            return KNOWN if self.entry.known else DIFFERS
        if self.ours is None:
            return GIVEN
        if self.entry.holds(self.ours):
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
            (
                s.entry.place,
                s.entry.key,
                _short(s.entry, s.entry.values),
                _result(s),
                s.verdict,
            )
            for s in self.scores
        ]

    def __str__(self):
        header = ("place", "number", "printed", "ours", "verdict")
        table = [header, *self.rows]
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
        head = "".join(f"<th>{name}</th>" for name in ("place", "printed", "ours", "verdict"))
        body = "".join(
            "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in (row[0], *row[2:])) + "</tr>"
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
    else:
        yield Score(entry, _ours(entry))


def _ends(axis):
    """Scores of the smallest and the largest reading of a panel."""
    panel = axis.key.removeprefix("fig").removesuffix(".y_axis")
    name = next(name for name, (figures, _) in FIGURES.items() if panel[:2] in figures)
    hits, intervals = tick_hits(name), tick_intervals(name)
    for end in ("min", "max"):
        low, high = intervals[f"{panel} {end}"]
        share = hits[f"{panel} {end}"]
        yield Score(
            replace(
                axis,
                key=f"{axis.key}.{end}",
                printed=f"{low:g} {high:g}",
                note="between the axis limit and the tick next to it",
                known=axis.known if share < 0.5 else "",
            ),
            share=share,
        )


def _ours(entry):
    recompute = RECOMPUTED.get(entry.key)
    return None if recompute is None else np.asarray(recompute(), dtype=float)


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


def _double(observer=1):
    return paper_design("double", observer)


def _triple():
    return paper_design("triple")


def _in_printed_order(key, values):
    """Eigenvalues permuted as the paper lists them."""
    ranks = np.argsort(np.argsort(published(key).values))
    return np.sort(np.real(values))[ranks]


def _slow_eigenvalue(kp):
    """The real eigenvalue near 0.15 that the root locus leaves out."""
    return np.abs(np.linalg.eigvals(align(_triple().model, kp).A)).min()


def _locus_branches():
    """How many eigenvalues of A_t1 pass through the frame of Fig 6."""
    (left, right), (bottom, top) = published("fig6.frame").values
    kp = np.linspace(*published("fig6.k_p_range").values, 201)
    values = np.array([sorted_eigenvalues(align(_triple().model, k).A) for k in kp])
    seen = (values.real > left) & (values.real < right)
    seen &= (values.imag > bottom) & (values.imag < top)
    return int(seen.sum(axis=1).max())


def _member(rig, number, part):
    member = paper_design(rig, number).observer
    return {
        "T": member.T,
        "K": member.K,
        "L": estimating_rows(member),
        "copied": np.hstack([member.L1, member.L2])[: member.K.shape[1]],
    }[part]


def _upper(loop):
    """Frequency (Hz) at which the loop crosses the unit circle."""
    return margins(loop).crossover[-1] / (2 * np.pi)


def _lower(loop):
    """Frequency (Hz) at which the loop crosses the real axis to the left of -1."""
    return margins(loop).gain_down_omega / (2 * np.pi)


def det_crossing(loop, low=0.8, high=5.0):
    """Frequency (Hz) between `low` and `high` at which det(I + L) crosses the negative real axis."""
    hz = np.linspace(low, high, 8001)
    det = np.linalg.det(np.eye(loop.ninputs) + frequency_response(loop, 2 * np.pi * hz))
    crossing = np.flatnonzero((np.diff(np.sign(det.imag)) != 0) & (det.real[:-1] < 0))
    i = crossing[0]
    return hz[i] - det.imag[i] * (hz[i + 1] - hz[i]) / (det.imag[i + 1] - det.imag[i])


def _table(rig, kind, field, count=None):
    return [getattr(part, field) for part in getattr(load(rig), kind)][:count]


RECOMPUTED = {
    "table1.gravity": lambda: load("double").g,
    **{
        f"table2.{field}": lambda field=field: _table(
            "triple", "links", field, 2 if field == "length" else None
        )
        for field in ("length", "mass", "inertia", "com", "friction")
    },
    **{
        f"table3.{field}": lambda field=field: _table("triple", "motors", field)
        for field in ("damping", "inertia", "gain", "ratio")
    },
    **{
        f"table4.{field}": lambda field=field: _table(
            "double", "links", field, 1 if field == "length" else None
        )
        for field in ("length", "mass", "inertia", "com", "friction")
    },
    **{
        f"table5.{rig}.{field}": lambda rig=rig, field=field: getattr(load(rig).filters, field)
        for rig in ("double", "triple")
        for field in ("input_hz", "output_hz")
    },
    "eq1.A": lambda: _double().plant.A,
    "eq1.B": lambda: _double().plant.B,
    "eq1.C": lambda: _double().plant.C,
    "eq1.input_limit": lambda: load("double").u_max,
    "eq1.eigenvalues": lambda: _in_printed_order(
        "eq1.eigenvalues", np.linalg.eigvals(_double().plant.A)
    ),
    "eq2.A": lambda: _triple().plant.A,
    "eq2.B": lambda: _triple().plant.B,
    "eq2.C": lambda: _triple().plant.C,
    "eq2.input_limits": lambda: load("triple").u_max,
    "eq2.eigenvalues": lambda: _in_printed_order(
        "eq2.eigenvalues", np.linalg.eigvals(_triple().plant.A)
    ),
    "eq23.F": lambda: _double().F,
    "fig7.encirclements": lambda: encirclements(_double().state_feedback_loop).turns,
    "eq24.solutions": lambda: _double().family.dimension,
    "eq24.K": lambda: _member("double", 1, "K"),
    "eq24.T": lambda: _member("double", 1, "T"),
    "eq25.K": lambda: _member("double", 2, "K"),
    "eq25.T": lambda: _member("double", 2, "T"),
    "eq27.L_copied": lambda: _member("double", 1, "copied"),
    "eq27.L": lambda: _member("double", 1, "L"),
    "eq28.L_copied": lambda: _member("double", 2, "copied"),
    "eq28.L": lambda: _member("double", 2, "L"),
    "fig8.frequencies.nominal.lower": lambda: _lower(_double().loop()),
    "fig8.frequencies.nominal.upper": lambda: _upper(_double().loop()),
    "fig8.frequencies.observer1.lower": lambda: _lower(_double(1).loop(filters=True)),
    "fig8.frequencies.observer1.upper": lambda: _upper(_double(1).loop(filters=True)),
    "fig8.frequencies.observer2.lower": lambda: _lower(_double(2).loop(filters=True)),
    "fig8.frequencies.observer2.upper": lambda: _upper(_double(2).loop(filters=True)),
    "eq18.k_p_interval": lambda: alignment_interval(_triple().model),
    "eq18.unstable": lambda: np.sum(
        np.abs(np.linalg.eigvals(align(_triple().model, _triple().kp).A)) > 1
    ),
    "eq18.eigenvalue.k_p_0": lambda: _slow_eigenvalue(0),
    "eq18.eigenvalue.k_p_10": lambda: _slow_eigenvalue(10),
    "eq18.eigenvalue.k_p_20": lambda: _slow_eigenvalue(20),
    "fig6.eigenvalues": _locus_branches,
    "eq32.F": lambda: _triple().F,
    **{
        f"fig{10 + index}.frequencies.{curve}.{end}": lambda index=index, curve=curve, end=end: (
            _lower if end == "lower" else _upper
        )(_triple().loop(index, filters=curve == "filters"))
        for index in (0, 1)
        for curve in ("nominal", "filters")
        for end in ("lower", "upper")
    },
    "fig11.encirclements": lambda: encirclements(_triple().loop(1)).turns,
    "fig12.encirclements": lambda: encirclements(_triple().nominal_loop).turns,
    "fig12.frequencies.nominal.lower": lambda: det_crossing(_triple().nominal_loop),
    "fig12.frequencies.filters.lower": lambda: det_crossing(_triple().filtered_loop),
    "eq36.solutions": lambda: _triple().family.dimension,
    "eq36.T": lambda: _member("triple", 1, "T"),
    "eq36.K": lambda: _member("triple", 1, "K"),
    "eq37.L_copied": lambda: _member("triple", 1, "copied"),
    "eq37.L": lambda: _member("triple", 1, "L"),
    "sec5.integrator.T_s": lambda: _triple().dt,
    "sec5.integrator.feedback": lambda: _triple().F[0, -1],
}

# Judged on the ensemble: the share of runs for which the words hold.
SHARES = {
    "sec5.attitude_range": words.attitude_share,
    "sec5.triple.alignment": lambda: words.share("triple", words.aligned),
    "sec5.triple.growing_until": lambda: words.share("triple", words.growing),
    "sec5.triple.steady_after": lambda: words.share("triple", words.reduced),
    "sec5.double.steady_after": lambda: words.share("double", words.steady),
}
