"""Student, teacher and printed editions, nbgrader's conventions, and the marks they rest on."""

import re

import nbformat
import pytest
from classroom import MARKING, original, write
from refresh_notebooks import ROOT, notebooks

import pendlab as pl
from pendlab.__main__ import main
from pendlab.classroom import checks
from pendlab.classroom import exercises as paper
from pendlab.classroom.editions import stamp, student, teacher
from pendlab.classroom.handout import html, markdown, mathml, prepared

REAL = {path.relative_to(ROOT).as_posix(): path for path in notebooks()}


@pytest.fixture(params=REAL.values(), ids=REAL.keys())
def real(request):
    return nbformat.read(request.param, as_version=4)


def cell(notebook, name):
    return next(cell for cell in notebook.cells if cell.id == name)


def test_student_edition_holds_no_solution():
    edition = student(original())
    text = nbformat.writes(edition)
    for secret in (
        "answer = k * 3",
        "return x * x",
        "friction",
        "two entries",
        "secret",
    ):
        assert secret in nbformat.writes(original()) and secret not in text
    assert cell(edition, "90-ex1-solution").source.splitlines() == [
        "offset = 1.0",
        "# Exercise 90.1: your solution here",
        "answer = ...",
    ]
    assert cell(edition, "90-ex2-solution").source.splitlines()[-1] == "    return ..."
    assert cell(edition, "90-ex3-solution").source == "*Exercise 90.3: your answer here.*"
    assert "jupyter" not in cell(edition, "90-ex1-solution").metadata


def test_student_edition_keeps_and_locks_checks():
    check = cell(student(original()), "90-ex1-check")
    assert check.source == "assert abs(doubled - 12) < 1e-9, 'hint: the gain multiplies'"
    assert check.metadata.editable is False and check.metadata.deletable is False


def test_student_edition_leaves_the_original_alone():
    notebook = original()
    student(notebook), teacher(notebook)
    assert notebook == original()


@pytest.mark.parametrize(
    "source, complaint",
    [
        ("### BEGIN SOLUTION\nx = 1", "BEGIN SOLUTION without END SOLUTION"),
        ("x = 1\n### END SOLUTION", "END SOLUTION without BEGIN SOLUTION"),
        ("### BEGIN SOLUTION\n### BEGIN SOLUTION\n### END SOLUTION", "BEGIN SOLUTION twice"),
        ("### BEGIN HIDDEN TESTS\nassert x", "BEGIN HIDDEN TESTS without"),
    ],
)
def test_marks_without_partner_are_named(source, complaint):
    notebook = original()
    cell(notebook, "90-ex1-solution").source = source
    with pytest.raises(ValueError, match=f"cell 90-ex1-solution: {complaint}"):
        student(notebook)


def test_teacher_edition_adds_notes_and_unfolds():
    edition = teacher(original(), sheet="### Lab sheet\n\nBring a ruler.", marking=MARKING)
    note = cell(edition, "90-ex1-task-teacher").source
    for words in ("5 min", "3 points", "forgets the factor"):
        assert words in note
    note = cell(edition, "90-ex3-task-teacher").source
    for words in (
        "1 point",
        "names the cause",
        "*Full points:* It rubs.",
        "*No points:* It is so.",
    ):
        assert words in note
    overview = edition.cells[0].source
    assert "Bring a ruler." in overview and "| **all** | 5 | 5 |" in overview
    assert "source_hidden" not in nbformat.writes(edition)
    assert "answer = k * 3" in cell(edition, "90-ex1-solution").source
    nbformat.validate(edition)


def test_commands_write_editions(tmp_path, capsys):
    source = write(original(), tmp_path / "notebooks" / "90_small.ipynb")
    write("### Sheet of 90", tmp_path / "notebooks" / "labs" / "90_small.md")
    write(original(), tmp_path / "notebooks" / "homework" / "90_more.ipynb")
    for name in ("student", "teacher", "handout"):
        folder = tmp_path / name
        assert main([name, str(source.parent), "--folder", str(folder)]) == 0
        suffix = ".html" if name == "handout" else ".ipynb"
        assert (folder / f"90_small{suffix}").exists()
        assert (folder / "homework" / f"90_more{suffix}").exists()
    assert "### Sheet of 90" in (tmp_path / "teacher" / "90_small.ipynb").read_text()
    assert "k * 3" not in (tmp_path / "handout" / "90_small.html").read_text()
    assert main(["student", str(source), "--folder", str(source.parent)]) == 2
    assert "written over its original" in capsys.readouterr().err
    assert main(["student", str(tmp_path / "none.ipynb")]) == 2


def test_real_notebook_is_stamped_for_nbgrader(real):
    stamped = nbformat.from_dict(real)
    stamp(stamped)
    assert stamped == real, "run tests/refresh_notebooks.py, which writes nbgrader's metadata"


