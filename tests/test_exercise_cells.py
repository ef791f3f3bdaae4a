"""Exercise cells of the notebooks: complete, solved, timed, and not needed by what follows."""

import ast
import re

import pytest
from refresh_notebooks import ROOT

from pendlab.classroom import exercises as paper

NOTEBOOKS = {path.stem: path for path in sorted((ROOT / "notebooks").glob("*.ipynb"))}


@pytest.fixture(params=NOTEBOOKS.values(), ids=NOTEBOOKS.keys())
def notebook(request):
    return paper.read(request.param)


def cell(notebook, name):
    return next(cell for cell in notebook["cells"] if cell["id"] == name)


def test_every_exercise_is_complete(notebook):
    for exercise in paper.exercises(notebook):
        task = cell(notebook, exercise.task)
        minutes = re.search(r"\((\d+) min\)", task["source"].splitlines()[0])
        assert minutes and int(minutes[1]) == exercise.minutes, exercise.name
        assert exercise.mistakes and exercise.marking, exercise.name
        assert "exercise" in paper.tags(task)
        assert exercise.solutions and len(exercise.checks) == 1, exercise.name
        for name in exercise.solutions:
            solution = cell(notebook, name)
            assert len(paper.region(solution["source"])) == 1
            assert "solution" in paper.tags(solution)
            assert solution["metadata"]["nbgrader"]["solution"]
            if solution["cell_type"] == "code":
                assert solution["metadata"]["jupyter"]["source_hidden"]
            else:  # nbgrader takes written solutions only where they are graded
                assert solution["metadata"]["nbgrader"]["grade"]


def test_every_check_shows_a_verdict_and_the_solution_is_right(notebook):
    for exercise in paper.exercises(notebook):
        check = cell(notebook, exercise.checks[0])
        assert "check" in paper.tags(check)
        last = ast.parse(check["source"]).body[-1]
        assert isinstance(last, ast.Expr) and ast.unparse(last.value.func) == "pl.check"
        assert last.value.args[0].value == exercise.name
        shown = ["".join(o["data"]["text/plain"]) for o in check["outputs"] if "data" in o]
        assert shown and shown[-1].startswith("Right: "), exercise.name


def test_cells_after_an_exercise_need_no_solution(notebook):
    """A student who skips an exercise can go on."""
    given, gaps = set(), set()
    for code in (c for c in notebook["cells"] if c["cell_type"] == "code"):
        tree = ast.parse(code["source"])
        names = paper.bound(tree.body)
        part = paper.PART.fullmatch(code["id"])
        if part and part["role"] == "solution":
            gaps |= names - given
        elif not part:
            missing = paper.used([tree]) & gaps - names
            assert not missing, f"{code['id']} needs {missing} from a solution"
            given, gaps = given | names, gaps - names


def test_title_tells_the_minutes_of_the_exercises(notebook):
    title = notebook["cells"][0]["source"]
    total = sum(exercise.minutes for exercise in paper.exercises(notebook))
    with_and_without = re.search(r"(\d+) minutes with the exercises, (\d+) without", title)
    of_which = re.search(r"of which (\d+) for the exercises", title)
    if with_and_without:  # "about", in tens
        assert abs(int(with_and_without[1]) - int(with_and_without[2]) - total) <= 5
    elif of_which:
        assert int(of_which[1]) == total
    else:
        assert re.search(r"\d+ minutes", title)


def test_start_page_tells_the_minutes_of_every_notebook():
    text = "\n".join(c["source"] for c in paper.read(NOTEBOOKS["00_start_here"])["cells"])
    rows = re.findall(r"^\| \[[^]]+\]\((\w+)\.ipynb\) \|.*\| (\d+) \|$", text, re.M)
    assert len(rows) >= 8
    for stem, minutes in rows:
        title = paper.read(NOTEBOOKS[stem])["cells"][0]["source"]
        assert re.search(r"(\d+) minutes", title)[1] == minutes, stem
