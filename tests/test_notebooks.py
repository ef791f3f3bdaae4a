"""What nbval cannot see: stripped, unordered, silenced or erroneous notebooks, and their making."""

import re

import nbformat
import pytest
from refresh_notebooks import ROOT, notebooks, settle

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


def test_links_between_notebooks_lead_somewhere():
    for path in NOTEBOOKS.values():
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
