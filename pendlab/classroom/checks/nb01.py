"""Checks of notebook 01: the fall, the first move, controllability and the bar."""

import numpy as np

import pendlab as pl

from ...loop import crossings
from ...models import matrices
from .judging import asks, choose, on

TS = 0.01


@asks("samples", base="triple", own="'01.1', samples, rig=rig")
def exercise_1(rig):
    """Samples of 10 ms in which the fastest fall doubles."""
    s = np.sort(pl.linearize(rig).poles().real)
    truth = np.log(2) / s[-1] / TS
    yield truth, None
    yield 1 / s[-1] / TS, "In that time it grows by a factor e; doubling is less."
    yield np.log(2) / s[-2] / TS, "That is a slower way to fall; the fastest one decides."
    yield np.log(2) / -s[0] / TS, "That eigenvalue is negative: nothing grows there."
    yield truth * TS, "That is in seconds; how many samples of 10 ms are they?"
    yield truth * TS * 1000, "That is in ms; how many samples of 10 ms are they?"


@on("double")
def exercise_2(answer, rig=None):
    """Which way link 2 must turn first, relative to link 1, from a forward lean."""
    A1, A2, M1, M2 = _straight_fall(rig)
    truth = "forwards" if M1 / A1 > M2 / A2 else "backwards"
    hint = """Without torque from the floor the two links turn against each other. Work out which of
        the two moves the centre of mass more, and it has to come back over the hinge."""
    words = ("forwards", "backwards", "neither")
    return choose("first_move", answer, truth, dict.fromkeys(words, hint))


@asks("d", base="double", own="'01.3', d, rig=rig")
def exercise_3(rig):
    """Distance to uncontrollability in units of 0.1 rad, 0.2 s and u_max."""
    plant = pl.linearize(rig)
    sampled = pl.sample(plant, TS)
    A, B = pl.in_units(plant, 0.1, 0.2, rig.u_max)

    def distance(A, B):
        return pl.distance_to_uncontrollability(A, B)[0]

    yield distance(A, B), None
    beside = """You looked at the eigenvalues of A only. A change of A moves them; the least value
        lies beside one of them, so look at other s too."""
    yield _least(A, B, np.linalg.eigvals(A)), beside
    yield distance(plant.A, plant.B), "That is the distance in rad, s and V; use pl.in_units first."
    volts = "The inputs are still in volts; pass the limits to pl.in_units."
    yield distance(*pl.in_units(plant, 0.1, 0.2)), volts
    continuous = "That belongs to the sampled model; the question is about the continuous one."
    yield distance(sampled.A, sampled.B), continuous


@asks("inertia", base="double")
def exercise_4(rig):
    """Added inertia on link 1 with which the double cannot be stabilised."""
    _, M, N, P, _ = matrices(rig)
    A1, A2, M1, M2 = _straight_fall(rig)
    s = np.sqrt(-P[1].sum() / M[1].sum())
    truth, decaying = (-(N[0].sum() * z + P[0].sum()) / z**2 - A1 for z in (s, -s))
    yield truth, None
    dies = """There the motor has no say in a mode either, but that mode dies away by itself: the
        rig can still be stabilised. Look for the one that grows."""
    yield decaying, dies
    brakes = """Nearly: without friction this would be it. The friction of the lowest hinge brakes a
        straight fall as well; add its term C1 s."""
    yield M1 / M2 * A2 - A1, brakes
    yield truth + A1, "That is the whole of link 1's term; how much of it has to be added?"
    yield truth + rig.links[0].inertia, "That is the link's new inertia; the bar's is asked."


@asks("length", base="double", tolerance=1e-2)  # two digits
def exercise_5(rig):
    """Length (m) from which a tube across link 2 lets more tilt be caught."""
    hint = "A uniform tube of length b has mass 0.343 b and inertia (mass) b^2/12; pass both."
    yield _break_even(rig), None
    yield _break_even(rig, arm=3), f"The bar is held at its middle. {hint}"
    yield _break_even(rig, weight=0), f"Without weight every bar up there helps. {hint}"


def _break_even(rig, arm=12, weight=1):
    """Length at which the tilt that can be caught is again that without a tube; nan if never.

    The tube counts with m b^2/`arm` and with `weight` times its mass.
    """
    line, bare = float(pl.published("sec2.tube_mass").values), pl.recoverable_tilt(rig)

    def gain(b):
        barred = pl.with_bar(rig, rig.n_links, line * b**3 / arm, weight * line * b)
        return pl.recoverable_tilt(barred) / bare - 1

    lengths = np.linspace(0.2, 3, 15)
    found = crossings(lengths, np.array([gain(b) for b in lengths]), gain)
    return found[-1] if found else np.nan


def _least(A, B, points):
    pencils = (np.hstack([A - s * np.eye(len(A)), B]) for s in points)
    return min(np.linalg.svd(pencil, compute_uv=False)[-1] for pencil in pencils)


def _straight_fall(rig):
    """(J1 + l1 M2, J2 + l1 M2, M1, M2) of a double pendulum: the row sums of M and of -P/g."""
    _, M, _, P, _ = matrices(rig)
    return (*M.sum(axis=1), *(-P.sum(axis=1) / rig.g))
