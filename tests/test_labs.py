"""The lab kit says nothing that the notebooks do not hold: minutes, exercises, pictures, quotations."""

import re
from functools import lru_cache

import nbformat
import pytest
import refresh_minutes
from minutes import at_home, needed, optional, planned
from refresh_notebooks import ROOT

from pendlab.__main__ import main
from pendlab.classroom import exercises as paper
from pendlab.classroom.editions import lab_sheet

FOLDER = ROOT / "notebooks"
LABS = FOLDER / "labs"
# The paper's sections and appendices, and any notebook more that has a sheet.
SERIES = sorted(
    path.stem
    for path in FOLDER.glob("*.ipynb")
    if re.match("(0[0-6]|[AB])_", path.stem) or (LABS / f"{path.stem}.md").exists()
)
HEADINGS = (
    "Pre-lab question",
    "Steps",
    "Checkpoints",
    "Expected pictures",
    "Common mistakes",
    "Hand in",
)


@lru_cache
def sheet(stem):
    return (LABS / f"{stem}.md").read_text(encoding="utf-8")


@lru_cache
def notebook(stem):
    return nbformat.read(FOLDER / f"{stem}.ipynb", as_version=4)


def section(text, heading):
    """The text between a heading of level 2 and the next one."""
    return re.search(rf"^## {re.escape(heading)}\n(.*?)(?=^## |\Z)", text, re.M | re.S)[1]


def rows(text):
    """Cells of the body of every table in a text."""
    lines = [line for line in text.splitlines() if line.startswith("|")]
    cells = [[cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]] for line in lines]
    heads = {k - 1 for k, row in enumerate(cells) if set("".join(row)) <= set("-: ")}
    return [row for k, row in enumerate(cells) if k not in heads and k - 1 not in heads]


def minutes(stem):
    """Minutes of each step, by its number."""
    return refresh_minutes.minutes()[stem]


def totals(stem):
    """Minutes that a sheet tells, part by part."""
    told = re.search(r"\*\*Total: ([\d +]+) minutes\*\*", sheet(stem))[1]
    return [int(part) for part in told.split(" + ")]


def named(text):
    """Numbers of the exercises that a text names: ``exercise 2``, ``exercise 1 to exercise 5``."""
    found = {int(k) for k in re.findall(r"[Ee]xercise (\d+)", text)}
    for first, last in re.findall(r"[Ee]xercise (\d+) to exercise (\d+)", text):
        found |= set(range(int(first), int(last) + 1))
    return found


def exercise_minutes(stem):
    """Minutes of each exercise as its task says them."""
    cells = {cell.id: cell.source for cell in notebook(stem).cells}
    found = {}
    for exercise in paper.exercises(notebook(stem)):
        number = int(re.search(r"-ex(\d+)-", exercise.task)[1])
        found[number] = int(re.search(r"\((\d+) min\)", cells[exercise.task])[1])
    return found


def printed(cell):
    """All text that a cell's stored outputs show."""
    outputs = [o.get("text") or o.get("data", {}) for o in cell.outputs]
    return "\n".join(
        o if isinstance(o, str) else "\n".join(v for k, v in o.items() if k.startswith("text/"))
        for o in outputs
    )


@pytest.fixture(params=SERIES)
def stem(request):
    return request.param


def test_every_notebook_has_a_sheet_and_every_sheet_a_notebook():
    assert sorted(path.stem for path in LABS.glob("*.md") if path.stem != "README") == SERIES


def test_sheet_has_all_parts(stem):
    text = sheet(stem)
    assert re.findall(r"^## (.+)$", text, re.M) == list(HEADINGS)
    assert all(len(section(text, heading).strip()) > 60 for heading in HEADINGS)
    question = section(text, "Pre-lab question")
    assert "> " in question and "A good answer mentions:" in question


def test_minutes_sum_to_the_total_and_fit_a_session(stem):
    steps = minutes(stem)
    assert list(steps) == list(range(1, len(steps) + 1))
    assert [sum(part.values()) for part in planned(sheet(stem))] == totals(stem)
    assert all(45 <= part <= 90 for part in totals(stem)) or stem == "00_start_here"
    assert sum(sum(totals(s)) for s in SERIES if s[:2] in ("00", "01")) <= 90  # one session


