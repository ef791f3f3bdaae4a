"""Homework 8: attitude control of both upper links."""

import numpy as np
from scipy.optimize import fsolve

from ..._arguments import array
from ...bench.imperfections import Imperfections
from ...bench.simulation import simulate
from ...design import Design
from ...models import linearize, nonlinear
from .acceptance import small_margins, unstable, wrong_design
from .judging import all_right, compare, judged, on

POSE = (0.1, -0.1)  # rad, theta2 - theta1 and theta3 - theta2
STEPS = ((0.1, 0.0), (0.0, 0.1), (0.1, -0.1))
BAND, SECONDS, CROSSTALK, MARGIN = 0.01, 2.0, 0.0115, 0.45
PERIOD, SWING = 12.0, 0.15  # s, rad: a wave of both attitudes
LENGTH = 2 * PERIOD
FOLLOWS = 0.03


@on("triple", who="your name")
def exercise_1(x, u, rig=None):
    """Equilibrium of the linear model with the two upper hinges bent."""
    plant = linearize(rig)
    truth_x, truth_u = equilibrium(plant, POSE)
    if np.shape(x) == (3,):
        x = np.concatenate([x, np.zeros(3)])
    first = compare(
        "x",
        x,
        truth_x,
        mistakes=[
            (np.concatenate([[0], POSE, np.zeros(3)]), "With link 1 upright the centre of mass is "
             "not above the lowest hinge, and no motor holds that hinge."),
            (np.concatenate([np.cumsum(truth_x[:3]), np.zeros(3)]), "Those are absolute angles; the "
             "state holds relative ones."),
        ],
    )  # fmt: skip
    return all_right(first, compare("u", u, truth_u))


def equilibrium(plant, pose):
    """x and u with A x + B u = 0 and the two upper relative angles as asked."""
    n, m = plant.nstates, plant.ninputs
    select = np.eye(n)[[1, 2]]
    left = np.block([[plant.A, plant.B], [select, np.zeros((2, m))]])
    both = np.linalg.lstsq(left, np.concatenate([np.zeros(n), pose]), rcond=None)[0]
    return both[:n], both[n:]


@on("triple", who="your name")
@judged
def exercise_2(possible, rig=None):
    """Which sets of tracked outputs can be held: as a list of tuples."""
    from ...sampled import add_integrator, sample

    model = sample(linearize(rig), 0.01)
    candidates = [(0,), (1,), (2,), (3,), (0, 1), (0, 2), (1, 2), (1, 3), (0, 1, 2)]
    truth = {pair for pair in candidates if _reaches(add_integrator(model, list(pair)))}
    try:
        found = {tuple(sorted(int(i) for i in np.atleast_1d(entry))) for entry in possible}
    except TypeError:
        yield "Expected a list of tuples such as [(0,), (1, 2)]."
    for wrong in sorted(found - set(candidates)):
        yield f"{wrong} was not among the candidates."
    for wrong in sorted(found - truth):
        reason = (
            "a rate that is to stay at a value other than 0 never lets the pendulum rest"
            if 3 in wrong
            else "count what the motors can hold, and what gravity decides"
        )
        yield f"{wrong} cannot be held: {reason}."
    if truth - found:
        yield f"{len(truth - found)} more of the candidates can be held."
    return "Two motors hold two angles, any two; gravity decides the third."


def _reaches(model):
    """No eigenvalue on or outside the unit circle is out of reach."""
    A, B = model.A, model.B
    for value in np.linalg.eigvals(A):
        if abs(value) > 1 - 1e-9:
            # The integrators' eigenvalue 1 is computed only to rounding.
            value = 1.0 if abs(value - 1) < 1e-5 else value
            sigma = np.linalg.svd(np.hstack([A - value * np.eye(len(A)), B]), compute_uv=False)
            if sigma[-1] < 1e-9 * sigma[0]:
                return False
    return True


