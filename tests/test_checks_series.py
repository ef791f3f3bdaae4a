"""Checks of the notebooks' exercises: hints that know the mistake and hide the answer."""

import re
from dataclasses import replace
from functools import lru_cache

import control
import numpy as np
import pytest
import sympy as sp

import pendlab as pl

TS = 0.01

# Answers, worked out here once more, and mistakes made on purpose.


def letter(name):
    return sp.Symbol(name, positive=True)


def unordered(names):
    return sp.symbols(names, commutative=False)


@lru_cache
def double_motion():
    return pl.derive(2, 1)


def tip(at="l2", rigid=True, factor=1):
    """M and P of the double with a point mass on the tip, or with a mistake in it."""
    motion, m, arm = double_motion(), sp.Symbol("m_t"), letter(at)
    l1, g = letter("l1") if rigid else 0, letter("g")
    M = motion.M + factor * m * sp.Matrix([[l1**2, l1 * arm], [l1 * arm, arm**2]])
    return M, motion.P - m * g * sp.diag(l1, arm)


def belt():
    M, G, rotor = pl.derive(2, 0).M, letter("G1"), letter("I_p1")
    return M + sp.diag(0, rotor), sp.Matrix([0, -G])


def double_rates():
    return np.sort(pl.linearize(pl.load("double")).poles().real)[::-1]


def growth(name):
    return pl.linearize(pl.load(name)).poles().real.max()


def model(name="double"):
    return pl.paper_design(name).model


def triple_floor():
    return np.exp(sum(np.log(abs(p)) for p in np.linalg.eigvals(model("triple").A) if abs(p) > 1))


def remainder():
    F, L2, Psi, T, B = unordered("F L2 Psi T B")
    return -F * L2 * Psi * T * B


def rules(sign=-1, swap=False):
    X, Y, R = unordered("X Y R")
    return {Y * X * R: 1 + sign * R, R * (X * Y if swap else Y * X): 1 + sign * R}


def members():
    family, rng = pl.observer_family(model(), 0.9), np.random.default_rng(2)
    return [family.member(rng.standard_normal(2)) for _ in range(5)]


def at_five_members(measure):
    F = pl.lqr(model(), [0.1, 100, 0, 0.01], 3)
    return [measure(pl.controller(F, o, TS, tracked=())) for o in members()]


def at_outputs(values=min):
    omega = pl.frequency_grid(TS)
    G = pl.frequency_response(model(), omega)

    def measure(c):
        loop = np.eye(3) - G @ pl.frequency_response(c.system, omega)
        return np.linalg.svd(loop, compute_uv=False)[:, -1 if values is min else 0].min()

    return at_five_members(measure)


def at_input(filters):
    plant = pl.paper_design("double").filtered if filters else model()
    return at_five_members(lambda c: pl.margins(pl.open_loop(c, plant)).modulus)


def siso_pole():
    plant = control.ss([[1.7, -0.6], [1, 0]], [[1], [0]], [[1, -1.1]], 0, TS)
    F, o = pl.lqr(plant, [1, 1], 1), pl.luenberger(plant, 0.6, [[1]])
    return (o.E - o.H @ F @ o.L2).item()


def ripple():
    gains = [
        abs(pl.frequency_response(pl.paper_design("double", n).controller.system, np.pi / TS))
        for n in (1, 2)
    ]
    return gains[1][0, 0, 0] / gains[0][0, 0, 0]


def upper_margin(filters=True):
    return pl.margins(pl.paper_design("triple").loop(1, filters)).gain_up


def kp_low():
    A, B = model("triple").A, model("triple").B
    return -1 / np.linalg.solve(np.eye(6) - A, B[:, 1])[2]


def twice(rig="double"):
    slow = pl.sample(pl.linearize(pl.load(rig)), 2 * TS)
    return slow.A, slow.B


def delay_budget(total, own=True):
    return 1 / (2 * np.pi * (total - own / (2 * np.pi * pl.load("double").filters.output_hz[0])))


def rotor():
    motor, upper = pl.load("double").motors[0], pl.load("double").links[1]
    hinge = upper.inertia + upper.mass * upper.com**2
    return motor.inertia / motor.ratio**2, motor.inertia / hinge


