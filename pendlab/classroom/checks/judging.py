"""How an answer is judged: against the truth, and against what usual mistakes would have given."""

from dataclasses import dataclass, replace
from functools import wraps
from inspect import isgeneratorfunction
from itertools import chain

import numpy as np

from ..._arguments import array, found
from ...parameters import load
from ..own_rig import my_rig

WORDS = {True: ("✓", "Right"), False: ("…", "Not yet"), None: ("…", "Not answered yet")}
FOUND_TOO = "That is what we find too."


@dataclass(frozen=True)
class Verdict:
    """Whether an answer is right (None: there is none yet), and a sentence: praise or a hint.

    `share` is the part of the points that the answer earns, from 0 to 1: all or nothing, except
    where several values are asked for and some are right.
    """

    right: bool | None
    message: str
    share: float | None = None

    def __post_init__(self):
        if self.share is None:
            object.__setattr__(self, "share", float(bool(self.right)))

    def __bool__(self):
        return bool(self.right)

    def __repr__(self):
        return f"{WORDS[self.right][1]}: {self.message}"

    def _repr_markdown_(self):
        mark, word = WORDS[self.right]
        return f"{mark} **{word}.** {self.message}"


def compare(
    name,
    answer,
    truth,
    mistakes=(),
    tolerance=5e-3,
    *,
    praise=None,
    apart=False,
    each=False,
):
    """Judge numbers: within `tolerance` (relative to the largest entry) of the truth or not.

    The default accepts what is copied with three digits.

    Parameters
    ----------
    name : of the answer, for hints
    answer, truth : number or array
    mistakes : (value, hint) pairs, what a particular mistake would have given; the usual ones
        (sign, degrees, hertz, transposed, reciprocal, reversed order) are always tried
    apart : the entries are answers of their own, and each that is right earns its share
    each : the tolerance is relative to each entry, where units differ

    Returns
    -------
    Verdict
    """
    try:
        verdict = _compare(name, answer, truth, mistakes, tolerance, praise, each)
    except (ValueError, TypeError) as problem:
        return Verdict(False, f"This answer cannot be checked: {problem}")
    if not apart or verdict or np.shape(answer) != np.shape(truth):
        return verdict
    right = [close(a, t, tolerance) for a, t in zip(np.ravel(answer), np.ravel(truth))]
    return replace(verdict, share=float(np.mean(right)))


def _compare(name, answer, truth, mistakes, tolerance, praise, each):
    if answer is None or answer is ...:
        return Verdict(False, f"{name} has no value yet.")
    counted = np.issubdtype(np.asarray(truth).dtype, np.integer)
    truth = np.asarray(truth, dtype=complex if np.iscomplexobj(truth) else float)
    if np.iscomplexobj(answer) and not np.iscomplexobj(truth):
        return Verdict(
            False, f"{name} is a real quantity, yours is complex; look at its imaginary part."
        )
    answer = (
        np.asarray(answer, dtype=truth.dtype)
        if np.iscomplexobj(truth)
        else array(name, answer, finite=False)
    )
    if truth.ndim == 0 and answer.size == 1:
        answer = answer.reshape(())  # as solvers return one number
    if not np.all(np.isfinite(answer)):
        return Verdict(False, f"{name} holds nan or inf; something was divided by zero on the way.")
    if answer.shape == truth.shape and close(answer, truth, tolerance, each):
        return Verdict(True, praise or FOUND_TOO)
    for value, hint in chain(mistakes, usual_mistakes(name, truth)):
        value = np.asarray(value)
        if answer.shape == value.shape and close(answer, value, tolerance, each):
            return Verdict(False, hint)
    if answer.shape != truth.shape:
        wanted = f"have shape {truth.shape}" if truth.ndim else "be one number"
        return Verdict(False, f"{name} should {wanted}, yours has shape {answer.shape}.")
    if answer.size > 1:
        off = np.abs(answer - truth) / (np.abs(truth) + 1e-12 if each else 1)
        wrong = int(np.argmax(off.ravel()))
        place = tuple(int(i) for i in np.unravel_index(wrong, truth.shape))
        return Verdict(False, f"{name}: look again at entry {place}, where yours is furthest off.")
    answer, truth = answer.ravel()[0], truth.ravel()[0]
    if not counted and abs(answer - truth) < 0.2 * abs(truth):
        wanted = f"{100 * tolerance:.2g} %"
        return Verdict(False, f"{name} is near, off by less than a fifth; {wanted} is asked for.")
    if np.real(answer * truth) < 0:
        return Verdict(False, f"{name} has the wrong sign, and not the right size either.")
    size = "large" if abs(answer) > abs(truth) else "small"
    return Verdict(False, f"{name} is too {size}{' in magnitude' if np.real(truth) < 0 else ''}.")


