"""Checks of exercises: right, or a hint about this mistake; never the answer.

One module per notebook (``nb02`` for notebook 02, ``nbA``, ``hw1`` for homework 1) with a function
per exercise: ``exercise_k(rig)``, a table of answers (`judging.asks`), or ``exercise_k(answer, ...,
rig)``, which yields what is wrong and returns its praise (`judging.verdict`) or returns a `Verdict`.
A module's `RIG` says which rig all its exercises are about (`judging.on`).
"""

import os
import sys
from contextlib import redirect_stderr
from importlib import import_module
from pkgutil import iter_modules

from numpy import ndarray

from ..gaps import unanswered
from .judging import Verdict, on

OPEN = "something still holds `...`; give it a value."
__all__ = ["Verdict", "check"]


def check(exercise, *answer, rig=None, points=None):
    """Check the answer to an exercise.

    Parameters
    ----------
    exercise : its number as in the notebook, such as ``"02.1"``, ``"A.3"`` or ``"hw4.2"``; or, in a
        notebook of one's own, a function ``exercise_1(answer, rig=None)`` that returns a `Verdict`,
        or yields what is wrong and returns praise
    answer : what the exercise asks for, in SI units and radians
    rig : the Pendulum it was worked out for; the exercise's own where None
    points : what the exercise is worth; counts where nbgrader marks, and nowhere else

    Returns
    -------
    Verdict : shows "right" or a hint; true where right. An answer of the wrong kind or shape gives
        a hint too, never an error. Where nbgrader marks, the verdict is printed and the points
        earned are returned, since nbgrader takes a cell's last number; without `points` a wrong
        answer raises AssertionError with the hint.
    """
    function = _function(exercise)
    if "NBGRADER_EXECUTION" not in os.environ:
        return _judge(function, answer, rig)
    with redirect_stderr(sys.stdout):  # nbgrader counts a warning as an error
        verdict = _judge(function, answer, rig)
    if points is not None:
        print(verdict)
        return round(float(points * verdict.share), 2)
    if not verdict:
        raise AssertionError(verdict.message)
    return verdict


def _judge(function, answer, rig):
    answer = [
        part.item() if isinstance(part, ndarray) and not part.ndim else part for part in answer
    ]
    if unanswered(rig) or (answer and all(map(unanswered, answer))):
        return Verdict(None, OPEN)
    try:
        verdict = function(*answer, rig=rig)
    except Exception as problem:  # whatever an answer does when it is used
        verdict = Verdict(False, f"This answer cannot be checked: {problem}")
    if not verdict.share and any(map(unanswered, answer)):
        return Verdict(None, OPEN)
    return verdict


def exercises():
    """All exercise numbers that have a check, in order."""
    found = []
    for part in (name for _, name, _ in iter_modules(__path__) if name.startswith(("nb", "hw"))):
        names = vars(import_module(f".{part}", __name__))
        numbers = sorted(int(name[9:]) for name in names if name.startswith("exercise_"))
        found += [f"{part.removeprefix('nb')}.{number}" for number in numbers]
    return found


def _function(exercise):
    if callable(exercise):
        return on()(exercise)
    part, _, number = str(exercise).partition(".")
    try:
        module = import_module(f".{part if part.startswith('hw') else f'nb{part}'}", __name__)
        function = getattr(module, f"exercise_{number}")
    except (ImportError, AttributeError):
        raise ValueError(
            f"exercise: no check for {exercise!r}; there are {', '.join(exercises())}."
        ) from None
    return on(**getattr(module, "RIG", {}))(function)
