"""A contest between controllers on the bench: the same pushes, noise and backlash for everyone.

Each of eight rounds of 8 s starts as Figs 15 and 16 do, with the bench's imperfections
(`bench_imperfections`), sensor noise and one push; pushes grow from round to round, and the backlash
is none, small and the bench's own in turn. A round is worth

    20 t_f / T           if the pendulum falls at t_f, with T = 8 s
    50 + 50 / (1 + J)    if it stays up, J = rms(angles) / 0.05 rad + rms(u / u_max),

rms over all samples, relative angles and motors, and the score is the mean of the rounds: from 0 to
100. The same season gives the same rounds on every machine, and one machine always the same score.
Between machines scores may differ by some tenths: motion in a gap is chaotic, and processors round
differently. A leaderboard is recomputed on one machine.
"""

import json
import os
from dataclasses import dataclass, replace

import numpy as np

from .._arguments import found, instance, number, text, whole
from ..bench import arguments
from ..bench.gearbox import bench_imperfections, bench_rig, bench_start
from ..bench.imperfections import Imperfections, Pulse
from ..bench.simulation import simulate
from ..parameters import Pendulum, load
from .own_rig import fractions

SECONDS = 8.0
ANGLE = 0.05  # rad
NOISE, RATE_NOISE = 3e-4, 3e-3  # standard deviations, rad and rad/s
SMALL_GAP = 0.02  # rad
HEIGHTS = (0.05, 0.08, 0.1, 0.12, 0.15, 0.18, 0.2, 0.22)  # N m, for 0.1 s


@dataclass(frozen=True)
class Round:
    """What awaits a controller in one round, and what it made of it.

    Attributes
    ----------
    push : Pulse
    imperfections : Imperfections
    points : 0 to 100
    fell_at : s, or None
    """

    push: Pulse
    imperfections: Imperfections
    points: float | None = None
    fell_at: float | None = None


@dataclass(frozen=True)
class Score:
    """Result of a contest.

    Attributes
    ----------
    total : mean of the rounds' points, 0 to 100
    rounds : tuple of Round, those played
    reason : sentence on why the total is 0, or None
    """

    total: float
    rounds: tuple
    reason: str | None = None

    @property
    def falls(self):
        return sum(round.fell_at is not None for round in self.rounds)

    def __str__(self):
        if self.reason:
            return f"score 0: {self.reason}"
        lines = [
            f"round {k}: {1000 * r.push.height:+5.0f} mN m on link {r.push.link}, "
            f"gap {1000 * r.imperfections.each('gap', 1)[0]:2.0f} mrad: {r.points:5.2f}"
            + ("" if r.fell_at is None else f" (fell at {r.fell_at:.2f} s)")
            for k, r in enumerate(self.rounds, 1)
        ]
        return "\n".join([*lines, f"score {self.total:.2f}"])


def contest(make, rig=None, season=1, plant=None):
    """Score a controller on the bench; the module's text has the formula.

    Parameters
    ----------
    make : class of the controller, or any function: ``make(rig)`` gives a fresh controller, as
        `simulate` takes it, for each round
    rig : Pendulum that the controller is told to be for; default the paper's double
    season : whole number from which times, signs, heights and noise follow
    plant : Pendulum that is simulated, where it differs from `rig`

    Returns
    -------
    Score : a controller that crashes or answers nonsense scores 0, with the reason

    >>> from pendlab import paper_design
    >>> contest(lambda rig: paper_design("double").controller).falls
    0
    """
    arguments.function(
        "make", make, "the class of your controller, or a function of the rig that gives one"
    )
    rig = instance("rig", load("double") if rig is None else rig, Pendulum, 'pl.load("double")')
    plant = instance("plant", rig if plant is None else plant, Pendulum, 'pl.load("double")')
    played = []
    for count, task in enumerate(rounds(plant, season), 1):
        try:
            run = play(make(rig), plant, task)
        except Exception as problem:  # whatever a controller does is its own affair
            return Score(0.0, tuple(played), f"round {count}: {type(problem).__name__}: {problem}")
        played.append(replace(task, points=points(run), fell_at=run.fell_at))
    return Score(float(np.mean([round.points for round in played])), tuple(played))


def rounds(rig, season=1):
    """The eight rounds of a season, not yet played."""
    fraction = fractions(whole("season", season)).__next__
    bench = bench_imperfections(rig)
    own = bench.each("gap", rig.n_motors)
    noise = (NOISE,) * rig.n_links + (RATE_NOISE,)
    made = []
    for k, height in enumerate(HEIGHTS):
        gap = tuple(float(g) for g in (0 * own, np.minimum(own, SMALL_GAP), own)[k % 3])
        link = 1 + int(fraction() * rig.n_links)
        sign = 1 if fraction() < 0.5 else -1
        push = Pulse(link, round(1 + fraction(), 3), 0.1, sign * height * (0.9 + 0.2 * fraction()))
        seed = int(fraction() * 2**31)
        made.append(Round(push, replace(bench, gap=gap, noise=noise, seed=seed)))
    return tuple(made)


def play(controller, rig, task):
    """The `Run` of one round."""
    return simulate(
        bench_rig(rig),
        controller,
        SECONDS,
        initial=bench_start(rig),
        imperfections=task.imperfections,
        disturbance=task.push,
    )


def points(run):
    """Points of one round, 0 to 100."""
    if run.fell:
        return 20 * run.fell_at / SECONDS
    angles = np.sqrt(np.mean(run.angles**2)) / ANGLE
    volts = np.sqrt(np.mean((run.u / np.array(run.rig.u_max)) ** 2))
    return float(50 + 50 / (1 + angles + volts))


def write_leaderboard(path, name, score, season=1):
    """Write the claim that a teacher collects: name, season, score and points of the rounds.

    ``python -m pendlab leaderboard`` plays the contest again and shows the claim beside the score.
    Where nbgrader marks, the file stays as it was handed in.
    """
    path = arguments.path("path", path)
    if not isinstance(score, Score):
        raise TypeError(f"score: expected what pl.contest returned, {found(score)}.")
    claim = {
        "name": text("name", name),
        "season": whole("season", season),
        "score": round(number("score.total", score.total), 4),
        "rounds": [round(entry.points, 4) for entry in score.rounds],
        "reason": score.reason,
    }
    if "NBGRADER_EXECUTION" in os.environ:
        return
    try:
        path.write_text(json.dumps(claim, indent=1) + "\n", encoding="utf-8")
    except OSError as problem:
        raise ValueError(f"path: {str(path)!r} cannot be written ({problem.strerror}).") from None
