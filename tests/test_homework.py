"""Homework: the pattern of its notebooks, and checks that accept and refuse for the right reason.

A new homework notebook adds its lines to `REFUSED`; all else follows from the files.
"""

import contextlib
import io
import re
from dataclasses import replace
from functools import lru_cache

import nbformat
import numpy as np
import pytest
from refresh_notebooks import ROOT

import pendlab as pl
from pendlab.classroom import exercises as paper
from pendlab.classroom.checks import exercises, hw5, hw6, hw7, hw8

HOMEWORK = {path.name[:2]: path for path in sorted((ROOT / "notebooks/homework").glob("*.ipynb"))}


@pytest.fixture(params=HOMEWORK)
def homework(request):
    return nbformat.read(HOMEWORK[request.param], as_version=4)


def number(homework):
    return homework.cells[0].id.split("-")[0]


# The pattern


def test_says_goal_time_and_theory(homework):
    title = homework.cells[0].source
    for word in ("**Goal**", "**Theory**", "**Time**", "(../00_start_here.ipynb)"):
        assert word in title
    minutes = int(re.search(r"\*\*Time\*\* \| (\d+) minutes", title)[1])
    tasks = paper.exercises(homework)
    assert 60 <= minutes <= 120
    assert 3 <= len(tasks) <= 5
    assert sum(task.minutes for task in tasks) < minutes
    assert tasks[0].minutes == min(task.minutes for task in tasks), "the first is easy"


def test_every_task_has_its_cells_and_notes(homework):
    cells = {cell.id: cell for cell in homework.cells}
    for k, task in enumerate(paper.exercises(homework), 1):
        assert task.name == f"{number(homework)}.{k}"
        assert task.task and task.solutions and len(task.checks) == 1
        assert "exercise" in cells[task.task].metadata.tags
        assert task.points
        for solution in task.solutions:
            assert "solution" in cells[solution].metadata.tags
            assert paper.has_solution(cells[solution])
            if solution not in task.written:
                assert cells[solution].metadata.jupyter.source_hidden
        check = cells[task.checks[0]]
        assert "check" in check.metadata.tags
        assert check.source.splitlines()[-1].startswith(f'pl.check("{task.name}", ')
        assert ", rig=" in check.source.splitlines()[-1]


def test_every_task_has_a_check_and_every_check_a_task(homework):
    ours = [name for name in exercises() if name.startswith(number(homework) + ".")]
    assert [task.name for task in paper.exercises(homework)] == ours


def test_stored_solutions_are_right(homework):
    for cell in homework.cells:
        if "check" in cell.metadata.get("tags", ()):
            assert cell.outputs[-1].data["text/markdown"].startswith("✓ **Right")


def test_solutions_are_right_on_another_rig(homework, who="Anna"):
    """The solutions design; they do not recite: with another name they must still be accepted."""
    code = [cell for cell in homework.cells if cell.cell_type == "code"]
    code = [cell for cell in code if "folded" not in cell.metadata.get("tags", ())]
    named = [cell for cell in code if 'name = "your name"' in cell.source]
    assert len(named) == 1
    named[0].source = named[0].source.replace('"your name"', repr(who))
    names = {"display": lambda *_: None}
    for cell in code:
        with contextlib.redirect_stdout(io.StringIO()):
            if "check" in cell.metadata.get("tags", ()):
                verdict = eval(cell.source, names)
                assert verdict, f"{cell.id}: {verdict.message}"
            else:
                exec(compile(cell.source, cell.id, "exec"), names)


# What is refused, and why


@lru_cache
def start(kp=10.0):
    """The paper's own design on the rig of "your name"."""
    own = pl.paper_design("triple")
    return pl.Design(pl.my_rig("your name", "triple"), own.Q, own.R, own.E, kp)


def unbalanced(kp):
    """Stable without filters, unstable with them."""
    return replace(start(kp), E=(0.9, 0.5), kp=40.0)


def filtered(dt, motors, sensors, kp):
    rig = replace(start().rig, filters=pl.Filters((motors,) * 2, (sensors,) * 4))
    return replace(start(), rig=rig, dt=dt, kp=kp)


def with_weights(**changes):
    """Task of homework 4: the start with other entries of Q."""
    Q = np.array(start(5.0).Q)
    for name, value in changes.items():
        Q[int(name[1:])] = value
    return replace(start(5.0), Q=tuple(Q))


