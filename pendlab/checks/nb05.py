"""Checks of notebook 05."""

import numpy as np

from .._checks import found
from ..design import Design
from ..imperfections import Imperfections
from ..loop import closed_loop_eigenvalues, margins
from ..paper import paper_design
from ..pushes import largest_pulses
from ..simulation import simulate
from .judging import Verdict, choose, compare


def exercise_1(answer, rig=None):
    """Rest position under an offset of 3 mrad in theta1."""
    design = paper_design("double")
    offset = np.array([0.003, 0.0, 0.0])
    truth = _rest(design, offset)
    early = simulate(
        design.rig, design.controller, 5.0, imperfections=Imperfections(offset=tuple(offset))
    )
    return (
        compare(
            "The rest position",
            answer,
            truth,
            [
                (offset[:2], "Those are the sensor errors; the rig does not simply follow them."),
                (
                    early.angles[-1],
                    "The integrator has not finished yet: wait longer, or solve for rest.",
                ),
            ],
            tolerance=0.02,
            praise="The integrator wins: an offset below does not bend the rig.",
        )
        if np.abs(truth).max() > 1e-9
        else _near_zero(answer)
    )


def _near_zero(answer):
    """Judge an answer whose truth is zero."""
    answer = np.asarray(answer, dtype=float)
    if answer.shape != (2,):
        return Verdict(False, f"Two angles are asked for, {found(answer)}.")
    if np.all(np.abs(answer) < 2e-5):
        return Verdict(True, "The integrator wins: an offset below does not bend the rig.")
    if abs(answer[1]) < 2e-5:
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
    if slowest >= 2:
        return Verdict(
            False, f"The slowest time constant is still {slowest:.1f} s; which weight acts on w?"
        )
    if distance <= 0.6:
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
    from dataclasses import replace

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
    limits = largest_pulses(design.rig, design.controller, [0.05], real, accuracy=0.01)
    truth = limits.heights[1, 0]
    return compare(
        "The height",
        answer,
        truth,
        [
            (limits.impulses[1, 0], "That is the impulse; the height of the pulse is asked for."),
        ],
        tolerance=0.035,
        praise="A short push of that impulse is all it takes.",
    )
