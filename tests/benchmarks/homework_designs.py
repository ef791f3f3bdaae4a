"""Designs that pass the homework's open tasks, found by search: ``python tests/benchmarks/homework_designs.py``.

For each of ten names and each task the first candidate that its check accepts goes into
``tests/cases/homework_designs.json``, with the number of candidates tried; the tests replay them.
Candidates are those that a student would try by turning one knob after another, in random order
from a fixed seed. With ``--lazy`` it prints instead which answers without work are accepted: none.
"""

import json
import sys
from pathlib import Path

import numpy as np

CASES = Path(__file__).parent.parent / "cases"
sys.path.insert(0, str(CASES))

from open_tasks import LAZY, NAMES, OPEN, answer, candidates, rig_of  # noqa: E402

import pendlab as pl  # noqa: E402

MOST = 400  # candidates


def search(task, name):
    """(what the candidate is made of, how many were tried) or None."""
    rng = np.random.default_rng(1)
    for tried in range(1, MOST + 1):
        made_of = candidates(task, rng)
        if pl.check(task, *answer(task, name, made_of), rig=rig_of(task, name)):
            return {"made_of": made_of, "tried": tried}
    return None


def accepted(task, name):
    """What is accepted without work."""
    rig = rig_of(task, name)
    return [label for label, given in LAZY[task](rig) if pl.check(task, *given, rig=rig)]


def main(lazy, tasks):
    found = {}
    for task in tasks or OPEN:
        for name in NAMES:
            result = accepted(task, name) if lazy else search(task, name)
            print(task, name, result, flush=True)
            found.setdefault(task, {})[name] = result
    if not lazy:
        path = CASES / "homework_designs.json"
        known = json.loads(path.read_text()) if path.exists() else {}
        path.write_text(json.dumps(known | found, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main("--lazy" in sys.argv, [name for name in sys.argv[1:] if name.startswith("hw")])