def test_minutes_planned_are_those_needed(stem):
    """What words, code, predictions and exercises take, to within a fifth; parts one by one."""
    needs = needed(notebook(stem), at_home(sheet(stem)))
    assert list(needs) == list(range(1, len(totals(stem)) + 1))
    for part, told in zip(needs, totals(stem)):
        assert abs(needs[part] / told - 1) <= 0.2, f"part {part}: needs {needs[part]:.0f}"
        assert needs[part] <= 90, f"part {part}: mark stretches as optional"


def test_optional_stretches_are_short(stem):
    assert all(time <= 20 for _, time in optional(notebook(stem)))


def test_every_homework_tells_the_minutes_that_it_needs():
    for path in (FOLDER / "homework").glob("*.ipynb"):
        homework = nbformat.read(path, as_version=4)
        told = int(re.search(r"\*\*Time\*\* (\d+) minutes", homework.cells[0].source)[1])
        tasks = sum(task.minutes for task in paper.exercises(homework))
        assert abs((needed(homework)[1] + tasks) / told - 1) <= 0.2, path.stem


def test_every_session_has_two_steps_to_drop_first():
    first, *others = [sheet(stem).count("| **Drop first.** ") for stem in SERIES]
    assert first == 1 and others == [1] + [2] * (len(SERIES) - 2)


def test_minutes_are_the_same_everywhere():
    """Sheet, course map, paths, start page and the notebook's title."""
    for path, text in refresh_minutes.refreshed():
        assert text == path.read_text(encoding="utf-8"), "run tests/refresh_minutes.py"
    start = "\n".join(cell.source for cell in notebook("00_start_here").cells)
    for stem in SERIES:
        title = re.search(r"\*\*Time\W+([^.]+)\.", notebook(stem).cells[0].source)[1]
        assert [int(k) for k in re.findall(r"\d+", title)][: len(totals(stem))] == totals(stem), (
            stem
        )
        if stem != "00_start_here":
            told = re.search(rf"\({stem}\.ipynb\) \|.*\| ([\d +]+) \|", start)[1]
            assert told == refresh_minutes.total(stem)


def test_exercises_exist_have_time_and_none_is_forgotten(stem):
    known = exercise_minutes(stem)
    assert named(sheet(stem)) == set(known)
    in_class = set()
    for step in rows(section(sheet(stem), "Steps")):
        exercises = named(step[3])
        in_class |= exercises
        assert sum(known[k] for k in exercises) <= int(step[1]), f"step {step[0]}: too short"
    at_home = re.search(r"^At home: (.+)$", section(sheet(stem), "Steps"), re.M)
    at_home = named(at_home[1]) if at_home else set()
    assert in_class | at_home == set(known) and not in_class & at_home


def test_steps_and_checkpoints_name_what_is_there(stem):
    text = "\n".join(cell.source for cell in notebook(stem).cells if cell.cell_type == "markdown")
    headings = re.findall(r"^#+ (.+)$", text, re.M)
    for step in rows(section(sheet(stem), "Steps")):
        if step[2] == "pre-lab question":
            continue
        for place in step[2].split(", "):
            start = re.compile(rf"{re.escape(place)}(?![\d.]*\d)")
            assert any(map(start.match, headings)), f"no section {place!r}"
    after = {int(row[0].removeprefix("step ")) for row in rows(section(sheet(stem), "Checkpoints"))}
    assert len(after) >= 2 and after <= set(minutes(stem))


def test_expected_pictures_are_stored(stem):
    cells = {cell.id: cell for cell in notebook(stem).cells}
    for name, picture, _ in rows(section(sheet(stem), "Expected pictures")):
        outputs = cells[name.strip("`")].outputs
        assert any("image/png" in o.get("data", {}) for o in outputs), f"{name}: no picture"
        for number in re.findall(r"Fig (\d+)", picture):
            assert f"Fig {number}." in printed(cells[name.strip("`")]), f"{name}: not Fig {number}"


def test_pictures_of_the_paper_are_all_on_the_sheet(stem):
    figures = set()
    for cell in notebook(stem).cells:
        if cell.cell_type == "code":
            figures |= set(re.findall(r"\*\*(Fig \d+)\.\*\*", printed(cell)))
    assert figures <= set(re.findall(r"Fig \d+", section(sheet(stem), "Expected pictures")))


