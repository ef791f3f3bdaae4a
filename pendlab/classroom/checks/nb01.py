"""Checks of notebook 01: the fall, the first move, controllability and the bar."""

import numpy as np
from scipy.optimize import brentq

from ...models import equations, linearize
from ...paper.ledger import published
from ...sampled import sample
from ...studies.controllability import (
    distance_to_uncontrollability,
    in_units,
    recoverable_tilt,
    with_bar,
)
from .judging import choose, compare, on

TS = 0.01


@on("triple", own="'01.1', samples, rig=rig")
def exercise_1(answer, rig=None):
    """Samples of 10 ms in which the fastest fall doubles."""
    s = np.sort(np.linalg.eigvals(linearize(rig).A).real)
    truth = np.log(2) / s[-1] / TS
    return compare(
        "samples",
        answer,
        truth,
        mistakes=[
            (1 / s[-1] / TS, "In that time it grows by a factor e; doubling is less."),
            (np.log(2) / s[-2] / TS, "That is a slower way to fall; the fastest one decides."),
            (np.log(2) / -s[0] / TS, "That eigenvalue is negative: nothing grows there."),
            (truth * TS, "That is in seconds; how many samples of 10 ms are they?"),
            (truth * TS * 1000, "That is in ms; how many samples of 10 ms are they?"),
        ],
    )


@on("double")
def exercise_2(answer, rig=None):
    """Which way the upper link must turn first, relative to the lower one, from a forward lean."""
    A1, A2, M1, M2 = _straight_fall(rig)
    truth = "forwards" if M1 / A1 > M2 / A2 else "backwards"
    hint = (
        "Without torque from the floor the two links turn against each other. Work out which of "
        "the two moves the centre of mass more, and it has to come back over the hinge."
    )
    return choose(
        "first_move", answer, truth, {"forwards": hint, "backwards": hint, "neither": hint}
    )


@on("double", own="'01.3', d, rig=rig")
def exercise_3(answer, rig=None):
    """Distance to uncontrollability in units of 0.1 rad, 0.2 s and u_max."""
    plant = linearize(rig)
    A, B = in_units(plant, 0.1, 0.2, rig.u_max)
    sampled = sample(plant, TS)
    return compare(
        "d",
        answer,
        distance_to_uncontrollability(A, B)[0],
        mistakes=[
            (
                _least(A, B, np.linalg.eigvals(A)),
                "You looked at the eigenvalues of A only. A change of A moves them; the least value "
                "lies beside one of them, so look at other s too.",
            ),
            (
                distance_to_uncontrollability(plant.A, plant.B)[0],
                "That is the distance in rad, s and V; use pl.in_units first.",
            ),
            (
                distance_to_uncontrollability(*in_units(plant, 0.1, 0.2))[0],
                "The inputs are still in volts; pass the limits to pl.in_units.",
            ),
            (
                distance_to_uncontrollability(sampled.A, sampled.B)[0],
                "That belongs to the sampled model; the question is about the continuous one.",
            ),
        ],
        tolerance=5e-3,
    )


@on("double")
def exercise_4(answer, rig=None):
    """Added inertia on link 1 with which the double cannot be stabilised."""
    M, N, P = _matrices(rig)
    A1, A2, M1, M2 = _straight_fall(rig)
    s = np.sqrt(-P[1].sum() / M[1].sum())
    truth, decaying = (-(N[0].sum() * z + P[0].sum()) / z**2 - A1 for z in (s, -s))
    return compare(
        "inertia",
        answer,
        truth,
        mistakes=[
            (
                decaying,
                "There the motor has no say in a mode either, but that mode dies away by itself: the "
                "rig can still be stabilised. Look for the one that grows.",
            ),
            (
                M1 / M2 * A2 - A1,
                "Nearly: without friction this would be it. The friction of the lowest hinge "
                "brakes a straight fall as well; add its term C1 s.",
            ),
            (truth + A1, "That is the whole of link 1's term; how much of it has to be added?"),
            (truth + rig.links[0].inertia, "That is the link's new inertia; the bar's is asked."),
        ],
        tolerance=5e-3,  # three digits
    )


@on("double")
def exercise_5(answer, rig=None):
    """Length (m) from which a tube across the upper link lets more tilt be caught."""
    line = float(published("sec2.tube_mass").values)
    hint = "A uniform tube of length b has mass 0.343 b and inertia (mass) b^2/12; pass both."
    weightless = lambda b: with_bar(rig, rig.n_links, line * b**3 / 12)  # noqa: E731
    third = lambda b: with_bar(rig, rig.n_links, line * b**3 / 3, line * b)  # noqa: E731
    tube = lambda b: with_bar(rig, rig.n_links, line * b**3 / 12, line * b)  # noqa: E731
    return compare(
        "length",
        answer,
        _break_even(rig, tube),
        mistakes=[
            (_break_even(rig, third), f"The bar is held at its middle. {hint}"),
            (_break_even(rig, weightless), f"Without weight every bar up there helps. {hint}"),
        ],
        tolerance=1e-2,  # two digits
    )


def _break_even(rig, barred):
    """Length at which the tilt that can be caught is again that without a bar; nan if never."""
    bare = recoverable_tilt(rig)
    gain = lambda b: recoverable_tilt(barred(b)) / bare - 1  # noqa: E731
    lengths = np.linspace(0.2, 3, 15)
    gains = np.array([gain(b) for b in lengths])
    up = np.flatnonzero((gains[:-1] < 0) & (gains[1:] >= 0))
    return brentq(gain, lengths[up[-1]], lengths[up[-1] + 1]) if len(up) else np.nan


def _least(A, B, points):
    pencils = (np.hstack([A - s * np.eye(len(A)), B]) for s in points)
    return min(np.linalg.svd(pencil, compute_uv=False)[-1] for pencil in pencils)


def _matrices(rig):
    motion, values = equations(rig)
    return tuple(np.asarray(X, dtype=float) for X in motion.linear(*values)[1:4])


def _straight_fall(rig):
    """(J1 + l1 M2, J2 + l1 M2, M1, M2) of a double pendulum: the row sums of M and of -P/g."""
    M, _, P = _matrices(rig)
    return (*M.sum(axis=1), *(-P.sum(axis=1) / rig.g))