P = double_motion().P
RIGHT = {
    "02.1": rotor,
    "02.2": lambda: (np.log(30) / growth("double"), np.log(30) / growth("triple")),
    "02.4": lambda: (delay_budget(0.02),),
    "02.5": twice,
    "03.1": lambda: ([[-1, -1, 1]], [[-1, -0.5]]),
    "03.2": lambda: (2 * (4 - 1),),
    "03.3": lambda: ((1, 2),),
    "03.4": lambda: (44, 7),
    "03.5": lambda: (1.5, -0.5),
    "03.6": lambda: (1.2, 0.2),
    "04.1": lambda: (-0.01,),
    "04.2": lambda: ([(0, 2), (2, 0), (1, 1)],),
    "04.3": lambda: (ripple(),),
    "04.4": lambda: (kp_low(),),
    "04.5": lambda: ((1, 0, 2),),
    "04.6": lambda: (10 * upper_margin(),),
    "04.7": lambda: (10,),
    "04.8": lambda: ((triple_floor(), triple_floor() ** (50 / 10.26)),),
    "A.1": tip,
    "A.2": belt,
    "A.3": lambda: (-P, 0),
    "A.4": lambda: (4,),
    "B.1": lambda: (remainder(),),
    "B.2": lambda: (rules(), 0),
    "B.3": lambda: (at_outputs(),),
    "B.4": lambda: (siso_pole(),),
    "B.5": lambda: (at_input(filters=True),),
}
EQUIVALENT = {  # another basis, another form, other names: right all the same
    "03.3": lambda: ([2, 1],),
    "A.1": lambda: tuple(X.subs(sp.Symbol("m_t"), sp.Symbol("mu", real=True)) for X in tip()),
    "A.3": lambda: (P * sp.cos(sp.pi), np.int64(0)),
    "B.1": lambda: ((remainder() * 3 - remainder()) / 2,),
    "B.2": lambda: (dict(reversed(rules().items())), sp.Integer(0)),
}
MISTAKES = {
    "02.1": [
        (lambda: (rotor()[0] * 236, rotor()[1]), "square"),
        (lambda: (rotor()[0], 1 / rotor()[1]), "upside down"),
    ],
    "02.2": [
        (lambda: RIGHT["02.2"]()[::-1], "other pendulum"),
        (lambda: (np.log(30) / double_rates()[1], 1), "slower"),
        (lambda: (np.log10(30) / growth("double"), 1), "natural logarithm"),
    ],
    "02.4": [
        (lambda: (delay_budget(0.02, own=False),), "output filter delays too"),
        (lambda: (2 * np.pi * delay_budget(0.02),), "rad/s"),
    ],
    "02.5": [
        (lambda: (2 * model().A, model().B), "multiply"),
        (lambda: (twice()[0].T, twice()[1]), "transposed"),
        (lambda: (pl.paper_design("double").plant.A, 0), "continuous"),
        (lambda: (twice()[0], model().A @ model().B), "first sample's share"),
    ],
    "03.1": [
        (lambda: ([[-0.1, -1, 1]], [[-0.01, 0.4]]), "0.9"),
        (lambda: ([[-1, 0, 1]], [[-1, 0]]), "has to know u"),
        (lambda: ([2, 2, -2], [2, 1]), "another scale"),
    ],
    "03.2": [(lambda: (4,), "both inputs"), (lambda: (8,), "no input kept out")],
    "03.3": [(lambda: ((0, 1),), "the largest of all"), (lambda: ((0, 2),), "all three")],
    "03.4": [
        (lambda: (43, 7), "just above"),
        (lambda: (43.70869, 7), "round"),
        (lambda: (7, 44), "other"),
    ],
    "03.5": [(lambda: (1.1, -0.5), "odd number"), (lambda: (1.5, 0.5), "opposite sign")],
    "03.6": [(lambda: (0.6, 0.2), "of the text"), (lambda: (1.2, 2.2), "lower end")],
    "04.7": [(lambda: (0.1,), "more"), (lambda: (1e4,), "less")],
    "04.8": [(lambda: ((triple_floor() ** (50 / 10.26), triple_floor()),), "other way round")],
    "04.1": [(lambda: (0,), "sensor shows"), (lambda: (0.01,), "sign")],
    "04.2": [
        (lambda: ([(2, 0), (0, 2), (1, 1)],), "other way round"),
        (lambda: ([(1, 2), (3, 0), (2, 1)],), "inside"),
    ],
    "04.3": [
        (lambda: (20 * np.log10(ripple()),), "decibels"),
        (lambda: (1 / ripple(),), "turn it round"),
    ],
    "04.4": [(lambda: (-kp_low(),), "sign"), (lambda: (0.7,), "printed")],
    "04.5": [(lambda: ((2, 4, 4),), "subtract"), (lambda: ((1, 2, 2),), "identity")],
    "04.6": [
        (lambda: (upper_margin(),), "factor"),
        (lambda: (10 * upper_margin(filters=False),), "without filters"),
    ],
    "A.1": [
        (lambda: (tip(at="a2")[0], tip()[1]), "centre of mass"),
        (lambda: (tip(rigid=False)[0], tip()[1]), "carries the tip along"),
        (lambda: (tip(factor=2)[0], tip()[1]), "one half"),
        (lambda: (tip()[0], 2 * P - tip()[1]), "highest"),
        (lambda: tip()[::-1], "order"),
    ],
    "A.2": [
        (lambda: (belt()[0], -belt()[1]), "left side"),
        (lambda: (belt()[0], belt()[1].T), "transposed"),
        (lambda: (double_motion().M, belt()[1]), "relative rate"),
        (lambda: (belt()[0], double_motion().H), "reaction"),
    ],
    "A.3": [
        (lambda: (P, 0), "upright"),
        (lambda: (sp.diag(-P[0, 0], P[1, 1]), 0), "absolute"),
        (lambda: (-P, 2), "not P"),
    ],
    "A.4": [(lambda: (3,), "positive real part")],
    "B.1": [
        (lambda: (-remainder(),), "opposite sign"),
        (lambda: (sp.Integer(0),), "T B"),
        (lambda: (remainder().subs(unordered("T"), unordered("H")),), "H is zero"),
    ],
    "B.2": [
        (lambda: (rules(sign=1), 0), "sign"),
        (lambda: (rules(swap=True), 0), "order"),
        (lambda: (rules(), 1), "reduces to zero"),
        (lambda: (dict(list(rules().items())[:1]), 0), "two rules"),
    ],
    "B.3": [
        (lambda: (at_input(filters=False),), "at the input"),
        (lambda: (at_outputs(max),), "smallest"),
        (lambda: (sorted(at_outputs()),), "sorted"),
    ],
    "B.4": [(lambda: (0.6,), "That is E"), (lambda: (np.log(siso_pole()) / TS,), "continuous")],
    "B.5": [(lambda: (at_input(filters=False),), "Without filters")],
}


