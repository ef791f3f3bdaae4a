"""Homework: the pattern of its notebooks, and checks that accept and refuse for the right reason.

What is refused, and why, stands in cases/plausible_answers.py; all else follows from the files.
"""

import contextlib
import io
import re

import nbformat
import pytest
from refresh_notebooks import ROOT

from pendlab.classroom import exercises as paper
from pendlab.classroom.checks import exercises

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
    minutes = int(re.search(r"\*\*Time\*\* (\d+) minutes", title)[1])
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
