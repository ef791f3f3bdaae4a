"""Homework 5: four links, with motors of one's own choice."""

from dataclasses import replace

import numpy as np

from ..._arguments import array, found
from ...bench.imperfections import Imperfections
from ...bench.simulation import simulate
from ...design import Design
from ...loop import margins
from ...models import equations, linearize
from ...observers import observer_family
from ...parameters import Filters, Motor, Pendulum, load
from ...sampled import sample
from ...studies.controllability import recoverable_tilt
from .acceptance import alike, unstable
from .judging import Verdict, all_right, compare, judged, not_callable, on

PRICES, LIMITS, BUDGET = (3, 1), (12.0, 2.5), 5
LEAST, MOST = 20, 240  # gear ratios to be had
TILT, MARGIN, LEAN, REST, SETTLED = 0.1, 0.2, 0.03, 0.01, 9.0


def geared(motor, ratio):
    """The same motor behind another gearbox: torque by N, inertia and damping by N squared."""
    k = ratio / motor.ratio
    return Motor(motor.damping * k**2, motor.inertia * k**2, motor.gain * k, ratio)


def tower(rig, motors, u_max):
    """Four links from the three of a triple; link 2 is there twice."""
    low, middle, top = rig.links
    m = len(motors)
    links = (low, middle, middle, top)
    return Pendulum(links, motors, Filters((20.0,) * m, (50.0,) * 5), u_max, name="four links")


def links_alone(rig):
    """Mass matrix and gravity matrix of the links, absolute angles, without rotors."""
    free = [replace(motor, inertia=0.0, damping=0.0) for motor in rig.motors]
    motion, values = equations(replace(rig, motors=free))
    _, M, _, P, _ = motion.linear(*values)
    return np.asarray(M, dtype=float), np.asarray(P, dtype=float)


@on("triple", who="your name")
@judged
def exercise_1(function, rig=None):
    yield not_callable(function, "your function geared(motor, ratio)")
    for motor in rig.motors:
        for k in (0.5, 1.0, 2.0):
            ratio = k * motor.ratio
            mine, theirs = geared(motor, ratio), function(motor, ratio)
            if not isinstance(theirs, Motor):
                yield f"geared must return a pl.Motor, found {theirs!r}."[:200]
            for name in ("gain", "inertia", "damping", "ratio"):
                want, have = getattr(mine, name), getattr(theirs, name)
                if not np.isclose(have, want, rtol=1e-6):
                    yield (
                        f"At {k:g} times the ratio your {name} changes by a factor of "
                        f"{have / getattr(motor, name):.3g}; write down the energy or power that "
                        "it stands for, on both sides of the gearbox."
                    )
    return "Gain by N, inertia and damping by N squared."


@on("triple", who="your name")
@judged
def exercise_2(function, rig=None):
    yield not_callable(function, "your function mass_and_gravity(rig)")
    triple = rig
    large, small = triple.motors
    cases = [load("double"), triple, tower(triple, [large, small], LIMITS)]
    for case in cases:
        truth = links_alone(case)
        answer = function(case)
        if not isinstance(answer, (tuple, list)) or len(answer) != 2:
            yield "The function should return the pair (M, P)."
        for name, want, have in zip("MP", truth, answer):
            have = array(name, have)
            judged = compare(name, have, want, _matrix_mistakes(case, name, want), 1e-9)
            if not judged:
                yield f"With {case.n_links} links: {judged.message}"
    return "Both matrices agree for two, three and four links."


def _matrix_mistakes(rig, name, truth):
    if name == "P":
        yield truth / rig.g, "g is missing."
        own = -np.diag([rig.g * link.mass * link.com for link in rig.links])
        yield own, "A link lifts its own centre of mass and everything that stands on it."
    else:
        inertias = np.diag([link.inertia for link in rig.links])
        yield truth - inertias, "Each link also turns about its own centre of mass."
        yield np.diag(np.diag(truth)), "Links move each other: M is not diagonal."


