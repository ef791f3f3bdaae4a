"""Minutes that a student needs for a notebook, from what stands in it: ``python tests/minutes.py``.

Rates, rounded; with them seven notebooks come within a fifth of what students with one course in
control needed for them: 100 words of prose, one displayed equation or one prediction a minute; a
cell of code 20 seconds, and 4 seconds for each of its lines; a picture 30 seconds; an exercise what
its task says, and something to try what its heading says. What is folded costs nothing.

A stretch begins at a heading. One whose heading ends in ``(optional)`` or ``(optional, 12 min)`` is
off the main path, with all headings below it; so are exercises that the lab sheet leaves for home.
A heading ``Part 2`` begins a part: a session of its own. Tables to look things up are not read.
"""

import re
from dataclasses import dataclass
from pathlib import Path

import nbformat

NOTEBOOKS = Path(__file__).parent.parent / "notebooks"
LABS = NOTEBOOKS / "labs"
WORDS, EQUATION, PREDICTION, CELL, LINE, PICTURE = 1 / 100, 1, 1, 1 / 3, 1 / 15, 1 / 2

HEADING = re.compile(r"^(#+) (.+)$", re.M)
OPTIONAL = re.compile(r" \(optional(?:, (\d+) min)?\)$")
LOOKED_UP = ("Notation", "Glossary")
PREDICTED = re.compile(r"\*{1,3}(?:Predict|Before you)\b")
STEP = re.compile(r"^\| (\d+) \| (\d+) \| ", re.M)


@dataclass
class Stretch:
    """From one heading to the next: its minutes without exercises, and the exercises' minutes."""

    heading: str
    part: int
    optional: bool
    minutes: float
    exercises: dict


def prose(text):
    """Minutes of a piece of Markdown, without code and the lines that only link notebooks."""
    text = re.sub(r"```.*?```|<!--.*?-->|\]\([^)]*\)|^\[.* · .*$", " ", text, flags=re.M | re.S)
    equations = re.findall(r"\$\$.*?\$\$", text, re.S)
    text = re.sub(r"\$\$.*?\$\$", " ", text, flags=re.S)
    words = re.findall(r"[A-Za-z][\w'-]*", re.sub(r"\$[^$]*\$", " x ", text))
    predictions = PREDICTED.findall(text)
    return len(words) * WORDS + len(equations) * EQUATION + len(predictions) * PREDICTION


def code(cell):
    """Minutes of a cell of code and the pictures below it."""
    lines = [line for line in cell.source.splitlines() if line.strip()]
    pictures = sum("image/png" in output.get("data", {}) for output in cell.outputs)
    folded = "folded" in cell.metadata.get("tags", [])
    return pictures * PICTURE + (0 if folded else CELL + len(lines) * LINE)


def stretches(notebook):
    """The stretches of a notebook in their order."""
    found, part, below = [Stretch("", 1, False, 0, {})], 1, 9
    for cell in notebook.cells:
        tags = cell.metadata.get("tags", [])
        if {"solution", "check"} & set(tags):
            continue
        if cell.cell_type == "code":
            found[-1].minutes += code(cell)
            continue
        start, *pieces = re.split(r"(?m)^(?=#+ )", cell.source)
        found[-1].minutes += prose(start)
        for piece in pieces:
            marks, heading = HEADING.match(piece).groups()
            part = int(k[1]) if (k := re.match(r"Part (\d+)", heading)) else part
            below = 9 if len(marks) <= below else below
            if OPTIONAL.search(heading) or heading in LOOKED_UP:
                below = min(below, len(marks))
            exercise = (
                re.match(r"Exercise (\d+)\D+(\d+) min", heading) if "exercise" in tags else None
            )
            exercises = {int(exercise[1]): int(exercise[2])} if exercise else {}
            tried = re.search(r" \((\d+) min\)$", heading)
            time = int(tried[1]) if tried else prose(piece)
            time = 0 if "exercise" in tags or heading in LOOKED_UP else time
            found.append(Stretch(heading, part, below < 9, time, exercises))
    return found


def needed(notebook, home=()):
    """Minutes of the main path, by part."""
    found = {}
    for stretch in stretches(notebook):
        time = 0 if stretch.optional else stretch.minutes
        time += sum(m for k, m in stretch.exercises.items() if k not in home)
        found[stretch.part] = found.get(stretch.part, 0) + time
    return found


def optional(notebook):
    """(heading, minutes) of each optional stretch, with what stands below it."""
    found = []
    for stretch in stretches(notebook):
        if OPTIONAL.search(stretch.heading):
            found.append([OPTIONAL.sub("", stretch.heading), stretch.minutes])
        elif stretch.optional and found and stretch.heading not in LOOKED_UP:
            found[-1][1] += stretch.minutes
    return [(heading, max(1, round(time))) for heading, time in found]


def at_home(sheet):
    """Numbers of the exercises that a lab sheet leaves for home."""
    line = re.search(r"^At home: (.+)$", sheet, re.M)
    return {int(k) for k in re.findall(r"exercise (\d+)", line[1])} if line else set()


def planned(sheet):
    """Minutes of each step of a lab sheet, in one dictionary for each part."""
    steps = re.search(r"^## Steps\n(.*?)(?=^## |\Z)", sheet, re.M | re.S)[1]
    parts = re.split(r"^### Part \d+.*$", steps, flags=re.M)
    found = [{int(k): int(m) for k, m in STEP.findall(part)} for part in parts]
    return [part for part in found if part]


def main():
    for path in sorted(LABS.glob("*_*.md")):
        sheet = path.read_text(encoding="utf-8")
        notebook = nbformat.read(NOTEBOOKS / f"{path.stem}.ipynb", as_version=4)
        plans = [sum(steps.values()) for steps in planned(sheet)]
        needs = [round(time) for time in needed(notebook, at_home(sheet)).values()]
        print(f"{path.stem}: planned {plans}, needed {needs}")
        for stretch in stretches(notebook):
            mark = "optional" if stretch.optional else ""
            tasks = "".join(f" exercise {k}: {m}" for k, m in stretch.exercises.items())
            print(f"    {stretch.minutes:5.1f} {mark:8s} {stretch.heading[:60]}{tasks}")


if __name__ == "__main__":
    main()
