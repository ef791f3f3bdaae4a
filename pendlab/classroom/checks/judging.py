"""How an answer is judged: against the truth, and against what usual mistakes would have given."""

from dataclasses import dataclass, replace

import numpy as np

from ..._arguments import array
from ...parameters import load

WORDS = {True: ("✓", "Right"), False: ("…", "Not yet"), None: ("…", "Not answered yet")}


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
    tolerance=1e-3,
    *,
    praise="That is what we find too.",
    apart=False,
):
    """Judge numbers: within `tolerance` (relative to the largest entry) of the truth or not.

    Parameters
    ----------
    name : of the answer, for hints
    answer, truth : number or array
    mistakes : (value, hint) pairs, what a particular mistake would have given; the usual ones
        (sign, degrees, hertz, transposed, reciprocal, reversed order) are always tried
    apart : the entries are answers of their own, and each that is right earns its share

    Returns
    -------
    Verdict
    """
    try:
        verdict = _compare(name, answer, truth, mistakes, tolerance, praise)
    except (ValueError, TypeError) as problem:
        return Verdict(False, f"This answer cannot be checked: {problem}")
    if not apart or verdict or np.shape(answer) != np.shape(truth):
        return verdict
    each = [close(a, t, tolerance) for a, t in zip(np.ravel(answer), np.ravel(truth))]
    return replace(verdict, share=float(np.mean(each)))


def _compare(name, answer, truth, mistakes, tolerance, praise):
    if answer is None or answer is ...:
        return Verdict(False, f"{name} is {answer}: it has no value yet.")
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
    if not np.all(np.isfinite(answer)):
        return Verdict(False, f"{name} holds nan or inf; something was divided by zero on the way.")
    if answer.shape == truth.shape and close(answer, truth, tolerance):
        return Verdict(True, praise)
    for value, hint in [*mistakes, *usual_mistakes(name, truth)]:
        value = np.asarray(value)
        if answer.shape == value.shape and close(answer, value, tolerance):
            return Verdict(False, hint)
    if answer.shape != truth.shape:
        return Verdict(False, f"{name} should have shape {truth.shape}, yours has {answer.shape}.")
    if answer.size > 1:
        wrong = int(np.argmax(np.abs(answer - truth).ravel()))
        place = tuple(int(i) for i in np.unravel_index(wrong, truth.shape))
        return Verdict(False, f"{name}: look again at entry {place}, where yours is furthest off.")
    answer, truth = answer.ravel()[0], truth.ravel()[0]
    if abs(answer - truth) < 0.2 * abs(truth):
        wanted = f"{100 * tolerance:.2g} %"
        return Verdict(False, f"{name} is near, off by less than a fifth; {wanted} is asked for.")
    size = "large" if abs(answer) > abs(truth) else "small"
    return Verdict(False, f"{name} is too {size}.")


def close(answer, truth, tolerance):
    """Within `tolerance` of the truth, relative to its largest entry; never of what is not finite."""
    if not np.all(np.isfinite(truth)):
        return False
    scale = np.max(np.abs(truth)) if np.size(truth) else 0.0
    return bool(np.all(np.abs(answer - truth) <= tolerance * max(scale, 1e-12)))


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


def not_own(rig, call):
    """A verdict on the paper's rig, or none, where the student's own is asked for; else None."""
    if rig is None:
        return Verdict(False, f"Pass your own rig along: {call}.")
    if rig in [load(name) for name in ("double", "triple")]:
        return Verdict(
            False, 'That is the paper\'s rig; make your own with pl.my_rig("your name").'
        )
    return None


def all_right(*verdicts):
    """The first verdict that is not right, or the last one; each earns an equal share."""
    told = next((verdict for verdict in verdicts if not verdict), verdicts[-1])
    return replace(told, share=float(np.mean([verdict.share for verdict in verdicts])))


def choose(name, answer, truth, hints):
    """Judge a choice among words; `hints` has one sentence for every wrong word."""
    answer = str(answer).strip().lower()
    if answer == str(truth).lower():
        return Verdict(True, "That is what we find too.")
    known = sorted({str(truth).lower(), *map(str.lower, hints)})
    if answer not in known:
        return Verdict(False, f"{name} should be one of {', '.join(known)}.")
    return Verdict(False, hints[answer])
