"""Homework 9: a controller of one's own in the contest on the bench."""

import numpy as np

from ...bench.imperfections import bench_start
from ...bench.simulation import simulate
from ...paper.designs import paper_design
from ...parameters import load
from ..contest import contest, play, points, rounds
from ..own_rig import my_rig
from .judging import Verdict, compare

REST = 0.005  # rad
BALANCED, SETTLED = 5.0, 4.0  # s
AHEAD = 3.0  # points above the paper's controller
OTHERS = ("first neighbour", "second neighbour", "third neighbour")


def papers(rig):
    return paper_design("double").controller


def not_callable(make):
    if not callable(make):
        return Verdict(False, f"Expected your class, found {type(make).__name__}.")
    return None


def exercise_1(make, rig=None):
    """The smallest controller: the interface, and five seconds on the ideal rig."""
    rig = load("double") if rig is None else rig
    wrong = not_callable(make)
    if wrong:
        return wrong
    controller = make(rig)
    y = np.array([0.01, -0.02, 0.0])
    start = getattr(controller, "start", None)
    x0 = np.array([*y[:2], 0.0, 0.0])
    begin = start(x0) if start is not None else None
    first = _voltage(controller, begin, y)
    controller.step(begin, y + 0.01, 0.0)
    if first != _voltage(controller, begin, y):
        return Verdict(
            False, "Equal calls of step gave different voltages: keep what must be remembered in the "
            "state that step returns, not in self."
        )  # fmt: skip
    run = simulate(rig, controller, BALANCED, initial=bench_start(rig))
    if run.fell:
        late = "sign of u = -F x?" if run.fell_at < 1 else "rates: are they in rad/s?"
        return Verdict(
            False, f"On the ideal rig it falls after {run.fell_at:.2f} s. Check the {late}"
        )
    left = np.abs(run.angles[run.t > SETTLED]).max()
    if left > REST:
        return Verdict(
            False, f"It stays up, but after {SETTLED:g} s is still {left:.3f} rad away; {REST:g} is asked for. "
            "Which weights bring back the slow lean of the whole pendulum?"
        )  # fmt: skip
    return Verdict(True, "The bench takes it.")


def _voltage(controller, state, y):
    u, _ = controller.step(state, y.copy(), 0.0)
    u = np.atleast_1d(np.asarray(u, dtype=float))
    if u.shape != (1,) or not np.isfinite(u[0]):
        raise ValueError(f"step must return (one finite voltage, next state), found {u}.")
    return float(u[0])


def exercise_2(function, rig=None):
    """The formula of the score, on runs that stand and on one that falls."""
    wrong = not_callable(function)
    if wrong:
        return wrong
    rig = load("double") if rig is None else rig
    tasks = rounds(rig)
    controller = papers(rig)
    fallen = simulate(rig, controller, 8.0, initial=[0.6, 0.3])
    for name, run in (
        ("the first round", play(controller, rig, tasks[0])),
        ("the last round", play(controller, rig, tasks[-1])),
        ("a run that falls", fallen),
    ):
        truth, found = points(run), function(run)
        mistakes = []
        if not run.fell:
            angles = np.sqrt(np.mean(run.angles**2)) / 0.05
            volts = np.sqrt(np.mean(run.u**2))
            mistakes = [
                (50 + 50 / (1 + angles + volts), "Voltages count in units of u_max."),
                (50 + 50 / (1 + angles), "The voltages are missing."),
                (50 + 50 / (1 + np.std(run.angles) / 0.05 + volts / rig.u_max[0]), "RMS, not the "
                 "standard deviation: an angle that is constantly wrong counts too."),
            ]  # fmt: skip
        judged = compare(f"points of {name}", found, truth, mistakes, 1e-6)
        if not judged:
            return judged
    return Verdict(True, "You know what you play for.")


def exercise_3(make, season=1, rig=None):
    """The contest: three points above the paper's controller."""
    wrong = not_callable(make)
    if wrong:
        return wrong
    score = contest(make, rig, season)
    if score.reason:
        return Verdict(False, f"Score 0: {score.reason}")
    needed = contest(papers, rig, season).total + AHEAD
    if score.total < needed:
        falls = f" It falls in {score.falls} of 8 rounds." if score.falls else ""
        worst = int(np.argmin([entry.points for entry in score.rounds]))
        return Verdict(
            False, f"Your score is {score.total:.1f}, {needed:.1f} is asked for.{falls} The worst "
            f"round is number {worst + 1}: look at its run, and at whether angles or volts cost "
            "more there."
        )  # fmt: skip
    return Verdict(True, f"Your score is about {score.total:.0f}.")


def exercise_4(make, season=1, rig=None):
    """Robust: on pendulums that the controller is not told about, in the season after."""
    wrong = not_callable(make)
    if wrong:
        return wrong
    neighbours = [dict(rig=rig, season=season + 1, plant=my_rig(who)) for who in OTHERS]
    mine = [contest(make, **neighbour) for neighbour in neighbours]
    for score in mine:
        if score.reason:
            return Verdict(False, f"On a neighbour's pendulum: {score.reason}")
    theirs = [contest(papers, **neighbour) for neighbour in neighbours]
    falls, allowed = (sum(score.falls for score in scores) for scores in (mine, theirs))
    if falls > allowed:
        return Verdict(
            False, f"On the neighbours' pendulums it falls in {falls} of {8 * len(mine)} rounds, more "
            "often than the paper's controller. How large is your modulus margin with filters, and "
            "what does a hard push do to your voltage?"
        )  # fmt: skip
    ahead = np.mean([m.total for m in mine]) - np.mean([t.total for t in theirs])
    if ahead < AHEAD:
        return Verdict(
            False, f"On the neighbours' pendulums it is {ahead:+.1f} points from the paper's, "
            f"{AHEAD:+.0f} is asked for: what in it knows one pendulum or one season by heart?"
        )  # fmt: skip
    return Verdict(True, "It holds for pendulums and pushes that it had not seen.")
