"""Homework 4: faster offset rejection at equal margins."""

from dataclasses import replace

import numpy as np

import pendlab as pl

from ..._arguments import number
from . import acceptance
from .judging import asks

RIG = dict(base="triple", who="your name")
KP = 5.0
SLOWEST, WANTED, OFFSET, BAND, SETTLED, PEAK = 20.0, 4.0, 0.003, 0.01, 10.0, 0.2
STEP, LASTING = 0.2, 30.0  # rad, s


@asks("tau")
def exercise_1(rig):
    """Time constant of the slowest motion without filters, s."""
    design = acceptance.reference(rig, KP)
    tau = pl.time_constant(design.nominal_loop)
    yield tau, None
    yield tau / design.dt, "That is counted in samples; how long is one?"
    yield tau / 60, "That is in minutes; seconds are asked for."
    yield tau * np.log(2), "That is the half-life; a time constant is the decay to 1/e."
    yield 1 / np.abs(1 - np.exp(-design.dt / tau)), "Samples again, and by 1/(1 - z)."


def exercise_2(weight, rig):
    """Weight of the integrator at which the slowest motion takes `SLOWEST` seconds."""
    design = acceptance.reference(rig, KP)
    faster = replace(design, Q=(*design.Q[:-1], number("weight", weight, above=0)))
    tau = pl.time_constant(faster.nominal_loop)
    if abs(tau - SLOWEST) > 0.05 * SLOWEST:
        yield f"""With this weight the slowest motion has {tau:.3g} s, {SLOWEST:g} s is asked for.
            By which power of the weight does the time change?"""
    return f"The slowest motion takes {tau:.1f} s."


def exercise_3(design, rig):
    """A design that is quick at the margins of the start."""
    start = acceptance.modulus_margins(acceptance.reference(rig, KP))
    yield acceptance.wrong_design(design, rig)
    loop = design.filtered_loop
    yield acceptance.unstable(loop)
    yield acceptance.slow(loop, WANTED)
    yield acceptance.small_margins(design, np.array(start) - 1e-6)
    tau, both = pl.time_constant(loop), "{:.3f} and {:.3f}"
    mine = both.format(*acceptance.modulus_margins(design))
    return f"{tau:.2f} s at margins of {mine}, where the start had {both.format(*start)}."


def exercise_4(design, rig):
    """The same, on the nonlinear pendulum with an offset."""
    yield acceptance.before("The linear requirements", "exercise 3", exercise_3(design, rig))
    offset, real = replace(acceptance.REAL, offset=(OFFSET, 0, 0, 0)), acceptance.REAL
    run = pl.simulate(rig, design.controller, LASTING, imperfections=offset)
    yield acceptance.fallen(run, "With the offset")
    settled, peak = settling(run), np.abs(run.angles[:, 1]).max()
    if settled > SETTLED:
        yield f"""theta2 - theta1 enters {BAND} rad for good after {settled:.1f} s, {SETTLED:g} s is
            asked for."""
    if peak > PEAK:
        yield f"""On the way theta2 - theta1 swings out to {peak:.3f} rad, {PEAK} is allowed: the
            offset is rejected fast in the end and believed too much at first."""
    if run.saturated.any():
        yield f"A motor is at its limit in {run.saturated.max():.1%} of the samples."
    step = pl.simulate(rig, design.controller, LASTING, reference=STEP, imperfections=real)
    if step.fell or abs(step.angles[-1, 1] - STEP) > BAND:
        yield f"An attitude step of {STEP:g} rad is not followed within {LASTING:g} s."
    return f"Settled after {settled:.1f} s, peak {peak:.3f} rad."


def settling(run):
    """Time from which theta2 - theta1 stays within BAND, s."""
    outside = np.flatnonzero(np.abs(run.angles[:, 1]) > BAND)
    return float(run.t[outside[-1]]) + run.dt if len(outside) else 0.0
