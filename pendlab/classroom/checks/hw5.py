"""Homework 5: four links, with motors of one's own choice."""

from dataclasses import astuple, replace

import numpy as np

import pendlab as pl

from ..._arguments import array, found
from ...models import matrices
from .acceptance import REAL, alike, before, fallen, no_design, small_margins, unstable
from .judging import asks, compare, not_callable

RIG = dict(base="triple", who="your name")
PRICES, LIMITS, BUDGET = (3, 1), (12.0, 2.5), 5
LEAST, MOST = 20, 240  # gear ratios to be had
TILT, MARGIN, LEAN, REST, SETTLED = 0.1, 0.2, 0.03, 0.01, 9.0
FIELDS = ("gain", "inertia", "damping", "ratio")


def geared(motor, ratio):
    """The same motor behind another gearbox: torque by N, inertia and damping by N squared."""
    k = ratio / motor.ratio
    return pl.Motor(motor.damping * k**2, motor.inertia * k**2, motor.gain * k, ratio)


def tower(rig, motors, u_max):
    """Four links from the three of a triple; link 2 is there twice."""
    low, middle, top = rig.links
    links, filters = (low, middle, middle, top), pl.Filters((20.0,) * len(motors), (50.0,) * 5)
    return pl.Pendulum(links, motors, filters, u_max, name="four links")


def links_alone(rig):
    """Mass matrix and gravity matrix of the links, absolute angles, without rotors."""
    free = [replace(motor, inertia=0.0, damping=0.0) for motor in rig.motors]
    _, M, _, P, _ = matrices(replace(rig, motors=free))
    return M, P


def exercise_1(function, rig):
    """A function that puts a motor behind another gearbox."""
    yield not_callable(function, "your function geared(motor, ratio)")
    for motor in rig.motors:
        for k in (0.5, 1.0, 2.0):
            ratio = k * motor.ratio
            mine, theirs = geared(motor, ratio), function(motor, ratio)
            if not isinstance(theirs, pl.Motor):
                yield f"geared must return a pl.Motor, {found(theirs)}."
            for name in FIELDS:
                want, have = getattr(mine, name), getattr(theirs, name)
                if not np.isclose(have, want, rtol=1e-6):
                    factor = have / getattr(motor, name)
                    yield f"""At {k:g} times the ratio your {name} changes by a factor of
                        {factor:.3g}; write down the energy or power that it stands for, on both
                        sides of the gearbox."""
    return "Gain by N, inertia and damping by N squared."


def exercise_2(function, rig):
    """A function that gives mass matrix and gravity matrix of any tower."""
    yield not_callable(function, "your function mass_and_gravity(rig)")
    for case in [pl.load("double"), rig, tower(rig, rig.motors, LIMITS)]:
        answer = function(case)
        if not isinstance(answer, (tuple, list)) or len(answer) != 2:
            yield "The function should return the pair (M, P)."
        for name, want, have in zip("MP", links_alone(case), answer):
            mistakes = _matrix_mistakes(case, name, want)
            verdict = compare(name, array(name, have), want, mistakes, 1e-9)
            yield None if verdict else f"With {case.n_links} links: {verdict.message}"
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


@asks("freedom", "most")
def exercise_3(rig):
    """Free directions in each row of T for 1, 2, 3 motors; most motors with E = e I."""
    rows, n, motors = 3, 4, (1, 2, 3)
    freedom = [row_freedom(rig, m) for m in motors]
    yield freedom, None
    yield [n + 1] * 3, "Those are the unknowns beyond t A; TB = 0 takes one away per motor."
    further = "A row of K brings n + 1 further unknowns, and t A - e t = k C is 2n equations."
    yield [2 * n - m for m in motors], further

    yield "most"
    yield max(m for m, free in zip(motors, freedom) if free >= rows), None
    hint = "Hold each number of free directions against the number of rows that T needs."
    for other in range(10):
        yield other, hint


def row_freedom(rig, m):
    """Dimension of the solutions (t, k) of one row, counted on a sampled tower."""
    large, small = rig.motors
    made = tower(rig, [large, small, small][:m], (*LIMITS, LIMITS[1])[:m])
    model = pl.sample(pl.linearize(made), 0.01)
    return pl.observer_family(model, [0.1, 0.2, 0.3]).dimension // 3


def exercise_4(mine, rig):
    """Motors for four links."""
    if not isinstance(mine, pl.Pendulum):
        yield f"Expected your Pendulum, {found(mine)}."
    price = 0
    for i, (motor, limit) in enumerate(zip(mine.motors, mine.u_max), 1):
        kind = _which(motor, rig.motors)
        if kind is None:
            yield f"""Motor {i} is neither your large nor your small one behind another gearbox;
                make it with geared."""
        if not LEAST <= motor.ratio <= MOST:
            yield f"Motor {i} has ratio {motor.ratio:g}; {LEAST} to {MOST} are to be had."
        if limit != LIMITS[kind]:
            yield f"Motor {i} takes {LIMITS[kind]:g} V, u_max says {limit:g} V."
        price += PRICES[kind]
    if price > BUDGET:
        yield f"These motors cost {price}; the budget is {BUDGET}."
    if not alike(mine, tower(rig, mine.motors, mine.u_max)):
        yield "Links, filters and g must stay those of tower(...)."
    tilt = pl.recoverable_tilt(mine)
    if tilt < TILT:
        yield f"""From a lean of {tilt:.3f} rad even the best controller would be too weak, {TILT:g}
            is asked for: which motor is at its limit first, or is there one too few?"""
    return f"Tilt {tilt:.3f} rad."


def _which(motor, kinds):
    """Index of the motor that is the same but for its gearbox, or None."""
    for kind, base in enumerate(kinds):
        if np.allclose(astuple(motor), astuple(geared(base, motor.ratio)), 1e-6):
            return kind
    return None


def exercise_5(design, rig):
    """A design that lets four links stand, with margin."""
    yield no_design(design)
    yield before("The rig", "task 4", exercise_4(design.rig, rig))
    yield unstable(design.filtered_loop)
    yield small_margins(design, [MARGIN] * design.rig.n_motors)
    run = pl.simulate(design.rig, design.controller, 10, [LEAN, 0, 0, 0], imperfections=REAL)
    yield fallen(run, f"Released at a lean of {LEAN:g} rad")
    left = np.abs(run.angles[run.t > SETTLED]).max()
    if left > REST:
        yield f"""Released at {LEAN:g} rad it stays up, but angles still reach {left:.3f} rad after
            {SETTLED:g} s; {REST:g} is asked for."""
    return "Four links stand, with margin, on three motors or fewer."