def close(answer, truth, tolerance, each=False):
    """Within `tolerance` of a finite truth, relative to its largest (or each) entry."""
    if not np.all(np.isfinite(truth)):
        return False
    scale = np.abs(truth) if each else np.max(np.abs(truth), initial=0)
    return bool(np.all(np.abs(answer - truth) <= tolerance * np.maximum(scale, 1e-12)))


def usual_mistakes(name, truth):
    """What sign, units, transposition and order would make of the truth."""
    yield -truth, f"{name} has the opposite sign; check which way counts as positive."
    if not np.iscomplexobj(truth):
        yield np.degrees(truth), f"{name} seems to be in degrees; the package uses radians."
    for factor in (2 * np.pi, 1 / (2 * np.pi)):
        yield truth * factor, f"{name} is off by 2 pi: hertz and rad/s are mixed."
    yield truth * 1000, f"{name} is 1000 times too large: milli-units?"
    yield truth / 1000, f"{name} is 1000 times too small: milli-units?"
    if np.all(truth != 0):
        yield 1 / truth, f"{name} is upside down: the reciprocal is asked for."
    if truth.ndim == 2:
        yield truth.T, f"{name} is transposed."
    if truth.ndim == 1 and truth.size > 1:
        yield truth[::-1], f"{name} holds the right numbers in the opposite order."


def asks(name, judge=compare, **how):
    """Decorate a table of one answer: what it may be, and what is said to it.

    The function gets the rig and yields rows of a value and a sentence: first the right value with
    its praise (None: the usual one), then what each usual mistake would give, with its hint. Rows
    are computed until one fits. `judge` gets what `compare` gets, with `how`.
    """

    def decorate(table):
        @wraps(table)
        def check(answer=None, rig=None):
            rows = table(rig)
            truth, praise = next(rows)
            return judge(name, answer, truth, rows, praise=praise, **how)

        return check

    return decorate


def on(base, own=None, who=None):
    """Decorate a check with the rig that it is about; one that yields is `judged`.

    Parameters
    ----------
    base : "double" or "triple"; the paper's rig of this name where none is passed
    own : how the check is called, where the student's own rig is asked for; then the paper's, or
        none, gives a verdict
    who : name of the student whose rig is taken where none is passed, and the paper's gives a
        verdict
    """

    def decorate(function):
        judge = judged(function) if isgeneratorfunction(function) else function

        @wraps(function)
        def check(*answer, rig=None):
            if rig is None and own:
                return Verdict(False, f"Pass your own rig along: pl.check({own}).")
            if (own or who) and rig in [load(name) for name in ("double", "triple")]:
                return Verdict(
                    False, 'That is the paper\'s rig; make your own with pl.my_rig("your name").'
                )
            if rig is None:
                rig = my_rig(who, base) if who else load(base)
            if rig.n_links != load(base).n_links:
                return Verdict(
                    False, f"This is about the {base}; your rig has {rig.n_links} links."
                )
            return judge(*answer, rig=rig)

        return check

    return decorate


def judged(function):
    """Decorate a check that yields what is wrong and returns its praise.

    It yields sentences, verdicts, or None where nothing is wrong; the first that is wrong is the
    hint, and what comes after it, which may need a stable loop, is not computed.
    """

    @wraps(function)
    def check(*answer, rig=None):
        steps = function(*answer, rig=rig)
        try:
            while True:
                wrong = next(steps)
                if isinstance(wrong, str):
                    return Verdict(False, wrong)
                if wrong is not None and not wrong:
                    return wrong
        except StopIteration as end:
            return Verdict(True, end.value)

    return check


def not_callable(answer, wanted):
    """A sentence where the answer is no function."""
    return None if callable(answer) else f"Expected {wanted}, {found(answer)}."


def all_right(*verdicts):
    """The first verdict that is not right, or the last one; each earns an equal share."""
    told = next((verdict for verdict in verdicts if not verdict), verdicts[-1])
    return replace(told, share=float(np.mean([verdict.share for verdict in verdicts])))


def choose(name, answer, truth, hints):
    """Judge a choice among words; `hints` has one sentence for every wrong word."""
    answer = str(answer).strip().lower()
    if answer == str(truth).lower():
        return Verdict(True, FOUND_TOO)
    known = sorted({str(truth).lower(), *map(str.lower, hints)})
    if answer not in known:
        return Verdict(False, f"{name} should be one of {', '.join(known)}.")
    return Verdict(False, hints[answer])
