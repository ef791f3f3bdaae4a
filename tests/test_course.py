"""A real nbgrader course, from `course` to exported grades and feedback, with hostile hand-ins."""

import csv
import json
import os
import re
import socket
import subprocess
import sys
import sysconfig
from pathlib import Path

import nbformat
import pytest
from classroom import write
from nbformat.v4 import new_code_cell, new_markdown_cell, new_notebook
from refresh_notebooks import ROOT, notebooks

from pendlab.__main__ import main
from pendlab.classroom import confined
from pendlab.classroom import exercises as paper
from pendlab.classroom.checks import exercises
from pendlab.classroom.course import counted, course, files, refilled

pytestmark = pytest.mark.skipif(
    not confined.available() and "CI" not in os.environ,
    reason="hand-ins are shut in by bubblewrap, which is on Linux only",
)
STEM = "90_falls"
MARKING = """
["90.1"]
mistakes = ["takes a slow eigenvalue"]

["90.2"]
mistakes = ["counts angles only"]
criteria = ["says why rates belong to it"]
full = "Without the rates nobody knows what comes next."
half = "Angles and rates."
none = "Because."
"""


def solved():
    """Two exercises: two values for three points; a number and an answer in words, a point each."""

    def task(number, **notes):
        notes = {"exercise": f"90.{number}", "minutes": 5, **notes}
        return new_markdown_cell(
            "### Exercise", id=f"90-ex{number}-task", metadata={"pendlab": notes}
        )

    def code(name, source):
        return new_code_cell(source, id=name)

    return new_notebook(
        metadata={
            "kernelspec": {"name": "python3", "display_name": "Python 3", "language": "python"}
        },
        cells=[
            code("90-imports", "import numpy as np\n\nimport pendlab as pl"),
            task(1, points=3),
            code(
                "90-ex1-solution",
                "### BEGIN SOLUTION\ndef fall(name):\n    poles = pl.linearize(pl.load(name)).poles()\n"
                "    return np.log(30) / poles.real.max()\n\n\n"
                "t_double, t_triple = fall('double'), fall('triple')\n### END SOLUTION",
            ),
            code("90-ex1-check", 'pl.check("02.2", t_double, t_triple)'),
            task(2, points=2, by_hand=1),
            code("90-ex2-solution", "### BEGIN SOLUTION\nstates = 6\n### END SOLUTION"),
            code("90-ex2-check", 'pl.check("00.1", states)'),
            new_markdown_cell(
                "Why?\n\n<!-- BEGIN SOLUTION -->\n*Your answer here.*\n<!-- END SOLUTION -->",
                id="90-ex2-solution-why",
            ),
        ],
    )


RIGHT = solved().cells[2].source
WRITES = """
import os, pathlib
for folder in (".", "..", "{course}", "{course}/submitted/good", "{repository}", "/usr", "/root", "/home"):
    try:
        pathlib.Path(folder, "left-behind").write_text("x")
        print("WROTE", folder)
    except OSError:
        pass
"""
READS = """
import glob
for place in (
    "{course}/gradebook.db", "{course}/submitted/good/90_falls/90_falls.ipynb",
    "{course}/source/90_falls/90_falls.ipynb", "{course}/marking/90_falls.md",
    "{repository}/notebooks/labs/marking.toml", "{repository}/.git", "{repository}/README.md",
    "/etc/shadow",
):
    try:
        open(place).close()
        print("SAW", place)
    except FileNotFoundError:
        pass
found = glob.glob("{course}/**", recursive=True) + glob.glob("../../../**", recursive=True)
print("OTHERS", [name for name in found if name.endswith(".ipynb") and "nosy" not in name])
"""
CALLS = """
import socket
try:
    socket.create_connection(("127.0.0.1", {port}), 2)
    print("CALLED")
except OSError:
    pass
"""
# What each puts into exercise 1 before the right answer; the points that nbgrader should give.
HOSTILE = {
    "good": ("", 4),
    "endless": ("while True:\n    pass\n", 1),
    "exits": ("import os\nos._exit(0)\n", 0),
    "nosy": (WRITES + READS + CALLS, 4),
    "flood": ("while True:\n    print('x' * 1000)\n", 1),
    "memory": ("hoard = bytearray(32 << 30)\n", 1),
    "syntax": ("def (:\n", 1),
}
DAMAGED = {
    "renamed": 0,
    "not_json": 0,
    "empty": 0,
    "edited": 1,
    "half": 2.5,  # and its check deleted
    "blank": 0,
}


