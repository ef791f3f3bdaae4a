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