def step_run(design, reference, seconds=15):
    bench = Imperfections(filters=True, saturation=True)
    rows = np.tile(reference, (round(seconds / design.dt) + 1, 1))
    return simulate(design.rig, design.controller, seconds, reference=rows, imperfections=bench)


@on("triple", who="your name")
@judged
def exercise_3(design, rig=None):
    yield from _linear_shortfalls(design, rig)
    for step in STEPS:
        run = step_run(design, step)
        if run.fell:
            yield f"On the way to {step} rad it falls after {run.fell_at:.2f} s."
        error = np.abs(run.angles[:, 1:] - step)
        late = error[run.t > SECONDS].max()
        if late > BAND:
            yield (
                f"On the way to {step} rad one of the attitudes is still {late:.3f} rad off "
                f"after {SECONDS:g} s; {BAND:g} is asked for. What in Q speaks about the "
                "integrators?"
            )
        other = [error[:, i].max() for i in (0, 1) if step[i] == 0.0]
        if other and max(other) > CROSSTALK:
            yield (
                f"At {step} rad the attitude that should stay moves by {max(other):.4f} rad, "
                f"{CROSSTALK:g} is allowed: the step hits both motors at once. Which weights "
                "hold the other one firmer?"
            )
    return "Both attitudes, quick and apart."


def _linear_shortfalls(design, rig):
    yield wrong_design(design, rig)
    if design.kp is not None or tuple(np.atleast_1d(design.tracked)) != (1, 2):
        yield "Both upper angles need an integrator: kp=None, tracked=(1, 2)."
    yield unstable(design.filtered_loop)
    yield small_margins(design, (MARGIN, MARGIN))


@on("triple", who="your name")
def exercise_4(pose, rig=None):
    """Straight forward: the equilibrium of the nonlinear model for a deep bow."""
    pose = array("pose", pose)
    pose = pose[:3] if pose.shape == (6,) else pose
    truth = bow(rig)
    return compare(
        "pose",
        pose,
        truth,
        mistakes=[
            (np.cumsum(truth), "Those are absolute angles; relative ones are asked for."),
            (equilibrium(linearize(rig), BOW)[0][:3], "That is the linear model's answer; at such "
             "angles sines are no longer straight lines."),
        ],
        tolerance=2e-3,
    )  # fmt: skip


BOW = (0.6, 0.5)


def bow(rig):
    """Relative angles at rest with the upper two bent by BOW: no torque about the free hinge."""
    f = nonlinear(rig)

    def rates(unknown):
        theta1, *u = unknown
        return f(np.array([theta1, *BOW, 0, 0, 0]), u)[3:]

    return np.array([fsolve(rates, [-0.5, 0, 0], xtol=1e-12)[0], *BOW])


def wave(t):
    return SWING * np.column_stack(
        [np.sin(2 * np.pi * t / PERIOD), np.cos(2 * np.pi * t / PERIOD) - 1]
    )


@on("triple", who="your name")
@judged
def exercise_5(design, reference, rig=None):
    """Follow a wave: error of both attitudes, with a reference of the student's own making."""
    t = design.dt * np.arange(round(LENGTH / design.dt) + 1) if isinstance(design, Design) else 0

    yield from _linear_shortfalls(design, rig)
    rows = array("reference", reference, (len(t), 2))
    bench = Imperfections(filters=True, saturation=True)
    run = simulate(rig, design.controller, LENGTH, reference=rows, imperfections=bench)
    if run.fell:
        yield f"It falls after {run.fell_at:.2f} s."
    error = np.abs(run.angles[:, 1:] - wave(t))[t > PERIOD].max()
    if error > FOLLOWS:
        yield (
            f"In the second round the attitudes are up to {error:.3f} rad off the wave, "
            f"{FOLLOWS:g} is asked for. They come late: either a faster loop, or a reference "
            "that is early."
        )
    return "It dances in time."
