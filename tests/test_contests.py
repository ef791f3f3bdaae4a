"""The contest on the bench: fixed, bounded, and fair to what crashes."""

import json

import numpy as np
import pytest

import pendlab as pl
from pendlab.classroom.contest import HEIGHTS, SECONDS, play, points, rounds


def papers(rig):
    return pl.paper_design("double").controller


class Sleeper:
    dt = 0.01

    def __init__(self, rig):
        self.motors = rig.n_motors

    def step(self, state, y, y_ref):
        return np.zeros(self.motors), state


class Sulker(Sleeper):
    def step(self, state, y, y_ref):
        raise RuntimeError("no more")


class Counter(Sleeper):
    """Keeps its own count: only a fresh one in each round repeats itself."""

    def __init__(self, rig):
        super().__init__(rig)
        self.samples = 0

    def step(self, state, y, y_ref):
        self.samples += 1
        return np.full(self.motors, 1e-3 * self.samples), state


def test_equal_calls_give_equal_scores_and_seasons_differ():
    first, again = pl.contest(papers), pl.contest(papers)
    assert first == again
    assert first.total == np.mean([r.points for r in first.rounds])
    assert len(first.rounds) == len(HEIGHTS)
    assert first.falls == 0
    assert pl.contest(papers, season=2).total != first.total
    assert pl.contest(Counter) == pl.contest(Counter)


def test_points_are_the_formula_in_the_text():
    rig = pl.load("double")
    run = play(papers(rig), rig, rounds(rig)[3])
    angles = np.sqrt((run.angles**2).sum() / run.angles.size)
    volts = np.sqrt((run.u**2).sum() / run.u.size) / 9.0
    assert points(run) == pytest.approx(50 + 50 / (1 + angles / 0.05 + volts))
    fall = play(Sleeper(rig), rig, rounds(rig)[3])
    assert points(fall) == pytest.approx(20 * fall.fell_at / SECONDS)


def test_falling_is_worth_less_than_staying_up():
    score = pl.contest(Sleeper)
    assert score.falls == len(HEIGHTS)
    assert 0 < score.total < 20


def test_a_crash_scores_zero_with_the_reason():
    score = pl.contest(Sulker)
    assert score.total == 0
    assert "round 1" in score.reason
    assert "no more" in score.reason
    assert pl.contest(lambda rig: None).total == 0


def test_the_controller_is_told_one_rig_and_meets_another():
    told = []

    def make(rig):
        told.append(rig)
        return papers(rig)

    plant = pl.my_rig("somebody else")
    score = pl.contest(make, plant=plant)
    assert set(told) == {pl.load("double")}
    assert score.total != pl.contest(papers).total


def test_pushes_grow_and_the_gap_is_the_benchs_at_most():
    for season in range(5):
        tasks = rounds(pl.load("triple"), season)
        heights = [abs(task.push.height) for task in tasks]
        assert heights[-1] > heights[0]
        assert {task.imperfections.gap[0] for task in tasks} == {
            0.0, 0.02, pl.bench_imperfections(pl.load("triple")).gap[0]
        }  # fmt: skip


def test_leaderboard_file(tmp_path, monkeypatch):
    score = pl.contest(papers)
    pl.write_leaderboard(tmp_path / "leaderboard.json", "Ada", score, season=1)
    claim = json.loads((tmp_path / "leaderboard.json").read_text())
    assert claim["name"] == "Ada"
    assert claim["score"] == pytest.approx(score.total, abs=1e-4)
    assert np.mean(claim["rounds"]) == pytest.approx(claim["score"], abs=1e-3)
    monkeypatch.setenv("NBGRADER_EXECUTION", "autograde")  # what was handed in stays
    pl.write_leaderboard(tmp_path / "leaderboard.json", "Grace", score)
    assert json.loads((tmp_path / "leaderboard.json").read_text()) == claim


def test_bad_input():
    with pytest.raises(TypeError, match="make: expected the class"):
        pl.contest(3)
    with pytest.raises(ValueError, match="season"):
        pl.contest(papers, season=-1)
    with pytest.raises(TypeError, match="score: expected what"):
        pl.write_leaderboard("x.json", "Ada", 99.0)
