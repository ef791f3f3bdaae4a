"""Homework 8: attitude control of both upper links."""

import numpy as np
from scipy.optimize import fsolve

import pendlab as pl

from ..._arguments import array
from ...gain import unmoved_modes
from .acceptance import REAL, fallen, small_margins, unstable, wrong_design
from .judging import asks

RIG = dict(base="triple", who="your name")
POSE = (0.1, -0.1)  # rad, theta2 - theta1 and theta3 - theta2
STEPS = ((0.1, 0.0), (0.0, 0.1), (0.1, -0.1))
BAND, SECONDS, CROSSTALK, MARGIN = 0.01, 2.0, 0.0115, 0.45
PERIOD, SWING = 12.0, 0.15  # s, rad: a wave of both attitudes
LENGTH = 2 * PERIOD
FOLLOWS = 0.01
BOW = (0.6, 0.5)


def exercise_1(x, u, rig):
    """Equilibrium of the linear model with the two upper hinges bent."""
    return _at_rest(np.append(x, np.zeros(3)) if np.shape(x) == (3,) else x, u, rig=rig)


@asks("x", "u")
def _at_rest(rig):
    x, u = equilibrium(pl.linearize(rig), POSE)
    yield x, None
    upright = """With link 1 upright the centre of mass is not above the lowest hinge, and no motor
        holds that hinge."""
    yield [0, *POSE, 0, 0, 0], upright
    yield [*np.cumsum(x[:3]), 0, 0, 0], "Those are absolute angles; the state holds relative ones."
    yield "u"
    yield u, None


def equilibrium(plant, pose):
    """x and u with A x + B u = 0 and the two upper relative angles as asked."""
    n, m = plant.nstates, plant.ninputs
    left = np.block([[plant.A, plant.B], [np.eye(n)[[1, 2]], np.zeros((2, m))]])
    both = np.linalg.lstsq(left, np.concatenate([np.zeros(n), pose]), rcond=None)[0]
    return both[:n], both[n:]


def exercise_2(possible, rig):
    """Which sets of tracked outputs can be held: as a list of tuples."""
    model = pl.sample(pl.linearize(rig), 0.01)
    candidates = [(0,), (1,), (2,), (3,), (0, 1), (0, 2), (1, 2), (1, 3), (0, 1, 2)]
    truth = {tracked for tracked in candidates if _can_be_held(model, tracked)}
    try:
        found = {tuple(sorted(int(i) for i in np.atleast_1d(entry))) for entry in possible}
    except (TypeError, ValueError):
        yield "Expected a list of tuples such as [(0,), (1, 2)]."
    for wrong in sorted(found - set(candidates)):
        yield f"{wrong} was not among the candidates."
    for wrong in sorted(found - truth):
        rate = "a rate that is to stay at a value other than 0 never lets the pendulum rest"
        angles = "count what the motors can hold, and what gravity decides"
        yield f"{wrong} cannot be held: {rate if 3 in wrong else angles}."
    if truth - found:
        yield f"{len(truth - found)} more of the candidates can be held."
    return "Two motors hold two angles, any two; gravity decides the third."


def _can_be_held(model, tracked):
    """Whether no mode on or outside the unit circle is out of the motors' reach."""
    model = pl.add_integrator(model, tracked)
    return not len(unmoved_modes(model.A, model.B, lambda z: abs(z) > 1 - 1e-6))


def exercise_3(design, rig):
    """Weights with which both attitudes are quick and leave each other alone."""
    yield _linear_shortfall(design, rig)
    for step in STEPS:
        rows = np.tile(step, (round(15 / design.dt) + 1, 1))
        run = pl.simulate(rig, design.controller, 15, reference=rows, imperfections=REAL)
        yield fallen(run, f"On the way to {step} rad")
        error = np.abs(run.angles[:, 1:] - step)
        late = error[run.t > SECONDS].max()
        if late > BAND:
            yield f"""On the way to {step} rad one of the attitudes is still {late:.3f} rad off
                after {SECONDS:g} s; {BAND:g} is asked for. What in Q speaks about the
                integrators?"""
        other = max((error[:, i].max() for i in (0, 1) if step[i] == 0.0), default=0)
        if other > CROSSTALK:
            yield f"""At {step} rad the attitude that should stay moves by {other:.4f} rad,
                {CROSSTALK:g} is allowed: the step hits both motors at once. Which weights hold the
                other one firmer?"""
    return "Both attitudes, quick and apart."


def _linear_shortfall(design, rig):
    wrong = wrong_design(design, rig)
    if not wrong and (design.kp is not None or tuple(np.atleast_1d(design.tracked)) != (1, 2)):
        wrong = "Both upper angles need an integrator: kp=None, tracked=(1, 2)."
    return wrong or unstable(design.filtered_loop) or small_margins(design, (MARGIN, MARGIN))


def exercise_4(pose, rig):
    """Straight forward: the equilibrium of the nonlinear model for a deep bow."""
    pose = array("pose", pose)
    return _pose(pose[:3] if pose.shape == (6,) else pose, rig=rig)


@asks("pose", tolerance=2e-3)
def _pose(rig):
    yield bow(rig), "The linear model would lean a little further: its sines never bend."
    yield np.cumsum(bow(rig)), "Those are absolute angles; relative ones are asked for."
    linear = "That is the linear model's answer; at such angles sines are no longer straight lines."
    yield equilibrium(pl.linearize(rig), BOW)[0][:3], linear


def bow(rig):
    """Relative angles at rest with the upper two bent by BOW: no torque about the free hinge."""
    f = pl.nonlinear(rig)

    def rates(unknown):
        theta1, *u = unknown
        return f(np.array([theta1, *BOW, 0, 0, 0]), u)[3:]

    return np.array([fsolve(rates, [-0.5, 0, 0], xtol=1e-12)[0], *BOW])


def wave(t):
    angle = 2 * np.pi * t / PERIOD
    return SWING * np.column_stack([np.sin(angle), np.cos(angle) - 1])


def exercise_5(design, reference, rig):
    """Follow a wave: error of both attitudes, with a reference of the student's own making."""
    yield _linear_shortfall(design, rig)
    t = design.dt * np.arange(round(LENGTH / design.dt) + 1)
    rows = array("reference", reference, (len(t), 2))
    run = pl.simulate(rig, design.controller, LENGTH, reference=rows, imperfections=REAL)
    if run.fell:
        yield f"It falls after {run.fell_at:.2f} s."
    error = np.abs(run.angles[:, 1:] - wave(t))[t > PERIOD].max()
    if error > FOLLOWS:
        yield f"""In the second round the attitudes are up to {error:.3f} rad off the wave,
            {FOLLOWS:g} is asked for. They come late and with another amplitude: does your reference
            undo both?"""
    return "It dances in time."