def test_full_edition_shows_no_verdict_before_the_own_try(real):
    """JupyterLab keeps folded outputs folded until the cell is run."""
    for exercise in paper.exercises(real):
        for name in exercise.solutions + exercise.checks:
            if cell(real, name).cell_type == "code":
                assert cell(real, name).metadata.jupyter.outputs_hidden, name
    assert "_hidden" not in nbformat.writes(teacher(real))


def test_real_formulas_can_be_shown(real):
    for c in real.cells:
        if c.cell_type == "markdown":
            assert outside_requests(markdown(c.source)) == []
    prepared(real)  # turns formulas in outputs into MathML, or says which it cannot


def test_real_notebook_is_printable():
    name, path = next(iter(REAL.items()))
    page = html(student(nbformat.read(path, as_version=4)), path)
    assert outside_requests(page) == [] and page.count("<math") > 3, name


def outside_requests(page):
    """What a browser would fetch: everything but links to follow."""
    fetching = r"""(?:src|data|poster)\s*=\s*["']?(?!data:)[^"'>\s]+|<link\b[^>]*>|@import[^;]+;"""
    return re.findall(fetching + r"|url\((?!['\"]?(?:data:|#))[^)]*\)|<script\b[^>]*>", page)


def test_handout_needs_no_network():
    notebook = original()
    notebook.cells += [
        nbformat.v4.new_markdown_cell(
            "Inline $\\hat{x}_{k+1} = A \\hat x_k$, block\n\n$$\\begin{aligned} a &= b \\\\ c &= d"
            "\\end{aligned}$$\n\n`not $math$` and \\$5",
            id="90-math",
        ),
        nbformat.v4.new_code_cell(
            "expression",
            id="90-latex",
            outputs=[
                nbformat.v4.new_output(
                    "execute_result",
                    data={"text/latex": "$\\displaystyle \\frac{a}{b}$", "text/plain": "a/b"},
                )
            ],
        ),
    ]
    page = html(notebook, ROOT / "notebooks" / "90.ipynb")
    assert outside_requests(page) == []
    assert "<mtable" in page and "<mfrac>" in page and 'display="block"' in page
    assert "not $math$" in page and "\\hat" not in page
    assert page.count("<math ") >= 4


def test_the_network_test_finds_requests():
    for tag in (
        '<script src="https://x.org/a.js"></script>',
        "<link href=//x.org/a.css>",
        "<img src='http://x.org/a.png'>",
        "@import 'a.css';",
    ):
        assert outside_requests(tag)
    assert not outside_requests('<a href="https://x.org">x</a><img src="data:image/png;base64,AA">')


def test_formula_that_cannot_be_shown_is_named():
    with pytest.raises(ValueError, match=r"\\nonsense cannot be shown"):
        mathml(r"a + \nonsense b")


def test_stamp_is_nbgraders_schema(tmp_path):
    notebook = original()
    stamp(notebook)
    solution, check = (
        cell(notebook, n).metadata.nbgrader for n in ("90-ex1-solution", "90-ex1-check")
    )
    assert (solution.grade, solution.solution, solution.locked) == (False, True, False)
    assert (check.grade, check.solution, check.locked, check.points) == (True, False, True, 3)
    written = cell(notebook, "90-ex3-solution").metadata.nbgrader
    assert (written.grade, written.solution, written.points) == (True, True, 1)
    assert "nbgrader" not in cell(notebook, "90-given").metadata


def test_wrong_answer_is_an_error_under_nbgrader(monkeypatch):
    """nbgrader counts errors; without it a wrong answer never raises."""
    first = checks.exercises()[0]
    assert not pl.check(first, None)
    monkeypatch.setenv("NBGRADER_EXECUTION", "autograde")
    with pytest.raises(AssertionError):
        pl.check(first, None)


def test_wide_tables_and_formulas_are_made_smaller_not_cut():
    def table(columns):
        cells = "".join(f"<td>{k / 7:.6f}</td>" for k in range(columns))
        return nbformat.v4.new_code_cell(
            "t",
            id="90-wide",
            outputs=[
                nbformat.v4.new_output(
                    "execute_result", data={"text/html": f"<table><tr>{cells}</tr></table>"}
                )
            ],
        )

    sizes = {}
    for columns in (3, 12, 24):
        notebook = original()
        matrix = r"\begin{bmatrix}" + "&".join(f"{k}.1234" for k in range(columns))
        notebook.cells = [
            table(columns),
            nbformat.v4.new_markdown_cell(f"$${matrix}\\end{{bmatrix}}$$", id="90-matrix"),
        ]
        text = html(notebook, ROOT / "notebooks" / "90.ipynb")
        sizes[columns] = [int(k) for k in re.findall(r'style="font-size: (\d+)%"', text)]
    assert sizes[3] == [] and len(sizes[12]) == len(sizes[24]) == 2
    assert all(wide < narrow < 100 for wide, narrow in zip(sizes[24], sizes[12]))
