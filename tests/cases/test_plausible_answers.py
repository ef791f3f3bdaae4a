"""What students answer: right in every form, as printed, or wrong with a hint that is about it."""

import re
from functools import cache

import numpy as np
import pytest
from plausible_answers import OTHER_FORM, PRINTED, RIGHT, RIGS, WRONG

import pendlab as pl
from pendlab.classroom.checks import exercises

WHOLE = {"00.1", "03.2", "03.3", "03.4", "04.2", "04.5", "A.4", "hw2.1", "hw5.3", "hw7.2", "hw8.2"}
COVARIANCES = {"hw3.3", "hw3.4"}  # computed, never copied from the screen
SEARCHES = {"hw1.5", "hw1.3", "hw2.2"}  # accepted within a band; one end of it is the right answer


def numbers(part):
    """Whether it is made of real numbers only."""
    try:
        return not isinstance(part, str) and np.isrealobj(np.array(part, dtype=float))
    except (TypeError, ValueError):
        return False


def retyped(part):
    """The same answer of another type: arrays for lists and tuples, NumPy's numbers for Python's."""
    return np.array(part) if numbers(part) else part


def three_digits(part):
    """As somebody copies it from the screen."""
    if not numbers(part) or isinstance(part, (bool, int)):
        return part
    return np.vectorize(lambda value: float(f"{value:.3g}"))(np.array(part, dtype=float)).tolist()


@cache
def right(exercise):
    return RIGHT[exercise]()


def check(exercise, answer, rig="own"):
    return pl.check(exercise, *answer, rig=RIGS.get(exercise) if rig == "own" else rig)


def test_every_exercise_has_its_row():
    known = set(exercises())
    assert set(RIGHT) == set(WRONG) == known
    assert set(OTHER_FORM) | set(PRINTED) <= known
    assert {name for name, wrong in WRONG.items() if len(wrong) < 2} == set()


@pytest.mark.parametrize("exercise", RIGHT)
def test_right_in_every_form(exercise):
    answer = right(exercise)
    forms = [answer]
    if exercise in OTHER_FORM:
        forms.append(OTHER_FORM[exercise]())
    elif any(map(numbers, answer)):
        forms.append(map(retyped, answer))
    for form in forms:
        verdict = check(exercise, form)
        assert verdict, verdict.message


@pytest.mark.parametrize("exercise", sorted(set(RIGHT) - WHOLE - SEARCHES - COVARIANCES))
def test_right_as_printed(exercise):
    answer = right(exercise)
    if not any(map(numbers, answer)):
        assert exercise not in PRINTED
        return
    rounded = PRINTED[exercise]() if exercise in PRINTED else map(three_digits, answer)
    verdict = check(exercise, rounded)
    assert verdict, verdict.message


@pytest.mark.parametrize(
    ("exercise", "wrong"),
    [(exercise, wrong) for exercise, entries in WRONG.items() for wrong in entries],
    ids=[f"{exercise}-{wrong[1]}" for exercise, entries in WRONG.items() for wrong in entries],
)
def test_wrong_with_a_hint_about_it_that_hides_the_answer(exercise, wrong):
    make, hint, *rig = wrong
    answer = make()
    answer = answer if isinstance(answer, tuple) else (answer,)
    verdict = check(exercise, answer, *rig)
    assert not verdict
    assert hint in verdict.message
    assert "cannot be checked" not in verdict.message
    if not exercise.startswith("hw"):  # there hints tell what was measured
        assert not set(re.findall(r"-?\d+\.\d\d+", verdict.message)) & shown(right(exercise))


def shown(answer):
    """The numbers of an answer as a hint would print them."""
    texts = set()
    for part in filter(numbers, answer):
        for value in np.ravel(np.array(part, dtype=float)):
            texts |= {f"{value:.{digits}f}" for digits in range(2, 7)} | {f"{value:.4g}"}
    return texts