@on("triple", who="your name")
def exercise_3(freedom, most, rig=None):
    """Free directions in each row of T for 1, 2, 3 motors; most motors with E = e I."""
    truth = [row_freedom(rig, m) for m in (1, 2, 3)]
    n = 4
    first = compare(
        "freedom",
        freedom,
        truth,
        mistakes=[
            ([n + 1] * 3, "Those are the unknowns beyond t A; TB = 0 takes one away per motor."),
            ([2 * n - m for m in (1, 2, 3)], "A row of K brings n + 1 further unknowns, and "
             "t A - e t = k C is 2n equations."),
        ],
    )  # fmt: skip
    rows = n - 1
    best = max(m for m, free in zip((1, 2, 3), truth) if free >= rows)
    if most == best:
        second = Verdict(True, "With more motors E needs different eigenvalues.")
    else:
        second = Verdict(
            False, f"T has {rows} rows. With E = e I they all come from one and the same space; of "
            "which dimension must it be at least?"
        )  # fmt: skip
    return all_right(first, second)


def row_freedom(rig, m):
    """Dimension of the solutions (t, k) of one row, counted on a sampled tower."""
    large, small = rig.motors
    made = tower(rig, [large, small, small][:m], (*LIMITS, LIMITS[1])[:m])
    model = sample(linearize(made), 0.01)
    return observer_family(model, [0.1, 0.2, 0.3]).dimension // 3


@on("triple", who="your name")
@judged
def exercise_4(mine, rig=None):
    if not isinstance(mine, Pendulum):
        yield f"Expected your Pendulum, {found(mine)}."
    yield from _motor_shortfalls(mine, rig)
    return f"Tilt {recoverable_tilt(mine):.3f} rad."


def _motor_shortfalls(mine, rig):
    large, small = rig.motors
    price = 0
    for i, (motor, limit) in enumerate(zip(mine.motors, mine.u_max), 1):
        kind = _which(motor, large, small)
        if kind is None:
            yield (
                f"Motor {i} is neither your large nor your small one behind another gearbox; "
                "make it with geared."
            )
        if not LEAST <= motor.ratio <= MOST:
            yield f"Motor {i} has ratio {motor.ratio:g}; {LEAST} to {MOST} are to be had."
        if limit != LIMITS[kind]:
            yield f"Motor {i} takes {LIMITS[kind]:g} V, u_max says {limit:g} V."
        price += PRICES[kind]
    if price > BUDGET:
        yield f"These motors cost {price}; the budget is {BUDGET}."
    if not alike(mine, tower(rig, mine.motors, mine.u_max)):
        yield "Links, filters and g must stay those of tower(...)."
    tilt = recoverable_tilt(mine)
    if tilt < TILT:
        yield (
            f"From a lean of {tilt:.3f} rad even the best controller would be too weak, {TILT:g} is "
            "asked for: which motor is at its limit first, or is there one too few?"
        )


def _which(motor, large, small):
    for kind, base in enumerate((large, small)):
        made = geared(base, motor.ratio)
        if np.allclose(
            [motor.gain, motor.inertia, motor.damping],
            [made.gain, made.inertia, made.damping],
            1e-6,
        ):
            return kind
    return None


@on("triple", who="your name")
@judged
def exercise_5(design, rig=None):
    if not isinstance(design, Design):
        yield f"Expected a pl.Design, found {type(design).__name__}."
    for shortfall in _motor_shortfalls(design.rig, rig):
        yield f"The rig first (task 4): {shortfall}"
    yield unstable(design.filtered_loop)
    for i in range(design.rig.n_motors):
        least = margins(design.loop(i, filters=True))
        if least.modulus < MARGIN:
            yield (
                f"With filters the modulus margin at input {i + 1} is {least.modulus:.3f}, "
                f"{MARGIN:g} is asked for; the curve is nearest to -1 at "
                f"{least.modulus_omega / (2 * np.pi):.1f} Hz. What in Q, R or E makes that "
                "loop so fast?"
            )
    yield stands(design)
    return "Four links stand, with margin, on three motors or fewer."


def stands(design):
    bench = Imperfections(filters=True, saturation=True)
    run = simulate(design.rig, design.controller, 10, [LEAN, 0, 0, 0], imperfections=bench)
    if run.fell:
        return f"Released at a lean of {LEAN:g} rad it falls after {run.fell_at:.2f} s."
    left = np.abs(run.angles[run.t > SETTLED]).max()
    if left > REST:
        return (
            f"Released at {LEAN:g} rad it stays up, but angles still reach {left:.3f} rad after "
            f"{SETTLED:g} s; {REST:g} is asked for."
        )
    return None