def process_noise(scale):
    B = start(5.0).model.B
    return scale * B @ B.T


class Lazy:
    """Does nothing, at every sample."""

    def step(self, state, y, y_ref):
        return np.zeros(2), state


def own(base="double"):
    return pl.my_rig("your name", base)


def four_links(*ratios):
    """Homework 5: the large motor below, small ones above."""
    motors = [hw5.geared(own("triple").motors[min(i, 1)], ratio) for i, ratio in enumerate(ratios)]
    return hw5.tower(own("triple"), motors, (12.0, 2.5, 2.5)[: len(ratios)])


def four_links_design(E):
    return pl.Design(four_links(120, 120, 68), (0.1,) * 4 + (0.01,) * 5, (1.0,) * 3, E)


def stiff_gear(a):
    return 50.0


def soft_run():
    return hw6.run_with(hw6.reference(None), hw6.soft_gear(None))


def with_bar(R):
    bar = (3, 1.5, 0.1, 0.0)
    rig = hw7.barred(own("triple"), *bar)
    return bar, pl.Design(rig, (1, 1, 1, 0, 0, 0, 0.01), R, (0.9, 0.9))


def attitudes(q):
    weights = (1, 1, 1, 0, 0, 0, q, q)
    return pl.Design(own("triple"), weights, (0.1, 0.1), (0.9, 0.9), tracked=(1, 2))


class Asleep:
    def __init__(self, rig):
        self.motors = rig.n_motors

    def step(self, state, y, y_ref):
        return np.zeros(self.motors), state


class Forgetful(Asleep):
    def step(self, state, y, y_ref):
        self.motors += 1
        return self.motors, state


class Crashing(Asleep):
    def step(self, state, y, y_ref):
        raise RuntimeError("boom")


