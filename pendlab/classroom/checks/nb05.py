"""Checks of notebook 05."""

from dataclasses import replace
from functools import lru_cache

import numpy as np

import pendlab as pl

from ..._arguments import array, found
from ...paper import words
from .acceptance import REAL, no_design, unstable
from .judging import asks, choose

SLOWEST, DISTANCE = 2.0, 0.6  # s; from -1
PUSH, TOLERANCE = 0.05, 0.03  # s; of the force
GROWN = 1.3  # last third of the first seven seconds over the first, of a load that lets go


def exercise_1(answer, rig=None):
    """Rest position under an offset of 3 mrad in theta1."""
    answer, offset = array("The answer", answer, (2,)), 0.003
    loop = pl.closed_loop(pl.paper_design("double"))[["theta1", "theta2-theta1"], "noise theta1"]
    # The truth is zero, so what counts as near is absolute: a hundredth of the offset.
    right = np.abs(answer - offset * loop.dcgain().ravel()) < offset / 100
    if not right.all():
        if np.allclose(answer, [offset, 0], atol=1e-6):
            yield "Those are the sensor errors; the rig does not simply follow them."
        if right[1]:
            yield "The integrator does its part; where must the centre of mass then be?"
        yield "What does the integrator insist on once everything is at rest?"
    return "The integrator wins: an offset below does not bend the rig."


def exercise_2(answer, rig=None):
    """A design of the double with a fast integrator and a margin."""
    yield no_design(answer)
    if answer.rig.n_links != 2:
        yield "The double pendulum is asked for."
    yield unstable(answer.filtered_loop)
    slowest = pl.time_constant(answer.filtered_loop)
    distance = pl.margins(answer.loop(0, filters=True)).modulus
    if slowest >= SLOWEST:
        yield f"The slowest time constant is still {slowest:.1f} s; which weight acts on w?"
    if distance <= DISTANCE:
        yield f"Fast enough, but only {distance:.2f} from -1 with filters: a little less haste."
    return f"Slowest time constant {slowest:.2f} s at a distance of {distance:.2f} from -1."


def exercise_3(answer, rig=None):
    """Does forgetting step 4 change the motion when H = 0, without and with the motors' filters?"""
    if not isinstance(answer, (tuple, list)) or len(answer) != 2:
        yield f'A pair such as ("yes", "yes") is asked for, {found(answer)}.'
    without = """Without filters the amplifier cuts what the program would have cut. Follow u
        through (29): with H = 0, into which state does it go?"""
    between = """With filters between program and amplifier the order matters: does a filter of a
        limited voltage equal a limited filtered one?"""
    yield choose("Answer (a)", answer[0], _limits_matter(False), {"yes": without})
    yield choose("Answer (b)", answer[1], _limits_matter(True), {"no": between})
    return "The same cut twice changes nothing; a cut before a filter is another cut."


@lru_cache
def _limits_matter(filters):
    """Simulate both programs on saturating amplifiers and compare."""
    design = pl.paper_design("triple")
    saturating = pl.Imperfections(saturation=True, filters=filters)
    one, other = (
        pl.simulate(design.rig, c, 2.0, initial=(0.05, 0.0, 0.0), imperfections=saturating).angles
        for c in (design.controller, replace(design.controller, u_max=None))
    )
    return "no" if np.allclose(one, other, atol=1e-9) else "yes"


def exercise_4(answer, rig=None):
    """Largest force of 50 ms at the centre of link 2 of the double with filters and limits, N."""
    if rig is not None:
        yield "This exercise is about the paper's double pendulum; leave rig out."
    yield _force(answer)
    return "A short push of that impulse is all it takes."


@asks("The force", tolerance=TOLERANCE)
def _force(rig):
    lower, upper, torque = _largest()
    yield upper, None
    yield lower, "That is a force on link 1; link 2 is asked for."
    yield torque, "That is a torque in N m; a force at a point is asked for."
    yield PUSH * upper, "That is the impulse; the height of the pulse is asked for."


@lru_cache
def _largest():
    """Forces on links 1 and 2 and a torque on link 2 that the double survives for 50 ms."""
    design = pl.paper_design("double")
    kinds = dict(levers=np.vstack([pl.force_levers(design.rig), [0, 1]]), accuracy=0.01)
    return pl.largest_pulses(design.rig, design.controller, [PUSH], REAL, **kinds).heights[:, 0]


def exercise_5(load, rig=None):
    """A load that fades and lets the oscillation grow."""
    if not isinstance(load, pl.Imperfections):
        yield f"Expected the bench's imperfections with a start torque, {found(load)}."
    fading = {name: getattr(load, name) for name in ("start_torque", "start_torque_time")}
    if np.exp(-7.0 / load.start_torque_time) >= 0.5:
        yield "The load must have faded to less than half by seven seconds."
    design = pl.paper_design("triple")
    draw, start = np.random.default_rng(1), np.array(pl.bench_start(design.rig))
    runs = pl.simulate_many(
        pl.bench_rig(design.rig),
        design.controller,
        7.0,
        [dict(initial=start + draw.uniform(-1e-3, 1e-3, 3)) for _ in range(6)],
        progress=False,
        imperfections=replace(pl.bench_imperfections(design.rig), **fading),
    )
    if any(run.fell for run in runs):
        yield "Under this load the pendulum falls: less of it."
    thirds = ((0, 7 / 3), (14 / 3, 7))
    swings = np.array([[words.swing(run, 1, *third) for third in thirds] for run in runs])
    if (swings[:, 1] > GROWN * swings[:, 0]).sum() <= len(runs) / 2:
        yield """From most starts the swing does not grow enough. Compare its first third with no
            load at all: is it quenched, and which way does the load bend the rig?"""
    return "A load closes the gears; as it fades, the limit cycle comes back."


def exercise_6(sides, rig=None):
    """On which sides the voltages shift under an offset, and in Fig 16."""
    if not isinstance(sides, (tuple, list)) or len(sides) != 2:
        yield f'Two words such as ("same", "same") are asked for, {found(sides)}.'
    top, bottom = (pl.published(f"fig16{c}.y_axis").values[end] for c, end in (("c", 1), ("d", 0)))
    shift = "Look at the signs of both mean voltages for one offset, then for the others."
    yield choose("The first word", sides[0], _side(_shifts()), {"opposite": shift})
    missed = "Is the end of 16c that is missed above or below zero, and that of 16d?"
    yield choose("The second word", sides[1], _side(top * bottom), {"same": missed})
    return "Whatever the size of an offset, it cannot push one voltage up and the other down."


def _side(products):
    return "same" if np.all(products > 0) else "opposite"


def _shifts():
    """Product of both mean voltages, late, under an offset of each sensor."""
    design = pl.paper_design("triple")
    cases = [dict(imperfections=pl.Imperfections(offset=tuple(o))) for o in 1e-3 * np.eye(4)]
    runs = pl.simulate_many(design.rig, design.controller, 37.0, cases, progress=False)
    return np.array([np.prod(run.u[run.t >= 30].mean(axis=0)) for run in runs])
