"""Checks of notebook B: what is left without an assumption, other loops, other plants."""

import control
import numpy as np

import pendlab as pl

from .judging import Verdict, asks, close
from .symbolic import evaluate, is_product_sum

TS = 0.01
UNFIT = (KeyError, ValueError, TypeError, AttributeError)


def exercise_1(remainder, rig=None):
    """(I + PG) - (I + F Phi B) for H = 0 when (5) and (7) hold and (6) does not.

    Two motors and two observer states, numbers for every matrix: whatever has the value of the
    truth at some frequencies is the truth, in whatever form.
    """
    if not is_product_sum(remainder) and remainder != 0:
        yield "remainder should be an expression of section 3's symbols, as `reduce` returns it."
    letters = set() if remainder == 0 else {symbol.name for symbol in remainder.free_symbols}
    if not letters:
        yield """A plain number: then the lemma would hold without (6). Nothing is known about T B
            here; leave every rule about it out."""
    if "H" in letters:
        yield "H is zero in this exercise: it may not stand in the remainder."
    points = [_matrices(z) for z in np.exp(1j * np.array([0.02, 0.3, 2.0]))]
    try:
        ours = [evaluate(remainder, matrices, 2) for matrices in points]
    except UNFIT:
        yield "remainder has products that do not fit, or symbols of your own."

    def equals(formula):
        return all(close(own, formula(**matrices), 1e-8) for own, matrices in zip(ours, points))

    if equals(_without_6):
        if letters & {"K", "L1"}:
            yield "True, but not yet simple: K and L1 can go, by (5) and (7). Add the rules."
        return "What is left is the observer's error about the motor, seen by F."
    if equals(lambda **given: -_without_6(**given)):
        yield "The opposite sign: the left side minus the right side is asked."
    if equals(lambda F, Phi, B, **_: F @ Phi @ B):
        yield "That is the wanted loop itself; take the difference of both sides."
    if equals(lambda F, Phi, B, **given: F @ Phi @ B + _without_6(F, Phi=Phi, B=B, **given)):
        yield "That is P G with H = 0; subtract the loop gain of state feedback."
    yield """With numbers in place of the symbols it is not the difference that is asked for. Let
        `reduce` do it: with `inverses`, `eq5` and `eq7`, and nothing for (6)."""


def exercise_2(R_rules=None, gap=None, rig=None):
    """The two rules that define R = (I + YX)^-1 for `reduce`, and what it leaves."""
    if not isinstance(R_rules, dict) or not all(map(is_product_sum, R_rules)):
        yield "R_rules should be a dictionary: product of symbols -> what it equals."
    if len(R_rules) != 2:
        yield "An inverse cancels from the left and from the right: two rules, one for each."
    orders = [[factor.as_base_exp()[0].name for factor in left.args_cnc()[1]] for left in R_rules]
    others = sorted({name for order in orders for name in order} - {"R"})
    if len(others) != 2 or any(order.count("R") != 1 for order in orders):
        yield """Multiply out what defines R, from the left and from the right: `reduce` is to
            replace what still holds R and both other symbols."""
    rules = [(left, right + 0 * left) for left, right in R_rules.items()]  # 1 becomes SymPy's
    orders_tried = [_held(rules, *pair) for pair in (others, others[::-1])]
    held = max(orders_tried, key=sum)
    if not all(held):
        if all(map(any, zip(*orders_tried))):
            yield "The order: R is the inverse of the same sum in both rules."
        negated = [(left, 2 - right) for left, right in rules]  # 1 + R made 1 - R and the reverse
        if any(all(_held(negated, *pair)) for pair in (others, others[::-1])):
            yield "The sign: solve the multiplied-out equation once more."
        number = ("first", "second")[held.index(False)]
        yield f"With numbers in place of the symbols your {number} rule is wrong."
    if not (any(o[-1] == "R" for o in orders) and any(o[0] == "R" for o in orders)):
        yield "True, but one-sided: R cancels from the left and from the right."
    missing = "The rules are right. gap, what `reduce` leaves of (I + XY)(I - XRY) - I, is missing."
    if gap is None or gap is ...:
        yield Verdict(False, missing, share=2 / 3)
    not_zero = """The rules define an inverse. With them (I + XY)(I - XRY) - I reduces to zero,
        where R inverts I + YX; does your X stand where X belongs?"""
    if gap != 0:
        yield Verdict(False, not_zero, share=2 / 3)
    return "One inverse is enough: the larger one follows from the smaller one."


@asks("sigma_output")
def exercise_3(rig):
    """Smallest singular value over frequency of I + GP at the outputs, for the five members."""
    controllers, model, omega = _double()
    P = [pl.frequency_response(one.system, omega) for one in controllers]
    G = pl.frequency_response(model, omega)
    loops = np.array([np.eye(3) - G @ p for p in P])
    values = np.linalg.svd(loops, compute_uv=False)
    truth = values[:, :, -1].min(axis=1)
    yield truth, None
    at_input = "Those are the distances at the input: all equal. At the outputs it is I + GP."
    yield [np.abs(1 - p @ G).min() for p in P], at_input
    yield values[:, :, 0].min(axis=1), "Those are the largest singular values; take the smallest."
    yield values[:, :, 1].min(axis=1), "Those are the middle singular values; take the smallest."
    yield values[:, :, -1].max(axis=1), "The worst frequency counts: the least over all of them."
    normal = "Those are eigenvalues. For matrices that are not normal, singular values are smaller."
    yield np.abs(np.linalg.eigvals(loops)).min(axis=(1, 2)), normal
    yield from _of_five(truth)


