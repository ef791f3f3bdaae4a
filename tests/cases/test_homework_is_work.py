"""Open homework tasks: nothing passes without work, and for every name a design exists.

The designs were found by tests/benchmarks/homework_designs.py, which tries ten names and, with
``--lazy``, all that costs no work for them; here three names are replayed, and lazy answers that
need no long simulation for one.
"""

import json
from pathlib import Path

import pytest
from open_tasks import LAZY, NAMES, OPEN, answer, rig_of

import pendlab as pl
from pendlab.classroom.checks import hw1, hw2, hw3, hw4, hw6, hw7, hw8, hw9

HOMEWORK = Path(__file__).parents[2] / "notebooks" / "homework"
FOUND = json.loads((Path(__file__).parent / "homework_designs.json").read_text())
FEW = (NAMES[0], NAMES[4], NAMES[-1])


def test_a_design_is_known_for_ten_names():
    assert set(FOUND) == set(OPEN)
    for found in FOUND.values():
        assert set(found) == set(NAMES) and None not in found.values()


@pytest.mark.parametrize("task", OPEN)
@pytest.mark.parametrize("name", FEW)
def test_found_designs_pass(task, name):
    given = answer(task, name, FOUND[task][name]["made_of"])
    verdict = pl.check(task, *given, rig=rig_of(task, name))
    assert verdict, verdict.message


@pytest.mark.parametrize("task", OPEN)
def test_nothing_passes_without_work(task, name=NAMES[1]):
    rig = rig_of(task, name)
    tried = list(LAZY[task](rig))
    assert len(tried) >= 3
    assert [label for label, given in tried if pl.check(task, *given, rig=rig)] == []


REQUIRED = {  # what the text of a task asks for, from the constants that its check judges by
    "hw1.4": f"{100 * hw1.LOAD:g} %|{hw1.LOWEST:g} Hz|{hw1.SMOOTHING:g} or more|{hw1.WEAKENED:g} or more|least {hw1.MARGIN:g}|most {hw1.HUM_VOLTS:g} V",
    "hw2.4": f"least {hw2.APART:g}|above {hw2.SLOWEST:g}|{hw2.QUIETER:g} times",
    "hw3.4": f"least {hw3.BETTER:g} times|{hw3.QUIETER:g}** times",
    "hw4.3": f"most {hw4.WANTED:g} s",
    "hw4.4": f"below {hw4.BAND:g} rad|most {hw4.SETTLED:g} s|exceeds {hw4.PEAK:g} rad|step of {hw4.STEP:g} rad|within {hw4.LASTING:g} s",
    "hw6.5": f"within {hw6.FURTHEST:g} rad|least {hw6.MARGIN:g}|most {hw6.SLOWEST:g} s|{100 * hw6.SMALLER:g} %",
    "hw7.3": f"to {hw7.FLATTERED:g} of|to {hw7.HARDER:g} or less",
    "hw7.4": f"least {hw7.BETTER:g} times",
    "hw7.5": f"at {hw7.CLOSE:g} of|below {hw7.CAUGHT:g} rad",
    "hw8.3": f"least {hw8.MARGIN:g}|within {hw8.BAND:g} rad|after {hw8.SECONDS:g} s|most {hw8.CROSSTALK:g} rad",
    "hw9.3": f"least {hw9.AHEAD:g} points",
    "hw9.4": f"least {hw9.STRANGERS:g} points",
}  # fmt: skip


@pytest.mark.parametrize("task", REQUIRED)
def test_the_text_asks_for_what_the_check_wants(task):
    number, exercise = task[2:].split(".")
    (path,) = HOMEWORK.glob(f"0{number}_*.ipynb")
    cells = {cell["id"]: cell["source"] for cell in json.loads(path.read_text("utf-8"))["cells"]}
    source = "".join(cells[f"hw{number}-ex{exercise}-task"])
    assert [asked for asked in REQUIRED[task].split("|") if asked not in source] == []
