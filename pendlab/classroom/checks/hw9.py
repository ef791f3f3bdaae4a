"""Homework 9: a controller of one's own in the contest on the bench."""

from itertools import chain

import numpy as np

import pendlab as pl

from ..contest import contest, play, points, rounds
from .acceptance import fallen, first_state, remembers_in_self
from .judging import Verdict, all_right, compare, not_callable, verdict

RIG = dict(base="double")
REST = 0.005  # rad
BALANCED, SETTLED = 5.0, 4.0  # s
# Points above the paper's controller, and on other pendulums in the rounds that it survives.
AHEAD, STRANGERS = 6.0, 7.0
OTHERS = ("first neighbour", "second neighbour", "third neighbour")


def papers(rig):
    return pl.paper_design("double").controller


def exercise_1(make, rig):
    """The smallest controller: the interface, a correction, and five seconds on the ideal rig."""
    yield not_callable(make, "your class")
    y = np.array([0.01, -0.02, 0.0])
    yield remembers_in_self(make(rig), np.array([*y[:2], 0.0, 0.0]), y, 1)
    run = pl.simulate(rig, make(rig), BALANCED, initial=pl.bench_start(rig))
    if run.fell:
        late = "sign of u = -F x?" if run.fell_at < 1 else "rates: are they in rad/s?"
        yield f"{fallen(run, 'Without imperfections')} Check the {late}"
    left = np.abs(run.angles[run.t > SETTLED]).max()
    if left > REST:
        yield f"""It stays up, but after {SETTLED:g} s is still {left:.3f} rad away; {REST:g} is
            asked for. Which weights bring back the slow lean of the whole pendulum?"""
    if _never_corrects(make(rig), rig):
        yield """It balances because the model of the ideal rig is perfect: your fourth rate is the
            model's alone. Let the reading of theta2 - theta1 correct it."""
    return "The bench takes it."


def _never_corrects(controller, rig, step=1e-4):
    """Whether the fourth rate follows from the model alone.

    The reading of theta2 - theta1 jumps at the second sample and stays. Without a correction the
    voltages there and after one more sample give away F, and with it the next voltage.
    """
    model, y = pl.sample(pl.linearize(rig), controller.dt), step * np.array([0.0, 1.0, 0.0])
    _, state = controller.step(first_state(controller, np.zeros(4)), 0 * y, 0.0)
    volts = []
    for _ in range(3):
        u, state = controller.step(state, y, 0.0)
        volts.append(np.asarray(u, dtype=float).ravel()[0])
    A, B = model.A[3], model.B[3, 0]
    rate = A[1] * step + B * volts[0]
    after = A[1] * step + A[3] * rate + B * volts[1]
    foretold = volts[0] + (volts[1] - volts[0]) * after / rate
    return bool(np.isclose(volts[2], foretold, rtol=1e-6, atol=0))


def exercise_2(function, rig):
    """The formula of the score, on runs that stand and on one that falls."""
    yield not_callable(function, "your function points(run)")
    tasks, controller = rounds(rig), papers(rig)
    runs = {
        "the first round": play(controller, rig, tasks[0]),
        "the last round": play(controller, rig, tasks[-1]),
        "a run that falls": pl.simulate(rig, controller, 8.0, initial=[0.6, 0.3]),
    }
    for name, run in runs.items():
        yield compare(f"points of {name}", function(run), points(run), _formulas(run), 1e-6)
    return "You know what you play for."


def _formulas(run):
    if run.fell:
        return
    angles, volts = (np.sqrt(np.mean(x**2)) for x in (run.angles, run.u))
    yield 50 + 50 / (1 + angles / 0.05 + volts), "Voltages count in units of u_max."
    yield 50 + 50 / (1 + angles / 0.05), "The voltages are missing."
    constant = "RMS, not the standard deviation: an angle that is constantly wrong counts too."
    yield 50 + 50 / (1 + np.std(run.angles) / 0.05 + volts / run.rig.u_max[0]), constant


def exercise_3(make, season=1, rig=None):
    """The contest: so many points above the paper's controller."""
    yield not_callable(make, "your class")
    score, needed = contest(make, rig, season), contest(papers, rig, season).total + AHEAD
    if score.reason:
        yield f"Score 0: {score.reason}"
    if score.total < needed:
        falls = f" It falls in {score.falls} of 8 rounds." if score.falls else ""
        worst = int(np.argmin([entry.points for entry in score.rounds]))
        yield f"""Your score is {score.total:.1f}, {needed:.1f} is asked for.{falls} The worst round
            is number {worst + 1}: look at its run, and at whether angles or volts cost more
            there."""
    return f"Your score is about {score.total:.0f}."


def exercise_4(make, season=1, least_margin=None, rig=None):
    """Robust: on pendulums that the controller is not told about, in the season after."""
    if not callable(make):
        return Verdict(False, not_callable(make, "your class"))
    parts = _margin(least_margin, make(rig), rig), verdict(_holds_elsewhere(make, season + 1, rig))
    return all_right(*(part for part in parts if part is not None))


def _holds_elsewhere(make, season, rig):
    """Falls no more often than the paper's controller, and is ahead where that one stands."""
    neighbours = [dict(rig=rig, season=season, plant=pl.my_rig(who)) for who in OTHERS]
    mine, theirs = (
        [contest(one, **neighbour) for neighbour in neighbours] for one in (make, papers)
    )
    for score in mine:
        if score.reason:
            yield f"On a neighbour's pendulum: {score.reason}"
    falls, allowed = (sum(score.falls for score in scores) for scores in (mine, theirs))
    if falls > allowed:
        yield f"""On the neighbours' pendulums it falls in {falls} of {8 * len(mine)} rounds, more
            often than the paper's controller. How large is your modulus margin with filters, and
            what does a hard push do to your voltage?"""
    pairs = chain(*(zip(m.rounds, t.rounds) for m, t in zip(mine, theirs)))
    ahead = np.mean([m.points - t.points for m, t in pairs if t.fell_at is None])
    if ahead < STRANGERS:
        yield f"""On the neighbours' pendulums, where the paper's controller stands, yours is
            {ahead:+.1f} points from it, {STRANGERS:+.0f} is asked for: what in it knows one
            pendulum or one season by heart?"""
    return "It holds for pendulums and pushes that it had not seen."


def _margin(answer, controller, rig):
    """A verdict on the modulus margin with filters of the package's controller inside, if any."""
    inside = [
        part for part in (controller, *vars(controller).values()) if isinstance(part, pl.Controller)
    ]
    if not inside:
        return None  # all of it is the student's own: only they know what is linear in it
    if answer is None:
        why = "Your class wraps a controller of the package: least_margin is its modulus margin."
        return Verdict(False, why)
    ideal = pl.linearize(rig)
    real, without = (
        pl.margins(pl.open_loop(inside[0], pl.sample(plant, controller.dt)))
        for plant in (pl.with_filters(ideal, rig.filters), ideal)
    )
    mistakes = [
        (without.modulus, "That is without filters; put them in."),
        (real.gain_up, "That is a gain margin; the modulus margin is the distance from -1."),
    ]
    return compare("least_margin", answer, real.modulus, mistakes, 1e-2)  # two digits
