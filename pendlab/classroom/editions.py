"""Editions of a solved notebook: for students, for teachers, and on paper.

The commands ``student``, ``teacher`` and ``handout`` (`release`) write them, and ``course`` starts
from them. `stamp` writes nbgrader's metadata, so that it can take the notebooks as they are.
"""

import copy
import re

from . import exercises as paper
from . import gaps

NBGRADER_SCHEMA = 3
NOTES = {
    "mistakes": "Common mistakes",
    "criteria": "What earns the points",
    "full": "Full points",
    "half": "Half of them",
    "none": "No points",
}
TOLD = {"exercise", "minutes", "points", "by_hand"}  # what students may read in a task's metadata
START, WAIT = "import pendlab as pl", "pl.skip_unanswered()  # cells that need an open answer wait"


def student(notebook):
    """A copy with gaps in place of solutions, without hidden tests, outputs and marking notes.

    It runs to its end (`gaps.skip_unanswered`), and each gap says which exercise it is. Raises
    ValueError naming the cell whose markers do not match.
    """
    edition = without_results(without_solutions(notebook))
    edition["metadata"]["pendlab"] = {"edition": "student"}
    start = next((c for c in edition["cells"] if START in c["source"].splitlines()), None)
    if start and paper.exercises(edition):
        start["source"] = start["source"].replace(START, f"{START}\n{WAIT}", 1)
    return edition


def without_results(notebook):
    """A copy whose cells show nothing, as before they ran."""
    edition = copy.deepcopy(notebook)
    for cell in edition["cells"]:
        if cell["cell_type"] == "code":
            cell["outputs"], cell["execution_count"] = [], None
    return edition


def teacher(notebook, sheet=None, marking=None):
    """A copy with solutions in sight, notes after each task, and the lab sheet's text on top.

    `marking` is what `exercises.marking` reads for the marker: mistakes, criteria, sample answers.
    """
    marking = marking or {}
    edition = copy.deepcopy(notebook)
    exercises = paper.exercises(edition)
    notes = {exercise.task: exercise for exercise in exercises if exercise.task}
    cells = [_markdown("teacher-overview", _overview(exercises, sheet))]
    for cell in edition["cells"]:
        _show(cell)
        cells.append(cell)
        if exercise := notes.get(cell["id"]):
            lines = [f"**For the teacher. {exercise}.**", *told(marking.get(exercise.name, {}))]
            quoted = "\n".join(f"> {line}".rstrip() for line in lines)
            cells.append(_markdown(f"{cell['id']}-teacher", quoted))
    edition["cells"] = cells
    return edition


def stamp(notebook):
    """Write nbgrader's metadata on exercise cells, from their ids and the tasks' points.

    Solution cells are to be filled in, written ones carry the points given by hand; check cells
    are locked and carry the others (shared equally where an exercise has several cells of a kind).
    What they show is folded: a reader of the full edition sees no answer before the own try.
    Any other stamp is removed.
    """
    for cell in notebook["cells"]:
        cell["metadata"].pop("nbgrader", None)
    cells = {cell["id"]: cell for cell in notebook["cells"]}
    for exercise in paper.exercises(notebook):
        for name in exercise.solutions:
            graded = name in exercise.written
            share = exercise.by_hand / len(exercise.written) if graded else None
            _stamp(cells[name], solution=True, points=share)
        for name in exercise.checks:
            share = (exercise.points - exercise.by_hand) / len(exercise.checks)
            _stamp(cells[name], solution=False, points=share)
        _fold(cells[name] for name in exercise.solutions + exercise.checks)
    for cell in notebook["cells"]:
        if paper.has_solution(cell) and "nbgrader" not in cell["metadata"]:
            _stamp(cell, solution=True)


def _fold(cells):
    """Keep answers and verdicts folded until the reader runs or opens them."""
    for cell in cells:
        if cell["cell_type"] == "code":
            folded = cell["metadata"].setdefault("jupyter", type(cell["metadata"])())
            folded["outputs_hidden"] = True