def test_quotations_and_cells_exist(stem):
    """Every `cell-id` is a cell; what a sheet says a cell prints is in its stored output."""
    cells = {cell.id: cell for cell in notebook(stem).cells}
    text = sheet(stem)
    unit = stem.split("_")[0]
    for name in re.findall(rf"`({unit}-[a-z0-9-]+)`", text):
        assert name in cells
    for name, quotation in re.findall(r"`([\w-]+)` prints `([^`]+)`", text):
        assert quotation in printed(cells[name]), f"{name} does not print {quotation!r}"


def test_teacher_edition_takes_the_sheet_with_links_that_work_there(stem):
    text = lab_sheet(FOLDER / f"{stem}.ipynb")
    for heading in HEADINGS:
        assert f"\n#### {heading}\n" in text
    targets = re.findall(r"\]\(([^)#\s]+)\)", text)
    assert targets and all((FOLDER / target).exists() and "/" not in target for target in targets)


@pytest.mark.parametrize("path", sorted(LABS.glob("*.md")), ids=lambda path: path.stem)
def test_links_lead_somewhere(path):
    targets = re.findall(r"\]\(([^)#\s]+)\)", path.read_text(encoding="utf-8"))
    assert targets
    assert all((LABS / target).exists() for target in targets)


# ---- The course map


def test_course_map_names_every_notebook_with_its_sheet_and_minutes():
    entries = rows(section(sheet("README"), "Course map"))
    linked = [re.search(r"\.\./(\w+)\.ipynb", row[0])[1] for row in entries]
    assert sorted(linked) == sorted([*SERIES, "extending"])
    known = {stem.split("_")[0] for stem in SERIES}
    met = set()
    for stem, row in zip(linked, entries):
        needs = set() if row[2] == "nothing" else set(row[2].split(", "))
        assert needs <= known & met, f"{stem} needs {needs - met}, which comes later"
        met.add(stem.split("_")[0])
        if stem in SERIES:
            assert f"]({stem}.md)" in row[1] and row[3] == refresh_minutes.total(stem)


def test_sheets_need_what_the_map_says():
    for row in rows(section(sheet("README"), "Course map")):
        stem = re.search(r"\.\./(\w+)\.ipynb", row[0])[1]
        if stem in SERIES and row[2] != "nothing":
            needs = re.search(r"Needs:(.+?)(?:; [^\[]+)?\*\*Total", sheet(stem), re.S)[1]
            linked = {name.split("_")[0] for name in re.findall(r"\.\./(\w+)\.ipynb", needs)}
            assert set(row[2].split(", ")) <= linked


def test_paths_add_up_and_fit_their_sessions():
    paths = rows(section(sheet("README"), "Paths"))
    stems = {stem.split("_")[0]: stem for stem in SERIES}
    met = []
    for row in paths:
        parts = re.findall(r"(\w+) steps (\d+)-(\d+)", row[1])
        spent = 0
        for unit, first, last in parts:
            steps = minutes(stems[unit])
            assert int(last) <= len(steps)
            spent += sum(steps[k] for k in range(int(first), int(last) + 1))
        assert parts and spent == int(row[2]), f"session {row[0]}: {spent} minutes"
        assert 60 <= spent <= 90
        met.append({unit for unit, _, _ in parts})
    *_, term = [k for k, row in enumerate(paths) if row[0] == "1"]
    assert [int(row[0]) for row in paths] == [1, 2, 1, 2, 3, 4, *range(1, len(paths) - 5)]
    assert set().union(*met[term:]) == set(stems)  # the full term leaves nothing out


def test_homework_named_exists():
    found = {
        int(number[0])
        for path in (FOLDER / "homework").glob("*.ipynb")
        if (number := re.findall(r"\d+", path.stem))
    }
    assert {int(k) for k in re.findall(r"homework (\d)", sheet("README"))} <= found


def test_commands_are_those_of_the_package(capsys):
    commands = re.findall(r"^    python -m pendlab (\w+)(.*)$", sheet("README"), re.M)
    ours = {"student", "teacher", "handout", "bundle", "warm", "course", "leaderboard"}
    assert {name for name, _ in commands} >= ours
    for name, arguments in commands:
        with pytest.raises(SystemExit) as stopped:
            main([name, *arguments.split(), "--help"])
        assert stopped.value.code == 0
        known = capsys.readouterr().out
        assert all(option in known for option in re.findall(r"--\w+", arguments))
    mentioned = set(re.findall(r"`(--[\w-]+)", sheet("README")))
    editions = {"--pdf", "--solutions", "--no-results", "--student", "--help"}
    assert mentioned == editions | {"--confined"}
