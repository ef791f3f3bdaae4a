"""Exercise cells of the notebooks: complete, solved, timed, and not needed by what follows."""

import ast
import json
import re
from functools import partial

import nbformat
import pytest
from refresh_notebooks import ROOT, notebooks

from pendlab.classroom import exercises as paper
from pendlab.classroom.gaps import names

read = partial(nbformat.read, as_version=4)
FOLDERS = ROOT / "notebooks", ROOT / "notebooks" / "own"
NOTEBOOKS = {path.stem: path for folder in FOLDERS for path in sorted(folder.glob("*.ipynb"))}
EVERY = [p for p in notebooks() if p.stem != "extending" and p.parent.name != "own"]
ASKS_FOR_WORDS = re.compile(
    r"\b(predict|explain|why|say (in|what|which)|sentences?|paragraph|compare|would you)\b", re.I
)


@pytest.fixture(params=NOTEBOOKS.values(), ids=NOTEBOOKS.keys())
def notebook(request):
    return read(request.param)


def cell(notebook, name):
    return next(cell for cell in notebook["cells"] if cell["id"] == name)


def test_every_exercise_is_complete(notebook):
    for exercise in paper.exercises(notebook):
        task = cell(notebook, exercise.task)
        minutes = re.search(r"\((\d+) min\)", task["source"].splitlines()[0])
        assert minutes and int(minutes[1]) == exercise.minutes, exercise.name
        assert "exercise" in task["metadata"]["tags"]
        assert exercise.solutions and len(exercise.checks) == 1, exercise.name
        for name in exercise.solutions:
            solution = cell(notebook, name)
            assert len(paper.region(solution["source"])) == 1
            assert "solution" in solution["metadata"]["tags"]
            assert solution["metadata"]["nbgrader"]["solution"]
            if solution["cell_type"] == "code":
                assert solution["metadata"]["jupyter"]["source_hidden"]
            else:  # the answer in words is for the marker's eyes: labs/marking.toml
                assert solution["source"].count("*Your answer here.*") == 1


def test_what_asks_for_words_has_a_cell_for_them(notebook):
    for exercise in paper.exercises(notebook):
        words = ASKS_FOR_WORDS.search(cell(notebook, exercise.task)["source"])
        assert exercise.written or not words, (exercise.name, words)


def test_every_check_shows_a_verdict_and_the_solution_is_right(notebook):
    for exercise in paper.exercises(notebook):
        check = cell(notebook, exercise.checks[0])
        assert "check" in check["metadata"]["tags"]
        last = ast.parse(check["source"]).body[-1]
        assert isinstance(last, ast.Expr) and ast.unparse(last.value.func) == "pl.check"
        asked = last.value.args[0]  # in a notebook of one's own, a function of its own
        assert getattr(asked, "value", exercise.name) == exercise.name
        shown = ["".join(o["data"]["text/plain"]) for o in check["outputs"] if "data" in o]
        assert shown and shown[-1].startswith("Right: "), exercise.name


def test_cells_after_an_exercise_need_no_solution(notebook):
    """A student who skips an exercise can go on."""
    given, gaps = set(), set()
    for code in (c for c in notebook["cells"] if c["cell_type"] == "code"):
        reads, binds = names(code["source"])
        part = paper.PART.fullmatch(code["id"])
        if part and part["role"] == "solution":
            gaps |= binds - given
        elif not part:
            missing = reads & gaps
            assert not missing, f"{code['id']} needs {missing} from a solution"
            given, gaps = given | binds, gaps - binds


def test_points_by_hand_are_taken_out_of_those_an_exercise_has():
    notebooks = (paper.exercises(read(path)) for path in EVERY)
    total = [sum(exercise.points for exercise in tasks) for tasks in notebooks]
    assert total == [6, 18, 16, 18, 23, 25, 20, 18, 19, 22, 19, 24, 16, 26, 24, 22, 25, 24]


@pytest.mark.parametrize("path", EVERY, ids=lambda path: path.stem)
def test_marker_knows_mistakes_criteria_and_samples(path):
    """And no notebook holds a word of it."""
    marking, text = paper.marking(path), path.read_text(encoding="utf-8")
    for exercise in paper.exercises(read(path)):
        notes = marking[exercise.name]
        assert notes["mistakes"]
        words = {"criteria", "full", "half", "none"}
        assert words <= set(notes) if exercise.written else not words & set(notes), exercise.name
        assert len({notes.get(key) for key in ("full", "half", "none")}) in (1, 3)
    for notes in marking.values():
        for said in notes.values():
            for line in [said] if isinstance(said, str) else said:
                assert len(line) < 30 or json.dumps(line)[1:-1] not in text


def test_marking_names_no_exercise_that_is_gone():
    known = {exercise.name for path in EVERY for exercise in paper.exercises(read(path))}
    assert set(paper.marking(EVERY[0])) == known == set(paper.marking(EVERY[-1]))