def hand_in(folder, student, released, said=""):
    """A student's notebook with the right answers; `said` comes first in exercise 1."""
    notebook = nbformat.read(released, as_version=4)
    cells = {cell.id: cell for cell in notebook.cells}
    cells["90-ex1-solution"].source = said + RIGHT
    cells["90-ex2-solution"].source = "states = 6"
    if student == "good":
        cells["90-ex2-solution-why"].source = "Because of the rates."
    path = folder / "submitted" / student / STEM / f"{STEM}.ipynb"
    if student == "half":
        cells["90-ex1-solution"].source += "\nt_triple = 1"
        notebook.cells.remove(cells["90-ex1-check"])
    elif student == "blank":
        notebook = nbformat.read(released, as_version=4)
    elif student == "edited":
        cells["90-ex1-solution"].source, cells["90-ex1-check"].source = "t_double = 0", "3"
    elif student == "renamed":
        path = path.with_name("my falls.ipynb")
    write({"not_json": "cells, cells, cells", "empty": ""}.get(student, notebook), path)


def nbgrader(folder, *arguments):
    """(code, what it said), in an environment that is not activated and without own settings."""
    scripts = Path(sysconfig.get_path("scripts"))
    path = [place for place in os.environ["PATH"].split(os.pathsep) if Path(place) != scripts]
    settings = (f"JUPYTER_{kind}_DIR" for kind in ("CONFIG", "DATA", "RUNTIME"))
    own = dict.fromkeys(settings, str(folder.parent / "own")) | {"PATH": os.pathsep.join(path)}
    line = [sys.executable, "-m", "nbgrader", *arguments]
    how = dict(cwd=folder, env=os.environ | own, capture_output=True, text=True, timeout=900)
    done = subprocess.run(line, check=False, **how)
    return done.returncode, done.stdout + done.stderr


@pytest.fixture(scope="module")
def graded(tmp_path_factory):
    """A course after autograding, feedback and export: its folder and what nbgrader said."""
    home = tmp_path_factory.mktemp("class")
    write(solved(), home / "notebooks" / f"{STEM}.ipynb")
    write(MARKING, home / "notebooks" / "labs" / "marking.toml")
    folder = home / "course"
    assert main(["course", str(folder), "--confined", "--notebooks", str(home / "notebooks")]) == 0
    with (folder / "nbgrader_config.py").open("a", encoding="utf-8") as config:
        config.write("c.Execute.timeout = 60\n")
    code, text = nbgrader(folder, "generate_assignment", STEM)
    assert code == 0, text[-3000:]
    said = [(code, text)]
    released = folder / "release" / STEM / f"{STEM}.ipynb"
    with socket.create_server(("127.0.0.1", 0)) as server:
        places = {"course": folder, "repository": ROOT, "port": server.getsockname()[1]}
        for student, (text, _) in HOSTILE.items():
            for name, place in places.items():
                text = text.replace(f"{{{name}}}", str(place))
            hand_in(folder, student, released, text)
        for student in DAMAGED:
            hand_in(folder, student, released)
        said.append(nbgrader(folder, "autograde", STEM))
    said += [nbgrader(folder, "generate_feedback", STEM), nbgrader(folder, "export")]
    return folder, said


def test_release_runs_to_its_end_and_holds_no_answer(graded):
    folder, _ = graded
    released = (folder / "release" / STEM / f"{STEM}.ipynb").read_text(encoding="utf-8")
    for secret in ("poles", "states = 6", "Without the rates", "says why", "slow eigenvalue"):
        assert secret not in released
    assert "t_double = ..." in released and "states = ..." in released


def test_every_hand_in_costs_itself_only(graded):
    folder, said = graded
    with (folder / "grades.csv").open(encoding="utf-8") as table:
        grades = {row["student_id"]: float(row["score"]) for row in csv.DictReader(table)}
    expected = {name: points for name, (_, points) in HOSTILE.items()} | DAMAGED
    assert grades == expected, said[1][1][-3000:]
    assert "treating other output as full credit" not in said[1][1]


def test_failures_are_named(graded):
    _, said = graded
    code, text = said[1]
    named = set(re.findall(r"error processing assignment '.*' for student '(\w+)'", text))
    assert code != 0 and named == {"exits", "renamed", "not_json", "empty"}


def test_nothing_was_written_read_or_called(graded):
    folder, _ = graded
    assert not list(folder.rglob("left-behind")) and not list(ROOT.glob("left-behind"))
    (page,) = (folder / "autograded" / "nosy").rglob("*.ipynb")
    cells = nbformat.read(page, as_version=4).cells
    printed = "".join(o.get("text", "") for c in cells for o in c.get("outputs", ()))
    for word in ("WROTE", "SAW", "CALLED"):
        assert word not in printed, printed
    assert "OTHERS []" in printed


def test_feedback_shows_marks_and_hints(graded):
    folder, said = graded
    assert said[2][0] == said[3][0] == 0
    pages = {page.parts[-3]: page for page in (folder / "feedback").rglob("*.html")}
    assert set(pages) == (set(HOSTILE) | set(DAMAGED)) - {"exits", "renamed", "not_json", "empty"}
    assert "Not yet: t_triple" in pages["half"].read_text(encoding="utf-8")


