"""Checks of notebook 03: observers with H = 0, how many, how good, and when there is none."""

from functools import lru_cache
from itertools import combinations

import control
import numpy as np

import pendlab as pl

from ..._arguments import array, number
from .judging import all_right, asks, verdict

TS = 0.01
POLES, ZERO = (1.1, 1.5), 1.2
SMALL_POLE = 1.2  # of the small plant of section 3.9


def exercise_1(T_dead=None, K_dead=None, rig=None):
    """The deadbeat observer of the three-state example; t3 = 1 fixes the scale."""
    T, K = np.atleast_2d(array("T_dead", T_dead)), np.atleast_2d(array("K_dead", K_dead))
    for name, answer, shape in (("T_dead", T, (1, 3)), ("K_dead", K, (1, 2))):
        if answer.shape != shape:
            yield f"{name} should have shape {shape}, yours has {answer.shape}."
    scale = T[0, 2]
    if scale == 0:
        yield "t3 = 0: then v holds nothing of the speed x3. Take t3 = 1."
    if abs(T[0, 1] + scale) > 1e-6 * abs(scale):
        yield "TB = t2 + t3 is not zero: this observer has to know u."
    yield _deadbeat(T / scale, K / scale)
    if abs(scale - 1) > 1e-6:
        yield "A deadbeat observer, but in another scale: take t3 = 1, and K with it."
    return "The observer forgets all but the last sample."


@asks("T_dead", "K_dead", tolerance=1e-6)
def _deadbeat(rig):
    (T, K), (T_slow, K_slow) = _unit_member(0.0), _unit_member(0.9)
    yield T, None
    yield T_slow, "That is the observer with epsilon = 0.9; deadbeat is epsilon = 0."
    yield "K_dead"
    yield K, None
    yield K_slow, "That is K for epsilon = 0.9; deadbeat is epsilon = 0."
    yield T[:, :2], "With E = 0 equation (5) is TA = KC, not T = K C."


def _unit_member(E):
    """T and K with t3 = 1."""
    A, B = np.array([[1, 0, 1], [0, 0.5, 0], [0, 0, 1]]), np.array([[0.0], [1], [1]])
    family = pl.observer_family(control.ss(A, B, np.eye(2, 3), 0, 1), E)
    T, K = family.split(family.basis[0])
    return T / T[0, 2], K / T[0, 2]


@asks("dimension_aligned", base="triple")
def exercise_2(rig):
    """Dimension of the family for the triple with its motor 2 used up."""
    model, E = pl.sample(pl.linearize(rig), TS), [0.9, 0.9]
    p, q = len(E), model.noutputs
    aligned = pl.align(model, 10.0)
    yield pl.observer_family(aligned, E).dimension, "Does your formula give it, too?"
    yield pl.observer_family(model, E).dimension, "That is with both inputs kept out; one is left."
    yield p * q, "That is with no input kept out; one is left, and TB = 0 for it."
    yield q - 1, "That is for one observer state; here there are two."
    yield q, "Count again: p rows, and in each row as many unknowns as equations leave."


def exercise_3(best_pair, rig=None):
    """The two outputs of the double with which the quietest observer is quietest."""
    noise = _noise_gains()
    try:
        pair = tuple(sorted(int(index) for index in best_pair if index == int(index)))
    except (TypeError, ValueError, OverflowError):
        pair = ()
    if pair not in noise:
        yield "best_pair should be two different indices from 0, 1, 2, such as a tuple (i, j)."
    if pair == max(noise, key=noise.get):
        yield "With this pair the noise gain is the largest of all; compare all three."
    if pair != min(noise, key=noise.get):
        yield "Quieter than the worst pair, but not the quietest; compare all three."
    return "Now say what C B has to do with it."


@lru_cache
def _noise_gains():
    """Noise gain from y to xhat of the quietest member for each pair of the double's outputs."""
    model, result = pl.sample(pl.linearize(pl.load("double")), TS), {}
    for pair in combinations(range(3), 2):
        two = control.ss(model.A, model.B, model.C[list(pair)], 0, TS)
        result[pair] = pl.observer_family(two, [0.9, 0.8]).best().noise_gain()
    return result


@asks("samples_slow", "samples_fast")
def exercise_4(rig):
    """Samples until an error that shrinks by 0.9 or 0.5 per sample is below 1 %."""
    yield from _waiting(0.9, other=0.5)
    yield "samples_fast"
    yield from _waiting(0.5, other=0.9)


def _waiting(pole, other):
    def samples(pole, left=0.01):
        return np.log(left) / np.log(pole)

    exact, constant = samples(pole), samples(pole, np.exp(-1))
    truth, factor = np.ceil(exact), "That is the time constant, a factor e; 1 % is a factor 100."
    yield truth, "Now hold its time constant against that of the fall."
    yield np.ceil(samples(other)), "That is the other observer; samples_slow belongs to 0.9."
    yield exact, "Whole samples are asked for: round, and think which way."
    yield np.floor(exact), "After so many samples the error is still just above 1 %."
    yield truth + 1, "One sample too many; after n samples the error is pole**n."
    for seconds in (truth * TS, exact * TS):
        yield seconds, "That is in seconds; how many samples of 10 ms?"
    yield constant, factor
    yield np.ceil(constant), factor
    yield np.ceil(samples(pole, 0.1)), "That is 10 %; 1 % is 0.01."
    yield np.ceil(samples(pole, 0.5)), "That is one half; 1 % is 0.01."


def exercise_5(impossible_pole=None, k=None, rig=None):
    """Which pole forbids a stable controller, and a gain for the other plant."""
    return all_right(verdict(_impossible(impossible_pole)), verdict(_stabilises(k)))


def _impossible(pole):
    if pole not in POLES:
        yield "impossible_pole should be one of 1.1 and 1.5."
    if pole < ZERO:  # zeros: 1.2 and infinity
        yield """The plant has real zeros outside the circle at 1.2 and at infinity. How many poles
            lie between them in each case? An odd number forbids a stable controller."""
    return "An odd number of poles between two zeros."


def _stabilises(k):
    try:
        gain = number("k", k)
    except (ValueError, TypeError) as problem:
        yield str(problem)

    def unstable(gain):
        other = min(POLES)
        roots = np.roots([1, -(0.2 + other) + gain, 0.2 * other - ZERO * gain])
        return int(np.sum(np.abs(roots) >= 1))

    if unstable(gain) and not unstable(-gain):
        yield "k has the opposite sign; u = -k y gives the polynomial of the task."
    if unstable(gain):
        yield f"""With your k the closed loop has unstable poles: {unstable(gain)} of 2. Scan k over
            both signs and watch the roots of the polynomial."""
    return "A constant gain is as stable as a controller can be."


@asks("c_deadbeat", "c_least")
def exercise_6(rig):
    """Where the sensor y = c x1 + x2 puts the invariant zero 1.2 - c of the small plant."""
    yield SMALL_POLE, None
    yield 0, "E = 0 is where the zero has to be; which c puts it there?"
    yield 0.6, "That is the sensor of the text, with its zero at 0.6."
    yield 0.2, "Put it into z - 1.2 + c: the zero is not at 0."
    yield "c_least"
    yield SMALL_POLE - 1, "The zero belongs to the observer, so it has to be a stable one."
    yield 2.2, "Above that c the zero lies beyond -1; asked is the lower end."
    yield 0, "With c = 0 the zero is at 1.2, outside already."
    yield 1.2, "There the zero is well inside the circle; go on."