@pytest.mark.parametrize("exercise", RIGHT)
def test_right_answers_are_right(exercise):
    rig = pl.load("double") if exercise == "02.1" else None
    verdict = pl.check(exercise, *RIGHT[exercise](), rig=rig)
    assert verdict, verdict.message


@pytest.mark.parametrize("exercise", EQUIVALENT)
def test_equivalent_answers_are_right(exercise):
    verdict = pl.check(exercise, *EQUIVALENT[exercise]())
    assert verdict, verdict.message


@pytest.mark.parametrize(
    ("exercise", "answer", "hint"),
    [(exercise, *mistake) for exercise, mistakes in MISTAKES.items() for mistake in mistakes],
)
def test_hint_is_about_the_mistake_and_hides_the_answer(exercise, answer, hint):
    verdict = pl.check(exercise, *answer())
    assert not verdict
    assert hint in verdict.message
    assert not (numbers_in(verdict.message) & shown(RIGHT[exercise]()))


def numbers_in(message):
    return set(re.findall(r"-?\d+\.\d\d+", message))


def shown(answer):
    """The numbers of an answer as a hint would print them."""
    texts = set()
    for part in answer:
        if isinstance(part, (list, tuple, float, np.ndarray)):
            for value in np.ravel(np.array(part, dtype=float)):
                texts |= {f"{value:.{digits}f}" for digits in range(2, 7)} | {f"{value:.4g}"}
    return texts


def own_triple_limit():
    own = pl.my_rig("Ada", "triple")
    sampled = pl.sample(pl.linearize(own))
    return own, -1 / np.linalg.solve(np.eye(6) - sampled.A, sampled.B[:, 1])[2]


def test_own_rig_has_its_own_answer():
    own, answer = own_triple_limit()
    assert pl.check("04.4", answer, rig=own)
    assert not pl.check("04.4", kp_low(), rig=own)


def test_slow_fold_of_half_the_gear_ratio():
    def slow(power, rig):
        motor = rig.motors[0]
        half = replace(
            motor,
            gain=motor.gain / 2,
            inertia=motor.inertia / 2**power,
            damping=motor.damping / 2**power,
        )
        poles = pl.linearize(replace(rig, motors=(half,))).poles().real
        return min(poles[poles > 0])

    for rig in (pl.load("double"), pl.my_rig("Ada")):
        assert pl.check("A.5", slow(2, rig), rig=rig)
        assert "power" in pl.check("A.5", slow(1, rig), rig=rig).message
        assert (
            "as it is"
            in pl.check(
                "A.5", min(p for p in pl.linearize(rig).poles().real if p > 0), rig=rig
            ).message
        )


def test_five_per_cent_of_bending_and_volts_of_one_motor():
    f, A = pl.nonlinear(pl.load("double")), pl.paper_design("double").plant.A

    def off(x):
        return np.linalg.norm(A @ x - f(x, 0)) / np.linalg.norm(f(x, 0))

    angles = np.arange(0.2, 0.8, 1e-3)
    bend, lean = (
        angles[np.argmax([off(np.append(a * np.array(shape), [0, 0])) > 0.05 for a in angles])]
        for shape in ([0, 1], [1, 0])
    )
    assert pl.check("02.3", bend)
    assert "bent" in pl.check("02.3", lean).message
    assert "degrees" in pl.check("02.3", np.degrees(bend)).message

    # A mode w is caught from a lean below |w B| u_max / (s |w1|); the one with the least decides.
    plant, limits = pl.linearize(pl.load("triple")), np.array(pl.load("triple").u_max)
    s, V = np.linalg.eig(plant.A)
    left = np.linalg.inv(V).real[s.real > 0] / s.real[s.real > 0, None]
    shares = np.abs(left @ plant.B) / np.abs(left[:, :1]) / s.real[s.real > 0, None]
    both, alone = (shares @ limits).min(), shares[:, 0].min()
    assert pl.check("02.6", both / alone)
    assert "factor" in pl.check("02.6", both / alone / limits[0]).message
    assert "add up" in pl.check("02.6", limits.sum()).message
