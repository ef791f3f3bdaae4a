"""Checks of notebook 05."""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from ..._arguments import array, found
from ...bench.gearbox import bench_imperfections, bench_rig, bench_start
from ...bench.imperfections import Imperfections
from ...bench.many import simulate_many
from ...bench.simulation import simulate
from ...loop import margins
from ...paper import words
from ...paper.designs import paper_design
from ...paper.ledger import published
from ...studies.pushes import force_levers, largest_pulses
from ...studies.transmission import closed_loop, time_constant
from .acceptance import no_design, unstable
from .judging import asks, choose, judged

SLOWEST, DISTANCE = 2.0, 0.6  # s; from -1
PUSH, TOLERANCE = 0.05, 0.03  # s; of the force
GROWN = 1.3  # last third of the first seven seconds over the first, of a load that lets go


@judged
def exercise_1(answer, rig=None):
    """Rest position under an offset of 3 mrad in theta1."""
    answer, offset = array("The answer", answer, (2,)), 0.003
    loop = closed_loop(paper_design("double"))[["theta1", "theta2-theta1"], "noise theta1"]
    # The truth is zero, so what counts as near is absolute: a hundredth of the offset.
    right = np.abs(answer - offset * loop.dcgain().ravel()) < offset / 100
    if not right.all():
        if np.allclose(answer, [offset, 0], atol=1e-6):
            yield "Those are the sensor errors; the rig does not simply follow them."
        if right[1]:
            yield "The integrator does its part; where must the centre of mass then be?"
        yield "What does the integrator insist on once everything is at rest?"
    return "The integrator wins: an offset below does not bend the rig."


@judged
def exercise_2(answer, rig=None):
    """A design of the double with a fast integrator and a margin."""
    yield no_design(answer)
    if answer.rig.n_links != 2:
        yield "The double pendulum is asked for."
    yield unstable(answer.filtered_loop)
    slowest = time_constant(answer.filtered_loop)
    distance = margins(answer.loop(0, filters=True)).modulus
    if slowest >= SLOWEST:
        yield f"The slowest time constant is still {slowest:.1f} s; which weight acts on w?"
    if distance <= DISTANCE:
        yield f"Fast enough, but only {distance:.2f} from -1 with filters: a little less haste."
    return f"Slowest time constant {slowest:.2f} s at a distance of {distance:.2f} from -1."


@judged
def exercise_3(answer, rig=None):
    """Does forgetting step 4 change the motion when H = 0, without and with the motors' filters?"""
    if not isinstance(answer, (tuple, list)) or len(answer) != 2:
        yield f'A pair such as ("yes", "yes") is asked for, {found(answer)}.'
    without = (
        "Without filters the amplifier cuts what the program would have cut. Follow u "
        "through (29): with H = 0, into which state does it go?"
    )
    between = (
        "With filters between program and amplifier the order matters: does a filter of a "
        "limited voltage equal a limited filtered one?"
    )
    yield choose("Answer (a)", answer[0], _limits_matter(False), {"yes": without})
    yield choose("Answer (b)", answer[1], _limits_matter(True), {"no": between})
    return "The same cut twice changes nothing; a cut before a filter is another cut."


@lru_cache
def _limits_matter(filters):
    """Simulate both programs on saturating amplifiers and compare."""
    design = paper_design("triple")
    saturating = Imperfections(saturation=True, filters=filters)
    runs = [
        simulate(design.rig, c, 2.0, initial=(0.05, 0.0, 0.0), imperfections=saturating)
        for c in (design.controller, replace(design.controller, u_max=None))
    ]
    return "no" if np.allclose(runs[0].angles, runs[1].angles, atol=1e-9) else "yes"


@judged
def exercise_4(answer, rig=None):
    """Largest force of 50 ms at the centre of link 2 of the double with filters and limits, N."""
    if rig is not None:
        yield "This exercise is about the paper's double pendulum; leave rig out."
    yield _force(answer)
    return "A short push of that impulse is all it takes."


@asks("The force", tolerance=TOLERANCE)
def _force(rig):
    forces, torques = _largest_forces()
    yield forces[1], None
    yield forces[0], "That is a force on link 1; link 2 is asked for."
    yield torques[1], "That is a torque in N m; a force at a point is asked for."
    yield PUSH * forces[1], "That is the impulse; the height of the pulse is asked for."


@lru_cache
def _largest_forces():
    """(forces, torques) that the double survives for 50 ms on each link."""
    design, real = paper_design("double"), Imperfections(filters=True, saturation=True)
    return tuple(
        largest_pulses(
            design.rig, design.controller, [PUSH], real, accuracy=0.01, levers=levers
        ).heights[:, 0]
        for levers in (force_levers(design.rig), None)
    )


@judged
def exercise_5(load, rig=None):
    """A load that fades and lets the oscillation grow."""
    if not isinstance(load, Imperfections):
        yield f"Expected the bench's imperfections with a start torque, {found(load)}."
    torque, time = load.start_torque, load.start_torque_time
    if np.exp(-7.0 / time) >= 0.5:
        yield "The load must have faded to less than half by seven seconds."
    design = paper_design("triple")
    draw, start = np.random.default_rng(1), np.array(bench_start(design.rig))
    runs = simulate_many(
        bench_rig(design.rig),
        design.controller,
        7.0,
        [dict(initial=start + draw.uniform(-1e-3, 1e-3, 3)) for _ in range(6)],
        progress=False,
        imperfections=replace(
            bench_imperfections(design.rig), start_torque=torque, start_torque_time=time
        ),
    )
    if any(run.fell for run in runs):
        yield "Under this load the pendulum falls: less of it."
    thirds = ((0, 7 / 3), (14 / 3, 7))
    swings = np.array([[words.swing(run, 1, *third) for third in thirds] for run in runs])
    if (swings[:, 1] > GROWN * swings[:, 0]).sum() <= len(runs) / 2:
        yield (
            "From most starts the swing does not grow enough. Compare its first third with no load "
            "at all: is it quenched, and which way does the load bend the rig?"
        )
    return "A load closes the gears; as it fades, the limit cycle comes back."


@judged
def exercise_6(sides, rig=None):
    """On which sides the voltages shift under an offset, and in Fig 16."""
    if not isinstance(sides, (tuple, list)) or len(sides) != 2:
        yield f'Two words such as ("same", "same") are asked for, {found(sides)}.'
    shift = "Look at the signs of both mean voltages for one offset, then for the others."
    yield choose("The first word", sides[0], _shift(), {"opposite": shift})
    missed = "Is the end of 16c that is missed above or below zero, and that of 16d?"
    yield choose("The second word", sides[1], _of_fig16(), {"same": missed})
    return "Whatever the size of an offset, it cannot push one voltage up and the other down."


def _shift():
    design = paper_design("triple")
    agree = []
    for offset in 1e-3 * np.eye(4):
        wrong = Imperfections(offset=tuple(offset))
        run = simulate(design.rig, design.controller, 37.0, imperfections=wrong)
        agree.append(np.prod(run.u[run.t >= 30].mean(axis=0)) > 0)
    return "same" if all(agree) else "opposite"


def _of_fig16():
    upper, lower = published("fig16c.y_axis").values[1], published("fig16d.y_axis").values[0]
    return "same" if upper * lower > 0 else "opposite"
