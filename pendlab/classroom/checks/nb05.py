"""Checks of notebook 05."""

from dataclasses import replace

import numpy as np

from ..._arguments import array, found
from ...bench.imperfections import Imperfections
from ...bench.simulation import simulate
from ...design import Design
from ...loop import closed_loop_eigenvalues, margins
from ...paper.designs import paper_design
from ...studies.pushes import largest_pulses
from .judging import Verdict, choose, compare

SLOWEST, DISTANCE = 2.0, 0.6  # s; from -1
PUSH, TOLERANCE = 0.05, 0.03  # s; of the height


def exercise_1(answer, rig=None):
    """Rest position under an offset of 3 mrad in theta1."""
    design, offset = paper_design("double"), np.array([0.003, 0.0, 0.0])
    answer = array("The answer", answer, (2,))
    # The truth is zero, so what counts as near is absolute: a hundredth of the offset.
    right = np.abs(answer - _rest(design, offset)) < 3e-5
    if right.all():
        return Verdict(True, "The integrator wins: an offset below does not bend the rig.")
    if np.allclose(answer, offset[:2], atol=1e-6):
        return Verdict(False, "Those are the sensor errors; the rig does not simply follow them.")
    if right[1]:
        return Verdict(
            False, "The integrator does its part; where must the centre of mass then be?"
        )
    return Verdict(False, "What does the integrator insist on once everything is at rest?")


def _rest(design, offset):
    """Angles at rest, from the closed loop's equilibrium."""
    loop, system = design.nominal_loop, design.controller.system
    A = loop.A - loop.B @ loop.C
    drive = np.concatenate([design.model.B @ system.D @ offset, system.B @ offset])
    return np.linalg.solve(np.eye(len(A)) - A, drive)[: design.rig.n_links]


def exercise_2(answer, rig=None):
    """A design of the double with a fast integrator and a margin."""
    if not isinstance(answer, Design):
        return Verdict(
            False, f"A pl.Design is asked for, {found(answer)}; try dataclasses.replace."
        )
    if answer.rig.n_links != 2:
        return Verdict(False, "The double pendulum is asked for.")
    eigenvalue = abs(closed_loop_eigenvalues(answer.filtered_loop)[0])
    if eigenvalue >= 1:
        return Verdict(False, "With filters this loop is not stable.")
    slowest = -answer.dt / np.log(eigenvalue)
    distance = margins(answer.loop(0, filters=True)).modulus
    if slowest >= SLOWEST:
        return Verdict(
            False, f"The slowest time constant is still {slowest:.1f} s; which weight acts on w?"
        )
    if distance <= DISTANCE:
        return Verdict(
            False,
            f"Fast enough, but only {distance:.2f} from -1 with filters: a little less haste.",
        )
    return Verdict(
        True, f"Slowest time constant {slowest:.2f} s at a distance of {distance:.2f} from -1."
    )


def exercise_3(answer, rig=None):
    """Does forgetting step 4 change the motion when H = 0?"""
    return choose(
        "The answer",
        answer,
        _limits_matter(),
        {
            "yes": "Follow u through (29): with H = 0, into which state does it go?",
            "no": "Try both controllers from a large tilt and compare.",
        },
    )


def _limits_matter():
    """Simulate both programs on saturating amplifiers and compare."""
    design = paper_design("triple")
    saturating = Imperfections(saturation=True)
    runs = [
        simulate(design.rig, c, 2.0, initial=(0.05, 0.0, 0.0), imperfections=saturating)
        for c in (design.controller, replace(design.controller, u_max=None))
    ]
    return "no" if np.allclose(runs[0].angles, runs[1].angles, atol=1e-9) else "yes"


def exercise_4(answer, rig=None):
    """Largest torque pulse of 50 ms on link 2 of the double with filters and limits, N m."""
    design = paper_design("double") if rig is None else None
    if design is None:
        return Verdict(False, "This exercise is about the paper's double pendulum; leave rig out.")
    real = Imperfections(filters=True, saturation=True)
    limits = largest_pulses(design.rig, design.controller, [PUSH], real, accuracy=0.01)
    truth = limits.heights[1, 0]
    return compare(
        "The height",
        answer,
        truth,
        [
            (limits.impulses[1, 0], "That is the impulse; the height of the pulse is asked for."),
        ],
        tolerance=TOLERANCE + 0.005,
        praise="A short push of that impulse is all it takes.",
    )
