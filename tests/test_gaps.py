"""Gaps of the student edition: how they are written, and that Run All reaches the end with them."""

import re

import nbformat
import pytest
from classroom import original
from IPython.core.interactiveshell import InteractiveShell
from nbclient import NotebookClient
from nbformat.v4 import new_code_cell
from refresh_notebooks import ROOT, notebooks

import pendlab as pl
from pendlab.classroom import exercises as paper
from pendlab.classroom import gaps
from pendlab.classroom.editions import student

REAL = {path.relative_to(ROOT).as_posix(): path for path in notebooks()}


def code(source):
    return {"cell_type": "code", "source": source}


def printed(cell):
    return "".join(
        o.get("text") or o.get("data", {}).get("text/plain", "") for o in cell.get("outputs", ())
    )


@pytest.mark.parametrize(
    "solution, stub",
    [
        ("x = 1", "x = ..."),
        ("y = 1\nx, (z, *rest) = f(y)", "x = ...\nz = ..."),
        ("import numpy as x\nhelper = 2", "..."),
        ("def x(a, b=2):\n    c = 1\n    return c", "def x(a, b=2):\n    return ..."),
        ("class x:\n    z = 1", "x = ..."),
        ("for x in [z for z in range(3)]:\n    x += 1", "x = ..."),
        ("x = 1\nx = 2\nx += 1", "x = ..."),
        ("z.append(1)\nz[0] = 2", "..."),
    ],
)
def test_stub_names_what_is_asked_for(solution, stub):
    source = f"### BEGIN SOLUTION\n{solution}\n### END SOLUTION"
    made = gaps.gap(code(source), "90.1", {"x", "z"})
    assert made == f"# Exercise 90.1: your solution here\n{stub}"


def test_asked_for_is_what_given_cells_read_and_tasks_name():
    assert gaps.asked(original()) >= {"answer", "square"}


def test_only_a_function_that_returns_it_is_a_gap():
    def gap(a, b=1):
        """Told."""
        return ...

    def slices(a):
        return a[..., 0]

    assert gaps.unanswered(gap) and gaps.unanswered([1, ...])
    assert not any(map(gaps.unanswered, (slices, len, 0.0, None, "...", pl.check)))


# ---- Running


@pytest.fixture
def run(monkeypatch, capsys):
    """Run cells in one shell with gaps; gives what each prints, and fails on a traceback."""
    shell = InteractiveShell()
    monkeypatch.setattr("builtins.get_ipython", lambda: shell, raising=False)
    monkeypatch.delenv("NBGRADER_EXECUTION", raising=False)
    gaps.skip_unanswered()
    gaps.skip_unanswered()  # twice changes nothing
    assert len([t for t in shell.ast_transformers if isinstance(t, gaps._Waiting)]) == 1

    def cell(source):
        result = shell.run_cell(source)
        assert result.success, result.error_in_exec or result.error_before_exec
        return capsys.readouterr().out.strip()

    return cell


def test_cells_wait_for_what_they_need_and_for_nothing_else(run):
    run("rig = 2\nanswer = ...\ndef square(x):\n    return ...")
    assert "`answer`" in run("twice = 2 * answer\nprint('given', rig)")
    assert run("print(rig)") == "2"
    assert run("later = twice + 1") == "Not run yet: this needs your `answer`."
    assert "`answer` and `square`" in run("square(answer)")
    assert run("def tell():\n    return answer") == "Not run yet: this needs your `answer`."
    assert run("[answer for answer in (1, 2)]").endswith("[1, 2]")
    assert run("f = lambda answer: answer\nf(3)").endswith("3")


def test_a_filled_gap_is_used_at_once(run):
    run("answer = ...")
    run("twice = 2 * answer")
    run("answer = 3")
    run("twice = 2 * answer")
    assert run("print(twice)") == "6"
    assert run("answer = ...\nanswer = 4\nprint(answer)") == "4"
    run("def f(n):\n    return ...")
    run("def f(n):\n    return 1 if n == 0 else n * f(n - 1)")
    assert run("print(f(4))") == "24"


def test_functions_that_read_a_gap_wait_too(run):
    run("def tell():\n    return 1 + answer\ndef retell():\n    return tell()")
    run("answer = ...")
    assert run("retell()") == "Not run yet: this needs your `answer`."
    run("answer = 1")
    assert run("print(retell())") == "2"


def test_check_is_asked_and_mistakes_of_the_student_are_shown(run, capsys):
    run("import pendlab as pl\nstates = ...")
    assert "Not answered yet" in run("pl.check('00.1', states)")
    with pytest.raises(AssertionError):
        run("stats + 1")


def test_nbgrader_marks_without_it(monkeypatch):
    shell = InteractiveShell()
    monkeypatch.setattr("builtins.get_ipython", lambda: shell, raising=False)
    monkeypatch.setenv("NBGRADER_EXECUTION", "autograde")
    gaps.skip_unanswered()
    assert not shell.ast_transformers


def touched(notebook):
    """Cells of the student's edition that a gap or a check reaches, and those that they need."""
    gapped = {cell.id for cell in notebook.cells if paper.has_solution(cell)}
    cells = [cell for cell in student(notebook).cells if cell.cell_type == "code"]
    waiting, found, wanted = set(), set(), set()
    for cell in cells:
        reads, binds = gaps.names(cell.source)
        if cell.id in gapped or "-check" in cell.id or reads & waiting:
            found.add(cell.id)
            waiting |= binds
    for cell in reversed(cells):
        reads, binds = gaps.names(cell.source)
        if cell.id in found or binds & wanted:
            found.add(cell.id)
            wanted = wanted - binds | reads
    return [cell for cell in cells if cell.id in found]


def test_touched_cells_are_those_that_a_gap_reaches_and_what_they_read():
    notebook = original()
    notebook.cells.insert(2, new_code_cell("unread = 1", id="90-unread"))
    notebook.cells.append(new_code_cell("print(k)", id="90-last"))
    solutions = {"ex1-solution", "ex1-check", "ex2-solution", "ex2-check"}
    assert {cell.id[3:] for cell in touched(notebook)} == {"given", "between"} | solutions


@pytest.mark.parametrize("path", REAL.values(), ids=REAL.keys())
def test_released_notebook_runs_to_its_end(run, monkeypatch, path):
    """As a student's first Run All: no error, each check says in one line that it has no answer.

    Cells that no gap reaches do what they do in the solved notebook, which is run as it stands.
    """
    monkeypatch.chdir(path.parent)
    for cell in touched(nbformat.read(path, as_version=4)):
        said = run(cell.source)
        if "pl.check(" in cell.source and "-check" in cell.id:
            assert re.fullmatch(r"(Out\[\d+\]: )?Not answered yet: .+", said), cell.id


def test_released_notebook_runs_to_its_end_in_a_kernel():
    path = ROOT / "notebooks" / "00_start_here.ipynb"
    edition = student(nbformat.read(path, as_version=4))
    folder = {"metadata": {"path": str(path.parent)}}
    NotebookClient(edition, timeout=300, kernel_name="python3", resources=folder).execute()
    checks = [cell for cell in edition.cells if cell.id.endswith("-check")]
    assert checks and all(printed(cell).startswith("Not answered yet: ") for cell in checks)
