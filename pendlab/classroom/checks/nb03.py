"""Checks of notebook 03: observers with H = 0, how many, how good, and when there is none."""

from functools import lru_cache

import control
import numpy as np

from ..._arguments import array, number
from ...models import linearize
from ...observers import observer_family
from ...parameters import load
from ...sampled import align, sample
from .judging import Verdict, all_right, compare

TS = 0.01
POLES, ZERO = (1.1, 1.5), 1.2
SMALL_POLE = 1.2  # of the small plant of section 3.9


def exercise_1(T_dead=None, K_dead=None, rig=None):
    """The deadbeat observer of the three-state example; t3 = 1 fixes the scale."""
    A = np.array([[1, 0, 1], [0, 0.5, 0], [0, 0, 1]])
    B, C = np.array([[0.0], [1], [1]]), np.eye(2, 3)
    model = control.ss(A, B, C, 0, 1)
    answers = []
    for name, answer, shape in (("T_dead", T_dead, (1, 3)), ("K_dead", K_dead, (1, 2))):
        answer = np.atleast_2d(array(name, answer))
        if answer.shape != shape:
            return Verdict(False, f"{name} should have shape {shape}, yours has {answer.shape}.")
        answers.append(answer)
    T, K = answers
    if T[0, 2] == 0:
        return Verdict(False, "t3 = 0: then v holds nothing of the speed x3. Take t3 = 1.")
    scale, T, K = T[0, 2], T / T[0, 2], K / T[0, 2]
    (T_true, K_true), (T_slow, K_slow) = (_unit_member(model, E) for E in (0.0, 0.9))
    listens = "TB = t2 + t3 is not zero: this observer has to know u."
    if abs((T @ B)[0, 0]) > 1e-6:
        return Verdict(False, listens)
    verdict = all_right(
        compare(
            "T_dead",
            T,
            T_true,
            [(T_slow, "That is the observer with epsilon = 0.9; deadbeat is epsilon = 0.")],
            tolerance=1e-6,
        ),
        compare(
            "K_dead",
            K,
            K_true,
            [
                (K_slow, "That is K for epsilon = 0.9; deadbeat is epsilon = 0."),
                (T[:, :2], "With E = 0 equation (5) is TA = KC, not T = K C."),
            ],
            tolerance=1e-6,
            praise="The speed is the difference of two positions, put right by what was pushed since.",
        ),
    )
    if verdict and abs(scale - 1) > 1e-6:
        return Verdict(
            False, "A deadbeat observer, but in another scale: take t3 = 1, and K with it."
        )
    return verdict


def exercise_2(dimension_aligned, rig=None):
    """Dimension of the family for the triple with its upper motor used up."""
    model = sample(linearize(load("triple") if rig is None else rig), TS)
    aligned = align(model, 10.0)
    E = [0.9, 0.9]
    p, q = len(E), model.noutputs
    return compare(
        "dimension_aligned",
        dimension_aligned,
        observer_family(aligned, E).dimension,
        [
            (
                observer_family(model, E).dimension,
                "That is with both inputs kept out; one is left.",
            ),
            (p * q, "That is with no input kept out; one is left, and TB = 0 for it."),
            (q - 1, "That is for one observer state; here there are two."),
            (q, "Count again: p rows, and in each row as many unknowns as equations leave."),
        ],
        praise="One input less to keep out: one more free number in each row.",
    )


def exercise_3(best_pair, rig=None):
    """The two outputs of the double with which the quietest observer is quietest."""
    noise = _noise_gains()
    try:
        pair = tuple(sorted(int(index) for index in best_pair if index == int(index)))
    except (TypeError, ValueError, OverflowError):
        pair = ()
    if pair not in noise:
        return Verdict(
            False, "best_pair should be two different indices from 0, 1, 2, such as a tuple (i, j)."
        )
    if pair == min(noise, key=noise.get):
        return Verdict(
            True,
            "The tachometer sees the input within one sample, and the relative angle sees the link "
            "that the lower angle and its own rate hardly tell of.",
        )
    if pair == max(noise, key=noise.get):
        return Verdict(
            False,
            "With this pair the noise gain is the largest of all: both angles hardly see the input in "
            "one sample (look at C B), and both rates must be guessed.",
        )
    return Verdict(
        False,
        "Quieter than the worst pair, but its noise gain is not the smallest; compare all three.",
    )


