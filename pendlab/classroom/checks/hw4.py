"""Homework 4: faster offset rejection at equal margins."""

from dataclasses import replace

import numpy as np

from ..._arguments import number
from ...bench.imperfections import Imperfections
from ...bench.simulation import simulate
from ...loop import time_constant
from .acceptance import modulus_margins, reference, small_margins, unstable, wrong_design
from .judging import compare, judged, on

KP = 5.0
SLOWEST, WANTED, OFFSET, BAND, SETTLED, PEAK = 20.0, 4.0, 0.003, 0.01, 10.0, 0.2
STEP, LASTING = 0.2, 30.0  # rad, s


@on("triple", who="your name")
def exercise_1(tau, rig=None):
    design = reference(rig, KP)
    truth = time_constant(design.nominal_loop)
    return compare(
        "tau",
        tau,
        truth,
        tolerance=5e-3,
        mistakes=[
            (truth / design.dt, "That is counted in samples; how long is one?"),
            (truth * np.log(2), "That is the half-life; a time constant is the decay to 1/e."),
            (1 / np.abs(1 - np.exp(-design.dt / truth)), "Samples again, and by 1/(1 - z)."),
        ],
    )


@on("triple", who="your name")
@judged
def exercise_2(weight, rig=None):
    weight = number("weight", weight, above=0)
    design = reference(rig, KP)
    faster = replace(design, Q=(*design.Q[:-1], weight))
    tau = time_constant(faster.nominal_loop)
    if abs(tau - SLOWEST) > 0.05 * SLOWEST:
        yield (
            f"With this weight the slowest motion has {tau:.3g} s, {SLOWEST:g} s is asked "
            "for. By which power of the weight does the time change?"
        )
    return f"The slowest motion takes {tau:.2f} s."


@on("triple", who="your name")
@judged
def exercise_3(design, rig=None):
    start = reference(rig, KP)

    yield wrong_design(design, rig)
    yield unstable(design.filtered_loop)
    tau = time_constant(design.filtered_loop)
    if tau > WANTED:
        yield (
            f"With filters the slowest motion has a time constant of {tau:.3g} s, at most "
            f"{WANTED:g} s is asked for."
        )
    yield small_margins(design, np.array(modulus_margins(start)) - 1e-6)
    return (
        "{:.2f} s at margins of {:.3f} and {:.3f}, where the start had {:.3f} and {:.3f}.".format(
            time_constant(design.filtered_loop),
            *modulus_margins(design),
            *modulus_margins(start),
        )
    )


@on("triple", who="your name")
@judged
def exercise_4(design, rig=None):
    first = exercise_3(design, rig=rig)
    if not first:
        yield f"The linear requirements first (exercise 3): {first.message}"
    bench = Imperfections(filters=True, saturation=True, offset=(OFFSET, 0, 0, 0))
    run = simulate(design.rig, design.controller, LASTING, imperfections=bench)
    step = simulate(
        design.rig, design.controller, LASTING, reference=STEP,
        imperfections=replace(bench, offset=0.0),
    )  # fmt: skip

    if run.fell:
        yield f"With the offset the nonlinear pendulum falls after {run.fell_at:.2f} s."
    settled, peak = settling(run), np.abs(run.angles[:, 1]).max()
    if settled > SETTLED:
        yield (
            f"theta2 - theta1 enters {BAND} rad for good after {settled:.1f} s, {SETTLED:g} s is "
            "asked for."
        )
    if peak > PEAK:
        yield (
            f"On the way theta2 - theta1 swings out to {peak:.3f} rad, {PEAK} is allowed: the "
            "offset is rejected fast in the end and believed too much at first."
        )
    if run.saturated.any():
        yield f"A motor is at its limit in {run.saturated.max():.1%} of the samples."
    if step.fell or abs(step.angles[-1, 1] - STEP) > BAND:
        yield f"An attitude step of {STEP:g} rad is not followed within {LASTING:g} s."
    return f"Settled after {settling(run):.1f} s, peak {np.abs(run.angles[:, 1]).max():.3f} rad."


def settling(run):
    """Time from which theta2 - theta1 stays within BAND, s."""
    outside = np.flatnonzero(np.abs(run.angles[:, 1]) > BAND)
    return float(run.t[outside[-1]]) + run.dt if len(outside) else 0.0
