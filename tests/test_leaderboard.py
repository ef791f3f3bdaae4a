"""The contest of homework 9, played again for classes that were handed in."""

import json

import pytest
from classroom import write
from nbformat.v4 import new_code_cell, new_notebook

import pendlab as pl
from pendlab.__main__ import main
from pendlab.classroom.leaderboard import Entry, leaderboard, table

START = "import numpy as np\nimport pendlab as pl"
PAPERS = "def Mine(rig):\n    return pl.paper_design('double').controller"
ZERO = """class Mine:
    dt = 0.01

    def __init__(self, rig): ...

    def step(self, state, y, y_ref):
        return np.zeros(1), state"""


def hand_in(folder, who, *cells, claim=None):
    notebook = new_notebook(cells=[new_code_cell(source) for source in (START, *cells)])
    path = write(notebook, folder / who / "homework_09_own_controller" / "09_own_controller.ipynb")
    if claim is not None:
        write(json.dumps({"score": claim}), path.with_name("leaderboard.json"))


@pytest.fixture(scope="module")
def board(tmp_path_factory):
    folder = tmp_path_factory.mktemp("course") / "submitted"
    hand_in(folder, "ada", "1 / 0", PAPERS, claim=99.0)
    hand_in(folder, "ben", "print('score: 100')", ZERO, claim="much")
    hand_in(
        folder, "dora", "class Mine:\n    def __init__(self, rig):\n        raise OSError('no')"
    )
    hand_in(folder, "eve", "import os\nprint('{\"score\": 100}')\nos._exit(0)", "Mine = 3")
    hand_in(folder, "finn", f"%matplotlib inline\n{PAPERS}")
    hand_in(folder, "hal", "Mine = ...")
    for k, text in enumerate(
        ("not json", "[1, 2]", '{"cells": 3}', '{"cells": [3]}', "[" * 100_000)
    ):
        write(text, folder / "gus" / f"{k}.ipynb")
    return leaderboard(folder.parent, seconds=60)


def test_scores_are_played_again_and_ranked(board):
    truth = pl.contest(lambda rig: pl.paper_design("double").controller).total
    first, magic, third = board[:3]
    assert (first.who, first.claim, first.falls, magic.who) == ("ada", 99.0, 0, "finn")
    assert first.score == magic.score == round(first.score, 1) == pytest.approx(truth, abs=0.3)
    assert third.who == "ben" and 0 < third.score < 20 and third.claim is None


def test_what_is_no_notebook_is_passed_over(board):
    assert {entry.who for entry in board} == {"ada", "ben", "dora", "eve", "finn", "hal"}


def test_what_gives_no_score_says_why(board):
    reasons = {entry.who: entry.reason for entry in board[3:]}
    assert reasons == {
        "dora": "round 1: OSError: no",
        "eve": "its process ended without a score",
        "hal": "no class Mine came out of its cells",
    }


def test_what_never_ends_is_stopped(tmp_path):
    hand_in(tmp_path, "cy", "while True: pass", PAPERS)
    (entry,) = leaderboard(tmp_path, seconds=3)
    assert (entry.who, entry.reason) == ("cy", "longer than 3 s")


def test_equal_scores_share_a_rank():
    entries = [
        Entry("a", 70.0, 71.2, 0),
        Entry("b", 70.0),
        Entry("c", 60.0),
        Entry("d", reason="x"),
    ]
    lines = table(entries).splitlines()
    assert [line.split()[0] for line in lines] == ["rank", "1", "1", "3", "-"]
    assert lines[1].split() == ["1", "70.0", "71.2", "0", "a"] and lines[4].endswith("d  (x)")


def test_a_folder_without_classes_is_refused(tmp_path, capsys):
    assert main(["leaderboard", str(tmp_path)]) == 2
    assert "no notebook below" in capsys.readouterr().err


@pytest.mark.parametrize("option", ["season", "seconds"])
def test_options_are_refused_before_the_first_process(tmp_path, capsys, option):
    hand_in(tmp_path, "ada", PAPERS)
    assert main(["leaderboard", str(tmp_path), f"--{option}", "-1"]) == 2
    told = capsys.readouterr().err
    assert f"{option}: expected" in told and "ada" not in told