def _of_five(truth):
    yield np.sort(truth), "The right numbers, but sorted; keep the order of the members."
    yield truth.min(), "One number for each of the five members is asked for."


@asks("controller_pole")
def exercise_4(rig):
    """Eigenvalue of E - H F L2 for a plant that only an unstable controller stabilises."""
    A, B, C = np.array([[1.7, -0.6], [1, 0]]), np.array([[1.0], [0]]), np.array([[1, -1.1]])
    truth, F, o = _siso(A, B, C)
    yield truth, None
    yield o.E[0, 0], "That is E, a pole of the closed loop. The controller feeds its own u back."
    wrong_sign = "The sign: with u = -F xhat the observer's matrix is E - H F L2."
    yield (o.E + o.H @ F @ o.L2)[0, 0], wrong_sign
    for pole in np.linalg.eigvals(A - B @ F).real:
        yield pole, "That is a closed-loop pole; the controller's own are those of E - H F L2."
    for pole in (1.2, 0.5):
        yield pole, "That is a pole of the plant."
    yield 1.1, "That is the zero of the plant."
    other_form = """That belongs to another choice of states for the same G. Weights of one mean
        something else there; use the matrices of the task."""
    yield _siso(A.T, C.T, B.T)[0], other_form
    yield np.log(truth) / TS, "That is a continuous pole in 1/s; give the one in the z-plane."


@asks("with_filters", base="double")
def exercise_5(rig):
    """Smallest |1 + PG_f| over frequency with the filters of Table 5, for the five members."""
    controllers, model, omega = _double()
    filtered = pl.sample(pl.with_filters(pl.linearize(rig), rig.filters), TS)

    def distances(plant=filtered, floor=1.0):
        gains = (pl.loop_gain(one, plant, omega)[:, 0, 0] for one in controllers)
        return np.array([np.abs(floor + gain).min() for gain in gains])

    yield distances(), None
    yield distances(model), "Without filters all are equal, as the lemma says; put them in."
    yield distances(floor=0.0), "That is the least |PG|; the distance from -1 is |1 + PG|."
    yield distances(floor=-1.0), "That is the distance from +1; u = -P y, so it is 1 + PG."
    yield from _of_five(distances())


def _without_6(F, L2, Psi, K, L1, C, Phi, B, **_):
    return F @ (L2 @ Psi @ K + L1) @ C @ Phi @ B - F @ Phi @ B


def _matrices(z):
    """Every letter of the proof as numbers, from the triple with an observer that has H = TB."""
    model = pl.sample(pl.linearize(pl.load("triple")), TS)
    F = pl.lqr(model, [1, 100, 100, 1, 1, 1], [1, 1])
    o = pl.luenberger(model, [0.9, 0.8], np.array([[1, 0, 0, 0], [0, 0, 1, 1.0]]))
    A, B, C, E = model.A, model.B, model.C, o.E
    Phi, Psi = (np.linalg.inv(z * np.eye(len(X)) - X) for X in (A, E))
    return dict(A=A, B=B, C=C, E=E, F=F, K=o.K, T=o.T, L1=o.L1, L2=o.L2, Phi=Phi, Psi=Psi, z=z)


def _held(rules, first, second):
    """Whether each rule holds for X = first (2 x 3), Y = second (3 x 2), R = (I + YX)^-1."""
    X = np.array([[0.3, -1.1, 0.4], [0.8, 0.5, -0.2]])
    Y = np.array([[0.7, 0.1], [-0.6, 0.9], [0.2, 1.3]])
    values = {first: X, second: Y, "R": np.linalg.inv(np.eye(3) + Y @ X)}
    held = []
    for left, right in rules:
        try:
            # a wrong order shows as sizes that do not fit, or as another value
            held.append(close(evaluate(left, values, 3), evaluate(right, values, 3), 1e-8))
        except UNFIT:
            held.append(False)
    return held


def _double():
    """Controllers with the five members of section 8, their model, and the frequencies."""
    model = pl.sample(pl.linearize(pl.load("double")), TS)
    family, F = pl.observer_family(model, 0.9), pl.lqr(model, [0.1, 100, 0, 0.01], 3)
    draws = np.random.default_rng(2).standard_normal((5, family.dimension))
    made = [pl.controller(F, family.member(draw), TS, tracked=()) for draw in draws]
    return made, model, pl.frequency_grid(TS)


def _siso(A, B, C):
    model = control.ss(A, B, C, 0, TS)
    F, o = pl.lqr(model, [1, 1], 1), pl.luenberger(model, 0.6, [[1]])
    return np.linalg.eigvals(o.E - o.H @ F @ o.L2)[0].real, F, o
