"""How an answer is judged: against the truth, and against what usual mistakes would have given."""

from dataclasses import dataclass, replace
from functools import wraps
from inspect import isgenerator
from itertools import chain, groupby

import numpy as np

from ..._arguments import array, found
from ...parameters import load
from ..own_rig import my_rig
from .symbolic import formula_hint

WORDS = {True: ("✓", "Right"), False: ("…", "Not yet"), None: ("…", "Not answered yet")}
FOUND_TOO = "That is what we find too."


@dataclass(frozen=True)
class Verdict:
    """Whether an answer is right (None: there is none yet), and a sentence: praise or a hint.

    `share` is the part of the points that the answer earns, from 0 to 1: all or nothing, except
    where several values are asked for and some are right. A sentence may be broken into lines.
    """

    right: bool | None
    message: str
    share: float | None = None

    def __post_init__(self):
        object.__setattr__(self, "message", " ".join(self.message.split()))
        if self.share is None:
            object.__setattr__(self, "share", float(bool(self.right)))

    def __bool__(self):
        return bool(self.right)

    def __repr__(self):
        return f"{WORDS[self.right][1]}: {self.message}"

    def _repr_markdown_(self):
        mark, word = WORDS[self.right]
        return f"{mark} **{word}.** {self.message}"


def compare(name, answer, truth, mistakes=(), tolerance=5e-3, *, praise=None, apart=False, **how):
    """`Verdict` on numbers: within `tolerance` (relative to the largest entry) of the truth or not.

    Parameters
    ----------
    name : of the answer, for hints
    answer, truth : number, array or SymPy matrix
    mistakes : (value, hint) pairs, what a particular mistake would have given; the usual ones
        (sign, degrees, hertz, transposed, reciprocal, reversed order) are always tried
    tolerance : the default accepts what is copied with three digits
    praise : said of the truth, in place of the usual sentence
    apart : the entries are answers of their own, and each that is right earns its share
    how : of numbers, ``each=True``: the tolerance is relative to each entry, where units differ; of
        formulas, ``new``: name of a symbol of the truth that may go by any name in the answer
    """
    try:
        if hasattr(truth, "applyfunc"):
            hint = formula_hint(name, answer, truth, mistakes, **how)
        else:
            hint = _hint(name, answer, truth, mistakes, tolerance, **how)
    except (ValueError, TypeError) as problem:
        return Verdict(False, f"This answer cannot be checked: {problem}")
    told = Verdict(hint is None, hint or praise or FOUND_TOO)
    if not apart or told or np.shape(answer) != np.shape(truth):
        return told
    right = [close(a, t, tolerance) for a, t in zip(np.ravel(answer), np.ravel(truth))]
    return replace(told, share=float(np.mean(right)))


def _hint(name, answer, truth, mistakes, tolerance, each=False):
    """What to say about numbers that are not the truth, or None."""
    if answer is None or answer is ...:
        return f"{name} has no value yet."
    counted = np.issubdtype(np.asarray(truth).dtype, np.integer)
    truth = np.asarray(truth, dtype=complex if np.iscomplexobj(truth) else float)
    if np.iscomplexobj(truth):
        answer = np.asarray(answer, dtype=complex)
    elif np.iscomplexobj(answer):
        return f"{name} is a real quantity, yours is complex; look at its imaginary part."
    else:
        answer = array(name, answer, finite=False)
    if truth.ndim == 0 and answer.size == 1:
        answer = answer.reshape(())  # as solvers return one number
    if not np.all(np.isfinite(answer)):
        return f"{name} holds nan or inf; something was divided by zero on the way."
    for value, hint in chain([(truth, None)], mistakes, usual_mistakes(name, truth)):
        if close(answer, value, tolerance, each):
            return hint
    if answer.shape != truth.shape:
        wanted = f"have shape {truth.shape}" if truth.ndim else "be one number"
        return f"{name} should {wanted}, yours has shape {answer.shape}."
    if answer.size > 1:
        off = np.abs(answer - truth) / (np.abs(truth) + 1e-12 if each else 1)
        place = tuple(map(int, np.unravel_index(off.argmax(), off.shape)))
        return f"{name}: look again at entry {place}, where yours is furthest off."
    answer, truth = answer.ravel()[0], truth.ravel()[0]
    if not counted and abs(answer - truth) < 0.2 * abs(truth):
        wanted = f"{100 * tolerance:.2g} %"
        return f"{name} is near, off by less than a fifth; {wanted} is asked for."
    if np.real(answer * truth) < 0:
        return f"{name} has the wrong sign, and not the right size either."
    size = "large" if abs(answer) > abs(truth) else "small"
    return f"{name} is too {size}{' in magnitude' if np.real(truth) < 0 else ''}."