def test_answers_in_words_wait_for_the_marker(graded):
    from nbgrader.api import Gradebook

    folder, _ = graded
    with Gradebook(f"sqlite:///{folder / 'gradebook.db'}") as gradebook:
        (part,) = gradebook.find_submission(STEM, "good").notebooks
        (waiting,) = (grade for grade in part.grades if grade.needs_manual_grade)
        assert (waiting.name, waiting.max_score) == ("90-ex2-solution-why", 1)
        waiting.manual_score = 0.5
        gradebook.db.commit()
        assert part.score == 4.5
        (blank,) = gradebook.find_submission(STEM, "blank").notebooks
        assert not any(grade.needs_manual_grade for grade in blank.grades)
    assert "*Full points:* Without the rates" in (folder / "marking" / f"{STEM}.md").read_text()


# ---- The layout


def test_layout_is_idempotent_and_leaves_changes_alone(tmp_path, capsys):
    write(solved(), tmp_path / "notebooks" / f"{STEM}.ipynb")
    where = [tmp_path / "notebooks"]
    written, kept = course(where, tmp_path / "course")
    assert len(written) == 4 and not kept
    assert course(where, tmp_path / "course") == ([], [])
    config = tmp_path / "course" / "nbgrader_config.py"
    config.write_text("mine", encoding="utf-8")
    assert course(where, tmp_path / "course") == ([], [config])
    changed = solved()
    changed.cells[0].source += "\nimport math"
    write(changed, where[0] / f"{STEM}.ipynb")
    assert main(["course", str(tmp_path / "course"), "--notebooks", str(where[0])]) == 1
    assert "left alone, as it was changed" in capsys.readouterr().err
    assert config.read_text(encoding="utf-8") == "mine"
    assert "import math" in next((tmp_path / "course" / "source").rglob("*.ipynb")).read_text()


def test_course_says_what_unconfined_means(tmp_path, monkeypatch):
    write(solved(), path := tmp_path / f"{STEM}.ipynb")
    assert "run as you" in files([path])["README.md"]
    monkeypatch.setattr(confined, "available", bool)  # false
    readme = files([path], confined=True)["README.md"]
    assert "no working bubblewrap" in readme and "run as you" in readme
    assert "confined" not in files([path], confined=True)["nbgrader_config.py"]


def test_series_makes_a_course_with_all_its_points():
    """Every notebook with exercises; stamps agree with what the check cells count."""
    from nbgrader.nbgraderformat import MetadataValidator

    made = files(notebooks())
    sources = {name: text for name, text in made.items() if name.endswith(".ipynb")}
    series = [path for path in notebooks() if path.stem != "template"]
    tasks = [paper.exercises(nbformat.read(path, as_version=4)) for path in series]
    given = [exercise for each in tasks for exercise in each]
    assert len(sources) == sum(map(bool, tasks)) and {e.name for e in given} == set(exercises())
    total = 0
    for text in sources.values():
        notebook = nbformat.reads(text, as_version=4)
        MetadataValidator().validate_nb(notebook)
        for cell in notebook.cells:
            points = cell.metadata.get("nbgrader", {}).get("points", 0)
            total += points
            if re.fullmatch(r".+-ex\d+-check", cell.id):
                assert cell.source.rstrip().endswith(f", points={points:g})")
            elif points:
                assert "*Your answer here.*" not in cell.source
            assert "source_hidden" not in json.dumps(cell.metadata)
    assert total == sum(exercise.points for exercise in given)


def test_gap_stands_where_the_solution_does_not_undo_it():
    top = "a = 1\n### BEGIN SOLUTION\nb = a\n### END SOLUTION\nb"
    assert refilled(top, "a = 1\n# Exercise: yours\nb = ...\nb").splitlines()[1:3] == [
        "b = ...",
        "### BEGIN SOLUTION",
    ]
    inside = "def f(x):\n    ### BEGIN SOLUTION\n    return x\n    ### END SOLUTION"
    assert (
        refilled(inside, "def f(x):\n    # yours\n    return ...").splitlines()[-1]
        == "    return ..."
    )


def test_only_checks_are_told_their_points():
    assert counted('pl.check("00.1", x)\n', 1.5) == 'pl.check("00.1", x, points=1.5)'
    for text in ("assert f(2) == 4", "print(x)", "In words (so)", 'pl.check("00.1", x)\nx'):
        assert counted(text, 2) == text


def test_course_without_exercises_is_refused(tmp_path):
    write(new_notebook(), path := tmp_path / "none.ipynb")
    with pytest.raises(ValueError, match="none of them has an exercise"):
        course([path], tmp_path / "course")


def test_mark_says_what_took_its_place(capsys):
    assert main(["mark", "submitted", "--folder", "x"]) == 2
    said = capsys.readouterr().err
    assert "python -m pendlab course DIR" in said and said.count("\n") == 1