REFUSED = [
    ("hw1.1", lambda: [0.01, 0.0155, 0.0047], "less than a whole period"),
    ("hw1.2", lambda: lambda f, dt: f % (1 / dt), "half the sampling frequency"),
    ("hw1.2", lambda: lambda f, dt: 0.0, "differ"),
    ("hw1.3", lambda: 0.01, "go on"),
    ("hw1.3", lambda: 0.05, "under 0.25"),
    ("hw1.4", start, "modulus margin at input 2"),
    ("hw1.4", lambda: unbalanced(10.0), "unstable"),
    ("hw1.4", lambda: filtered(0.002, 100, 30, 5.0), "busy"),
    ("hw1.4", lambda: filtered(0.02, 15, 30, 4.0), "looks like a motion"),
    ("hw1.4", lambda: filtered(0.008, 100, 30, 5.0), "staircase"),
    ("hw1.4", lambda: filtered(0.0055, 60, 40, 5.0), "hum"),
    ("hw1.4", lambda: pl.paper_design("double"), "another rig"),
    ("hw1.5", lambda: (start(), 0.05), "The design first"),
    ("hw2.1", lambda: [4, 4], "dimension of the null space"),
    ("hw2.2", lambda: 0.3, "is the limit"),
    ("hw2.2", lambda: 0.9, "faster by 0.02"),
    ("hw2.3", lambda: (start(5.0), start(5.0)), "always agree"),
    ("hw2.4", lambda: start(5.0), "equal"),
    ("hw2.4", lambda: replace(start(5.0), E=(0.9, 0.99)), "wrong for too long"),
    ("hw2.4", lambda: replace(start(5.0), E=(0.9, 0.7)), "modulus margin"),
    ("hw2.4", lambda: replace(start(5.0), E=((0.94, 0.03), (-0.03, 0.94))), "Sensor noise"),
    ("hw2.4", lambda: unbalanced(5.0), "unstable"),
    ("hw3.1", lambda: np.zeros((4, 6)), "shape"),
    ("hw3.2", lambda: start(5.0).controller.system, "u = -P y"),
    ("hw3.2", lambda: -start(5.0).controller.system, "missing among"),
    ("hw3.3", lambda: process_noise(1e4), "less than 10%"),
    ("hw3.3", lambda: -np.eye(6), "covariance"),
    ("hw3.4", lambda: process_noise(1e-5), "unstable"),
    ("hw3.4", lambda: process_noise(1e4), "modulus margin at input 1"),
    ("hw3.5", Lazy, "falls"),
    ("hw3.5", lambda: start(5.0).controller, "Sensor noise"),
    ("hw4.1", lambda: 50072.0, "samples"),
    ("hw4.2", lambda: 0.001, "which power"),
    ("hw4.3", lambda: start(5.0), "time constant"),
    ("hw4.3", lambda: with_weights(q6=100.0), "modulus margin"),
    ("hw4.3", lambda: unbalanced(5.0), "unstable"),
    ("hw4.4", lambda: with_weights(q1=25.0, q6=1.0), "for good after"),
    ("hw4.4", lambda: with_weights(q1=1.0, q6=3.0), "swings out"),
    ("hw5.1", lambda: lambda motor, ratio: replace(motor, ratio=ratio), "energy or power"),
    ("hw5.2", lambda: lambda rig: (np.eye(rig.n_links), np.eye(rig.n_links)), "look again"),
    ("hw5.3", lambda: ([5, 5, 5], 2), "one away per motor"),
    ("hw5.3", lambda: ([4, 3, 2], 3), "one and the same space"),
    ("hw5.4", lambda: four_links(120, 120), "too weak"),
    ("hw5.4", lambda: four_links(120, 120, 300), "to be had"),
    ("hw5.4", lambda: own("triple"), "Links, filters and g"),
    ("hw5.5", lambda: four_links_design((0.7, 0.8, 0.9)), "unstable"),
    ("hw6.1", lambda: stiff_gear, "nothing touches"),
    ("hw6.2", lambda: lambda w: 2 - hw6.at_the_gear(hw6.reference(None), w), "look again"),
    ("hw6.3", lambda: ([29.0, 0.044, 0.054], "stable"), "predicted"),
    ("hw6.3", lambda: (hw6.prediction(hw6.reference(None), 0.028, 50.0), "unstable"), "stiffer"),
    ("hw6.4", lambda: np.array([2, 1]) * hw6.measured(soft_run()), "upward crossings"),
    ("hw6.5", lambda: (hw6.reference(None), 0.0), "teeth"),
    ("hw6.5", lambda: (hw6.reference(None), 0.3), "at most"),
    ("hw7.1", lambda: lambda link, inertia, mass, height: link, "computed from both"),
    ("hw7.2", lambda: (1, 3), "less is better"),
    ("hw7.3", lambda: (3, 0.05), "ratio"),
    ("hw7.3", lambda: (2, 0.2), "does help"),
    ("hw7.4", lambda: [3, 1.0, 0.1, 0.4], "Inertia helps"),
    ("hw7.4", lambda: [3, 3.0, 0.1, 0.0], "at most"),
    ("hw7.5", lambda: with_bar((1, 1)), "falls"),
    ("hw8.1", lambda: ([0, 0.1, -0.1], [0, 0]), "centre of mass"),
    ("hw8.2", lambda: [(0,), (0, 1, 2)], "what gravity decides"),
    ("hw8.2", lambda: [(1,), (1, 3)], "never lets the pendulum rest"),
    ("hw8.2", lambda: [(0,), (1,)], "more of the candidates"),
    ("hw8.3", lambda: attitudes(0.1), "after 3 s"),
    ("hw8.3", start, "integrator"),
    ("hw8.4", lambda: np.cumsum(hw8.bow(own("triple"))), "absolute"),
    ("hw8.5", lambda: (attitudes(10), hw8.wave(0.01 * np.arange(2401))), "come late"),
    ("hw9.1", lambda: Asleep, "falls"),
    ("hw9.1", lambda: Forgetful, "not in self"),
    ("hw9.2", lambda: lambda run: 50 + 50 / (1 + np.std(run.angles)), "points of"),
    ("hw9.3", lambda: Asleep, "falls in 8"),
    ("hw9.3", lambda: Crashing, "boom"),
    ("hw9.4", lambda: Asleep, "more often"),
]


@pytest.mark.parametrize(
    ("name", "make", "reason"), REFUSED, ids=[f"{name}-{reason}" for name, _, reason in REFUSED]
)
def test_refuses_with_a_hint_at_the_shortfall(name, make, reason):
    answer = make()
    verdict = pl.check(name, *(answer if isinstance(answer, tuple) else (answer,)))
    assert not verdict
    assert reason in verdict.message
    assert "cannot be checked" not in verdict.message


def test_something_is_refused_in_every_task():
    tasks = {name for name in exercises() if name.startswith("hw")}
    assert tasks <= {name for name, *_ in REFUSED}
