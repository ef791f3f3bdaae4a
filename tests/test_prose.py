"""Every number in prose is known to the notebook, its checks, the ledger or the data."""

import re
from dataclasses import replace
from itertools import pairwise

import nbformat
import pytest
from nbformat.v4 import new_code_cell, new_markdown_cell, new_notebook, new_output
from prose import Sources, claims, unheld
from refresh_notebooks import ROOT, notebooks

NOTEBOOKS = {path.relative_to(ROOT).as_posix(): path for path in notebooks()}
LEAST_FOUND = 0.85


@pytest.fixture(params=NOTEBOOKS.values(), ids=NOTEBOOKS.keys())
def path(request):
    return request.param


def read(path):
    return nbformat.read(path, as_version=4)


def test_every_numeral_is_held(path):
    missing = unheld(read(path), path)
    assert not missing, "\n" + "\n".join(missing)


def written(text, **others):
    """A notebook of one section, with a computation, and this text."""
    printed = new_output("stream", text="delay 0.42 ms, crossover 10.264 Hz, [ 0.8514 12.5 ] rad\n")
    code = new_code_cell("t = 0.3 * 7.5", id="code", outputs=[printed], **others)
    return new_notebook(cells=[new_markdown_cell(text, id="text"), code])


@pytest.mark.parametrize(
    "text",
    [
        "It takes 0.42 ms, or 420 µs.",
        "Crossing at 10.3 Hz or $10.26\\,\\mathrm{Hz}$, leaning by 0.85 rad, by 851 mrad or 48.8°.",
        "We chose 0.3 s and 30 %; that is 70 % less.",
        "In section 4.11, Figs 8, 10 and 11, (34) and exercise 2 of 1995 there are 12 of them.",
        "The paper has 9 V, 6.05 Hz and a sampling time of 10 ms.",
        "$x_{37}^2 = 10^{-3}$, a right angle of 90 degrees. [05](05_experimental_results.ipynb)",
        "**Things to try**\n\n* Take 0.77.\n\n**Where next:** home",
    ],
)
def test_what_is_known_is_held(text):
    assert unheld(written(text), ROOT / "notebooks/99_none.ipynb") == []


@pytest.mark.parametrize(
    "text, wrong",
    [
        ("It takes 0.24 ms.", "0.24 ms"),
        ("Crossing at 10.62 Hz.", "10.62 Hz"),
        ("leaning by 0.58 rad", "0.58 rad"),
        ("leaning by 0.42 rad", "0.42 rad"),  # the unit is another
        ("We chose 0.31 s.", "0.31 s"),  # what is typed is not rounded
        ("The sensor's filter has 21.29 Hz.", "21.29 Hz"),
        ("The motor takes 9.5 V.", "9.5 V"),
        ("$L_2=58.2$ and more", "58.2"),
        ("at most 0.3000 s", "0.3000 s"),  # digits that nobody has
        ("45 samples", "45"),
    ],
)
def test_what_is_not_known_is_named_with_its_cell_and_what_is_near(text, wrong):
    (message,) = unheld(written(text), ROOT / "notebooks/99_none.ipynb")
    assert message.startswith(f"99_none text: {wrong} in '") and "nearest are " in message


def test_a_task_asks_for_what_its_check_asks_for():
    """In a homework's task an output or the solution's own number does not do."""
    task = ROOT / "notebooks/homework/02_observer_dynamics.ipynb"
    text = "noise at most {} times that of `reference`"
    cells = [new_markdown_cell(text.format(number), id="hw2-ex4-task") for number in (0.66, 0.58)]
    right, wrong = (
        new_notebook(cells=[cell, new_code_cell("0.58", id="hw2-ex4-solution")]) for cell in cells
    )
    assert unheld(right, task) == [] and len(unheld(wrong, task)) == 1


def minutes(notebook):
    """What the Time line says, and what the exercises sum up to."""
    text = "\n".join(cell.source for cell in notebook.cells if cell.cell_type == "markdown")
    line = re.search(r"\*\*Time:?\*\*(.*)", text)[1]
    exercises = re.findall(r"(?m)^#.*\((\d+) min\)", text)
    return line, [int(n) for n in re.findall(r"\d+", line)], sum(map(int, exercises))


def test_minutes_add_up(path):
    line, told, exercises = minutes(read(path))
    if path.parent.name == "homework":
        whole, reading, tasks = told
        assert whole == reading + tasks and tasks == exercises, line
    elif "of which" in line:
        assert told[1] == exercises, line
    else:
        assert sum(told) >= exercises, line


def test_the_map_gives_the_minutes_of_each_notebook():
    home = NOTEBOOKS["notebooks/00_start_here.ipynb"]
    (table,) = (cell.source for cell in read(home).cells if cell.id == "00-map-text")
    rows = dict(re.findall(r"(?m)^\| \[.*?\]\((.*?)\).*\| ([\d +]+) \|$", table))
    assert len(rows) >= 8
    for name, told in rows.items():
        parts = [int(part) for part in told.split(" + ")]
        assert parts == minutes(read(home.parent / name))[1][: len(parts)], name


def turned(text):
    """A numeral with two of its digits exchanged, or its last one changed."""
    places = [i for i, letter in enumerate(text) if letter.isdigit()]
    for a, b in reversed([*pairwise(places)]):
        swapped = [*text]
        swapped[a], swapped[b] = text[b], text[a]
        swapped = "".join(swapped)
        if swapped != text and not re.match(r"0\d", swapped) and float(swapped):
            return swapped
    return text[:-1] + str((int(text[-1]) + 2) % 10 or 3)


def test_digits_that_were_exchanged_are_found():
    """In all notebooks, each plain numeral in turn; the rest are digits that mean something else."""
    found = []
    for path in NOTEBOOKS.values():
        notebook = read(path)
        sources = Sources(notebook, path)
        for cell in notebook.cells:
            for claim in claims(cell) if cell.cell_type == "markdown" else ():
                if re.fullmatch(r"\d+(\.\d+)?", claim.text) and claim.digits > 1:
                    text = turned(claim.text)
                    found.append(not sources.hold(replace(claim, text=text, value=float(text))))
    assert len(found) > 100 and sum(found) / len(found) > LEAST_FOUND, sum(found) / len(found)
