"""What nbval cannot see: stripped, unordered, silenced or erroneous notebooks, and their making."""

import ast
import builtins
import re

import nbformat
import pytest
from minutes import HEADING, OPTIONAL
from refresh_notebooks import ROOT, notebooks, settle

import pendlab as pl

NOTEBOOKS = {path.relative_to(ROOT).as_posix(): path for path in notebooks()}
FEWEST_CHECKED_OUTPUTS = 8
SILENCERS = {"nbval-ignore-output", "nbval-skip", "raises-exception", "skip-execution"}


@pytest.fixture(params=NOTEBOOKS.values(), ids=NOTEBOOKS.keys())
def notebook(request):
    return nbformat.read(request.param, as_version=4)


def code_cells(notebook):
    return [cell for cell in notebook.cells if cell.cell_type == "code"]


def problems(notebook):
    """Everything that would let nbval pass without comparing, as sentences."""
    found = []
    cells = code_cells(notebook)
    counts = [cell.execution_count for cell in cells]
    if counts != list(range(1, len(cells) + 1)):
        found.append(f"execution counts are {counts}, not 1 to {len(cells)}")
    for cell in cells:
        first = f"cell {cell.id}"
        tags = set(cell.metadata.get("tags", []))
        if tags & SILENCERS:
            found.append(f"{first} is silenced by {tags & SILENCERS}")
        if re.search(r"#\s*(NBVAL_|PYTEST_VALIDATE_IGNORE)", cell.source):
            found.append(f"{first} is silenced by a comment")
        if cell.source.rstrip().endswith(";"):
            found.append(f"{first} ends with a semicolon, which nbval does not obey")
        if "execution" in cell.metadata:
            found.append(f"{first} stores its timing")
        for output in cell.outputs:
            if output.output_type == "error":
                found.append(f"{first} stores the error {output.ename}")
            if output.output_type == "stream" and output.name == "stderr":
                found.append(f"{first} stores a warning")
    if "widgets" in notebook.metadata:
        found.append("stores the state of widgets")
    checked = sum(any(map(is_checked, cell.outputs)) for cell in cells)
    if checked < FEWEST_CHECKED_OUTPUTS:
        found.append(f"only {checked} cells have an output that nbval compares")
    return found


def is_checked(output):
    """Whether nbval compares this output: all but pictures and widget views."""
    if output.output_type == "stream":
        return True
    return any(key.startswith("text/") for key in output.get("data", {}))


def test_notebook_is_stored_as_executed(notebook):
    assert problems(notebook) == []


def test_audit_rejects_what_nbval_accepts(notebook):
    """The audit itself: a stripped, a silenced and an unordered copy are all found out."""
    stripped = nbformat.from_dict(notebook)
    for cell in code_cells(stripped):
        cell.outputs, cell.execution_count = [], None
    assert len(problems(stripped)) == 2
    silenced = nbformat.from_dict(notebook)
    code_cells(silenced)[0].metadata["tags"] = ["nbval-skip"]
    code_cells(silenced)[1].execution_count = 99
    assert len(problems(silenced)) == 2


def test_series_has_every_notebook():
    names = {path.name[:2] for path in NOTEBOOKS.values() if path.parent.name == "notebooks"}
    assert names >= {"02", "03", "04", "A_", "B_"}


@pytest.mark.parametrize("path", NOTEBOOKS.values(), ids=NOTEBOOKS.keys())
def test_links_between_notebooks_lead_somewhere(path):
    text = "\n".join(cell.source for cell in nbformat.read(path, as_version=4).cells)
    for target in re.findall(r"\]\(([^)#:\s]+)(?:#[^)]*)?\)", text):
        if not target.startswith(("http", "attachment")):
            assert (path.parent / target).exists(), f"{path.name} links to {target}"


def test_no_picture_comes_from_the_web(notebook):
    for cell in notebook.cells:
        assert not re.search(r"!\[[^]]*\]\(https?:|<img[^>]+src=.https?:", cell.source)


def test_cell_ids_are_stable_names(notebook):
    ids = [cell.id for cell in notebook.cells]
    assert len(set(ids)) == len(ids)
    assert all(re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_-]{2,63}", name) for name in ids)


def test_settling_leaves_nothing_volatile():
    notebook = nbformat.v4.new_notebook(
        cells=[nbformat.v4.new_code_cell("1 + 1", id="sum", execution_count=7)],
        metadata={"widgets": {"a": 1}, "language_info": {"name": "python", "version": "3.11"}},
    )
    settle(notebook)
    assert "widgets" not in notebook.metadata
    assert notebook.metadata.language_info == {"name": "python"}
    assert notebook.cells[0].execution_count == 1