def close(answer, truth, tolerance, each=False):
    """Within `tolerance` of a finite truth of this shape, relative to its largest (or each) entry."""
    if np.shape(answer) != np.shape(truth) or not np.all(np.isfinite(truth)):
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


def asks(*names, base=None, own=None, who=None, **how):
    """Decorate a table: what each answer may be, and what is said to it.

    The function gets the rig and yields rows of a value and a sentence: first the right value with
    its praise (None: the usual one), then what each usual mistake would give, with its hint. Rows
    are computed until one fits. Of several answers each but the first has its name yielded before
    its rows. `base`, `own` and `who` are those of `on`, and `how` goes to `compare`.
    """

    def decorate(table):
        @wraps(table)
        def check(*answers, rig=None):
            if len(answers) > len(names):
                asked = ", ".join(names)
                return Verdict(False, f"Asked for: {asked}; given were {len(answers)} answers.")
            answers += (None,) * (len(names) - len(answers))
            parts = groupby(table(rig), lambda row: isinstance(row, str))
            parts = (rows for is_name, rows in parts if not is_name)
            verdicts = []
            for name, answer, rows in zip(names, answers, parts):
                truth, praise = next(rows)
                verdicts.append(compare(name, answer, truth, rows, praise=praise, **how))
            return all_right(*verdicts)

        return on(base, own, who)(check)

    return decorate


def on(base=None, own=None, who=None):
    """Decorate a check with the rig that it is about; of one that yields, give the `verdict`.

    `base` is "double" or "triple": where none is passed, the paper's rig of this name, or that of
    the student `who`. Where the student's `own` rig must be passed, `own` is how the check is
    called. With `own` or `who` the paper's rig gives a verdict.
    """

    def decorate(function):
        @wraps(function)
        def check(*answer, rig=None):
            if rig is None and own:
                return Verdict(False, f"Pass your own rig along: pl.check({own}).")
            if (own or who) and rig in [load(name) for name in ("double", "triple")]:
                mine = 'make your own with pl.my_rig("your name").'
                return Verdict(False, f"That is the paper's rig; {mine}")
            if rig is None and base:
                rig = my_rig(who, base) if who else load(base)
            if base and rig.n_links != load(base).n_links:
                yours = f"your rig has {rig.n_links} links."
                return Verdict(False, f"This is about the {base}; {yours}")
            told = function(*answer, rig=rig)
            return verdict(told) if isgenerator(told) else told

        return check

    return decorate


def verdict(steps):
    """`Verdict` of a generator that yields what is wrong and returns its praise.

    It yields sentences, verdicts, or None where nothing is wrong; the first that is wrong is the
    hint, and what comes after it, which may need a stable loop, is not computed.
    """
    try:
        while True:
            wrong = next(steps)
            if isinstance(wrong, str):
                return Verdict(False, wrong)
            if wrong is not None and not wrong:
                return wrong
    except StopIteration as end:
        return Verdict(True, end.value)


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
    if answer == truth:
        return Verdict(True, FOUND_TOO)
    known = ", ".join(sorted({truth, *hints}))
    return Verdict(False, hints.get(answer, f"{name} should be one of {known}."))
