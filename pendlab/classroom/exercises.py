"""Exercises in a notebook: where tasks, solutions and checks are, and their marks.

An exercise is a task cell (Markdown), one or more solution cells and check cells, named by their
ids: ``02-ex1-task``, ``02-ex1-solution``, ``02-ex1-check``. What belongs to the solution stands
between nbgrader's markers. Only the standard library is used.
"""

import re
import tomllib
from dataclasses import dataclass, field
from pathlib import Path

PART = re.compile(r"(?P<unit>.+)-ex(?P<number>\d+)-(?P<role>task|solution|check)[a-z0-9-]*")
BEGIN_SOLUTION, END_SOLUTION = "BEGIN SOLUTION", "END SOLUTION"
BEGIN_HIDDEN, END_HIDDEN = "BEGIN HIDDEN TESTS", "END HIDDEN TESTS"
MARKERS = (BEGIN_SOLUTION, END_SOLUTION, BEGIN_HIDDEN, END_HIDDEN)


@dataclass
class Exercise:
    """One exercise: the ids of its cells, and what the task cell's metadata says about it.

    `minutes` is the expected time and `points` the marks, of which `by_hand` are given by reading
    the `written` cells, all from ``{"pendlab": {"exercise": "02.1", "minutes": 5, ...}}``. Where
    there is nothing to run, all marks are given by hand.
    """

    name: str
    task: str | None = None
    solutions: list = field(default_factory=list)
    checks: list = field(default_factory=list)
    written: list = field(default_factory=list)
    minutes: float | None = None
    points: float = 1
    by_hand: float = 0

    def __str__(self):
        facts = [] if self.minutes is None else [f"{self.minutes:g} min"]
        facts.append(f"{self.points:g} point{'s' * (self.points != 1)}")
        if self.checks and self.by_hand:
            facts.append(f"{self.by_hand:g} of them by reading")
        return f"Exercise {self.name}: {', '.join(facts)}"


def exercises(notebook):
    """The exercises of a notebook in the order in which they come."""
    found = {}
    for cell in notebook["cells"]:
        part = PART.fullmatch(cell["id"])
        if not part:
            continue
        key = part["unit"], part["number"]
        exercise = found.setdefault(key, Exercise(f"{part['unit']}.{part['number']}"))
        if part["role"] == "task":
            exercise.task = cell["id"]
            notes = cell["metadata"].get("pendlab", {})
            exercise.name = notes.get("exercise", exercise.name)
            exercise.minutes = notes.get("minutes")
            exercise.points = notes.get("points", exercise.points)
            exercise.by_hand = notes.get("by_hand", 0)
        elif part["role"] == "solution":
            exercise.solutions.append(cell["id"])
            if cell["cell_type"] == "markdown":
                exercise.written.append(cell["id"])
        else:
            exercise.checks.append(cell["id"])
    for exercise in found.values():
        if not exercise.checks:
            exercise.by_hand = exercise.points
            exercise.written = exercise.written or exercise.solutions[:1]
    return list(found.values())


def marking(path):
    """What only the marker may read about a notebook's exercises, by their names.

    From ``labs/marking.toml`` beside the notebook or one folder up: `mistakes`, and where something
    is marked by reading `criteria` and sample answers `full`, `half` and `none`.
    """
    folders = Path(path).resolve().parents[:2]
    found = (folder / "labs" / "marking.toml" for folder in folders)
    text = next((file.read_text(encoding="utf-8") for file in found if file.exists()), "")
    return tomllib.loads(text)


def region(source, begin=BEGIN_SOLUTION, end=END_SOLUTION):
    """First and last line (from 0, markers included) of each marked region.

    Raises ValueError for a marker without its partner.
    """
    regions, start = [], None
    for number, line in enumerate(source.splitlines()):
        if begin in line:
            if start is not None:
                raise ValueError(f"{begin} twice without {end}")
            start = number
        elif end in line:
            if start is None:
                raise ValueError(f"{end} without {begin}")
            regions.append((start, number))
            start = None
    if start is not None:
        raise ValueError(f"{begin} without {end}")
    return regions


def without(source, begin, end):
    """The source without its marked regions."""
    lines = source.splitlines()
    for first, last in reversed(region(source, begin, end)):
        del lines[first : last + 1]
    return "\n".join(lines)


def has_solution(cell):
    return BEGIN_SOLUTION in cell["source"] or END_SOLUTION in cell["source"]