# What a notebook is written with

# Beside ``pl`` itself: the rounds of the contest, which homework 9 plays by hand.
DOCUMENTED = {"pendlab", "pendlab.classroom.contest"}
LONGEST = 20
# Here the code is the lesson.
MAY_BE_LONG = {"03-S-double", "05-own-step"}


def test_notebooks_use_the_public_package_alone(notebook):
    """No module behind ``pl``, and no name in it that its contents do not list."""
    for cell in code_cells(notebook):
        for node in ast.walk(ast.parse(cell.source)):
            if isinstance(node, ast.ImportFrom) and str(node.module).startswith("pendlab"):
                assert node.module in DOCUMENTED, f"{cell.id} imports from {node.module}"
            if isinstance(node, ast.Import):
                ours = {name.name for name in node.names if name.name.startswith("pendlab")}
                assert ours <= DOCUMENTED, f"{cell.id} imports {ours}"
            if isinstance(node, ast.Attribute) and getattr(node.value, "id", "") == "pl":
                assert node.attr in pl.__all__, f"{cell.id} uses pl.{node.attr}"


def code_lines(source):
    """Lines of code that are not empty; text over several lines, such as a data file, counts once."""
    lines = {number for number, line in enumerate(source.splitlines(), 1) if line.strip()}
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, (ast.Constant, ast.JoinedStr)) and node.end_lineno > node.lineno:
            lines -= set(range(node.lineno + 1, node.end_lineno + 1))
    return len(lines)


def test_no_visible_cell_is_long(notebook):
    for cell in code_cells(notebook):
        folded = cell.metadata.get("jupyter", {}).get("source_hidden")
        if not folded and cell.id not in MAY_BE_LONG:
            assert code_lines(cell.source) <= LONGEST, f"{cell.id} has {code_lines(cell.source)}"


def test_folded_cells_draw_or_solve_and_are_not_long_either(notebook):
    """What is folded is the drawing of one figure or the answer to an exercise."""
    for cell in code_cells(notebook):
        if cell.metadata.get("jupyter", {}).get("source_hidden"):
            assert set(cell.metadata.get("tags", [])) & {"folded", "solution"}, cell.id
            assert code_lines(cell.source) <= LONGEST, f"{cell.id} has {code_lines(cell.source)}"


def test_lines_of_code_are_counted():
    assert code_lines('a = 1\n\nb = """\ntext\nmore\n"""\nc = 2') == 3


# Parts that run alone


def parts(notebook):
    """The sources of the code cells of each part, for a notebook that has parts."""
    found = [[]]
    for cell in notebook.cells:
        if cell.cell_type == "markdown" and re.search(r"(?m)^## Part [2-9]", cell.source):
            found.append([])
        elif cell.cell_type == "code":
            found[-1].append(cell.source)
    return found


def unknown_names(sources):
    """Names that the cells of a part use and no cell of that part makes."""
    nodes = [node for source in sources for node in ast.walk(ast.parse(source))]
    used = {n.id for n in nodes if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Load)}
    made = {n.id for n in nodes if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}
    made |= {n.name for n in nodes if isinstance(n, (ast.FunctionDef, ast.ClassDef))}
    made |= {n.arg for n in nodes if isinstance(n, ast.arg)}
    made |= {n.name for n in nodes if isinstance(n, ast.ExceptHandler) and n.name}
    imports = [n for n in nodes if isinstance(n, (ast.Import, ast.ImportFrom))]
    made |= {(a.asname or a.name).split(".")[0] for n in imports for a in n.names}
    return used - made - set(dir(builtins)) - {"display"}


def test_parts_run_alone(notebook):
    for number, sources in enumerate(parts(notebook), 1):
        assert not unknown_names(sources), f"part {number}"


def main_path(notebook):
    """The code cells outside optional stretches."""
    below = 9
    for cell in notebook.cells:
        if cell.cell_type == "code" and below == 9:
            yield cell
        for marks, heading in HEADING.findall(cell.source if cell.cell_type == "markdown" else ""):
            below = 9 if len(marks) <= below else below
            below = min(below, len(marks)) if OPTIONAL.search(heading) else below


def test_main_path_runs_without_its_optional_stretches(notebook):
    cells = list(main_path(notebook))
    given = [cell.source for cell in cells if "solution" not in cell.metadata.get("tags", [])]
    missing = unknown_names(cell.source for cell in cells)
    assert {name for name in missing if re.search(rf"\b{name}\b", "\n".join(given))} == set()


def test_a_part_that_needs_another_is_found_out():
    assert unknown_names(
        ["import numpy as np", "x = np.pi", "def f(y):\n    return y + x + z"]
    ) == {"z"}