def exercise_4(samples_slow=None, samples_fast=None, rig=None):
    """Samples until an error that shrinks by 0.9 or 0.5 per sample is below 1 %."""
    praise = "Hold the time constants against each other, not the last per cent."
    slow, fast = (_samples(pole) for pole in (0.9, 0.5))
    return all_right(
        _waiting("samples_slow", samples_slow, 0.9, fast),
        _waiting("samples_fast", samples_fast, 0.5, slow, praise),
    )


def exercise_5(impossible_pole=None, k=None, rig=None):
    """Which pole forbids a stable controller, and a gain for the other plant."""
    return all_right(_impossible(impossible_pole), _stabilises(k))


def exercise_6(c_deadbeat=None, c_least=None, rig=None):
    """Where the sensor y = c x1 + x2 puts the invariant zero 1.2 - c of the small plant."""
    return all_right(
        compare(
            "c_deadbeat",
            c_deadbeat,
            SMALL_POLE,
            [
                (0, "E = 0 is where the zero has to be; which c puts it there?"),
                (0.6, "That is the sensor of the text, with its zero at 0.6."),
                (0.2, "There the zero is at 1; E = 0 asks for a zero at 0."),
            ],
        ),
        compare(
            "c_least",
            c_least,
            SMALL_POLE - 1,
            [
                (2.2, "Above that c the zero lies beyond -1; asked is the lower end."),
                (0, "With c = 0 the zero is at 1.2, outside already."),
                (1.2, "There the zero is at 0, well inside the circle."),
            ],
            praise="The zero belongs to the observer, so it has to be a stable one.",
        ),
    )


def _impossible(pole):
    if pole not in POLES:
        return Verdict(False, "impossible_pole should be one of 1.1 and 1.5.")
    if pole < ZERO:  # zeros: 1.2 and infinity
        return Verdict(
            False,
            "The plant has real zeros outside the circle at 1.2 and at infinity. How many poles lie "
            "between them in each case? An odd number forbids a stable controller.",
        )
    return Verdict(True, "An odd number of poles between two zeros.")


def _stabilises(k):
    try:
        gain = number("k", k)
    except (ValueError, TypeError) as problem:
        return Verdict(False, f"This answer cannot be checked: {problem}")
    other = min(POLES)

    def unstable(gain):
        roots = np.roots([1, -(0.2 + other) + gain, 0.2 * other - ZERO * gain])
        return int(np.sum(np.abs(roots) >= 1))

    if not unstable(gain):
        return Verdict(True, "A constant gain is as stable as a controller can be.")
    if not unstable(-gain):
        return Verdict(False, "k has the opposite sign; u = -k y gives the polynomial of the task.")
    return Verdict(
        False,
        f"With your k the closed loop has unstable poles: {unstable(gain)} of 2. "
        "Scan k over both signs and watch the roots of the polynomial.",
    )


def _unit_member(model, E):
    """T and K with t3 = 1."""
    family = observer_family(model, E)
    T, K = family.split(family.basis[0])
    return T / T[0, 2], K / T[0, 2]


@lru_cache
def _noise_gains():
    """Noise gain from y to xhat of the quietest member for each pair of the double's outputs."""
    model = sample(linearize(load("double")), TS)
    result = {}
    for pair in ((0, 1), (0, 2), (1, 2)):
        two = control.ss(model.A, model.B, model.C[list(pair)], 0, TS)
        result[pair] = observer_family(two, [0.9, 0.8]).best().noise_gain()
    return result


def _samples(pole):
    return int(np.ceil(np.log(0.01) / np.log(pole)))


def _waiting(name, answer, pole, other, praise="That is what we find too."):
    truth, exact = _samples(pole), np.log(0.01) / np.log(pole)
    return compare(
        name,
        answer,
        truth,
        [
            (other, "That is the other observer; samples_slow belongs to 0.9."),
            (exact, "Whole samples are asked for: round, and think which way."),
            (np.floor(exact), "After so many samples the error is still just above 1 %."),
            (truth + 1, "One sample too many; after n samples the error is pole**n."),
            (truth * TS, "That is in seconds; how many samples of 10 ms?"),
            (exact * TS, "That is in seconds; how many samples of 10 ms?"),
            (-1 / np.log(pole), "That is the time constant, a factor e; 1 % is a factor 100."),
            (
                np.ceil(-1 / np.log(pole)),
                "That is the time constant, a factor e; 1 % is a factor 100.",
            ),
            (np.ceil(np.log(0.1) / np.log(pole)), "That is 10 %; 1 % is 0.01."),
            (np.ceil(np.log(0.5) / np.log(pole)), "That is one half; 1 % is 0.01."),
        ],
        praise=praise,
    )