def _stamp(cell, solution, points=None):
    entry = {
        "grade": points is not None,
        "grade_id": cell["id"],
        "locked": not solution,
        "schema_version": NBGRADER_SCHEMA,
        "solution": solution,
        "task": False,
    }
    if points is not None:
        entry["points"] = points
    cell["metadata"]["nbgrader"] = entry


def without_solutions(notebook):
    """A copy with gaps, and without the outputs of cells that need an answer."""
    edition = copy.deepcopy(notebook)
    edition["metadata"].pop("widgets", None)
    for cell in edition["cells"]:
        _clear(cell)
    owners = {name: e for e in paper.exercises(edition) for name in e.solutions}
    reads = {cell["id"]: gaps.names(cell["source"])[0] for cell in edition["cells"]}
    asked, known, opened = gaps.asked(edition), set(), set()
    for cell in edition["cells"]:
        solved = paper.has_solution(cell)
        if solved:
            owner = owners.get(cell["id"], paper.Exercise(""))
            checked = set().union(*(reads[name] for name in owner.checks))
            cell["source"] = _named(cell, gaps.gap, cell, owner.name, asked - known | checked)
            cell["metadata"]["deletable"] = False
        if cell["cell_type"] == "code":
            _, binds = gaps.names(cell["source"])
            if solved or reads[cell["id"]] & opened:
                opened |= binds - known
                cell["outputs"] = []
            else:
                known, opened = known | binds, opened - binds
    left = [c["id"] for c in edition["cells"] if any(m in c["source"] for m in paper.MARKERS)]
    if left:
        raise ValueError(f"cell {left[0]}: a marker is left; write it exactly as nbgrader does.")
    return edition


def _clear(cell):
    """Nothing hidden, no word for the marker, nothing folded; checks are locked."""
    hidden = paper.BEGIN_HIDDEN, paper.END_HIDDEN
    cell["source"] = _named(cell, paper.without, cell["source"], *hidden)
    notes = cell["metadata"].get("pendlab", {})
    for key in set(notes) - TOLD:
        del notes[key]
    part = paper.PART.fullmatch(cell["id"])
    if part and part["role"] == "check" and cell["cell_type"] == "code":
        cell["outputs"] = []
        cell["metadata"]["editable"] = cell["metadata"]["deletable"] = False
    _show(cell)


def _named(cell, edit, *arguments):
    """The edited source, or a sentence that names the cell."""
    try:
        return edit(*arguments)
    except (ValueError, SyntaxError) as problem:
        raise ValueError(f"cell {cell['id']}: {problem}.") from None


def _show(cell):
    """Unfold a cell that a reader should see."""
    cell["metadata"].pop("jupyter", None)


def _markdown(name, text):
    from nbformat.v4 import new_markdown_cell

    return new_markdown_cell(text, id=name[:64], metadata={"tags": ["teacher"]})


def _overview(exercises, sheet):
    lines = ["## For the teacher", "", "| exercise | minutes | points |", "|---|---|---|"]
    for exercise in exercises:
        minutes = "" if exercise.minutes is None else f"{exercise.minutes:g}"
        lines.append(f"| {exercise.name} | {minutes} | {exercise.points:g} |")
    minutes, points = (sum(getattr(e, f) or 0 for e in exercises) for f in ("minutes", "points"))
    lines.append(f"| **all** | {minutes:g} | {points:g} |")
    if sheet:
        lines += ["", sheet]
    return "\n".join(lines)


def told(notes):
    """Lines of what `exercises.marking` says of one exercise."""
    lines = []
    for key, title in NOTES.items():
        if isinstance(notes.get(key), str):
            lines += ["", f"*{title}:* {notes[key]}"]
        elif key in notes:
            lines += ["", f"{title}:", "", *(f"- {item}" for item in notes[key])]
    return lines


def lab_sheet(path):
    """Text of ``labs/<the notebook's name>.md`` as a part of that notebook, or None."""
    sheet = path.parent / "labs" / f"{path.stem}.md"
    if not sheet.exists():
        return None
    text = re.sub(r"^#", "###", sheet.read_text(encoding="utf-8"), flags=re.M)
    # Read in the notebook's folder now, where the other notebooks are but not labs/.
    return text.replace("[course map](README.md)", "course map").replace("](../", "](")
