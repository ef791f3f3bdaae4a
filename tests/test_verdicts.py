"""The scoreboard: a verdict for every printed number, and honest ones."""

from dataclasses import replace

import numpy as np
import pytest

import pendlab as pl
from pendlab.__main__ import main
from pendlab.paper import scoreboard as verdicts
from pendlab.paper.designs import OBSERVERS, printed_member
from pendlab.paper.scoreboard import DIFFERS, FITS, GIVEN, KNOWN, RECOMPUTED, REPRODUCED, Score


@pytest.fixture(scope="module")
def board():
    return pl.scoreboard()


def of_the_ledger(key):
    """An axis of Figs 15 to 17 has a line for each end."""
    return key.removesuffix(".min").removesuffix(".max") if ".y_axis." in key else key


def test_every_printed_number_has_a_verdict_and_none_differs(board):
    keys = [of_the_ledger(score.entry.key) for score in board.scores]
    assert list(dict.fromkeys(keys)) == [e.key for e in pl.published()]
    assert len(keys) == len(pl.published()) + 11
    assert board.totals[DIFFERS] == 0
    assert sum(board.totals.values()) == len(keys)


def test_every_extreme_shows_its_share(board):
    ends = [score for score in board.scores if ".y_axis." in score.entry.key]
    assert len(ends) == 22
    hits = pl.tick_hits("triple") | pl.tick_hits("double")
    for score in ends:
        panel, end = score.entry.key[3:6], score.entry.key[-3:]
        assert score.share == hits[f"{panel} {end}"]
        assert (score.verdict == FITS) == (score.share >= 0.5)
    shown = [row for row in board.rows if ".y_axis." in row[1]]
    assert all(row[3].endswith("% of runs") for row in shown)


def test_known_differences_differ_and_only_they_have_a_reason(board):
    """A reason beside a number that holds would be as wrong as a missing one."""
    for score in board.scores:
        assert bool(score.entry.known) == (score.verdict == KNOWN), score.entry.key


def test_only_choices_and_facts_are_taken_over(board):
    """Whatever can be computed is: what is given are weights, dynamics, axes, facts of the rig."""
    given = [score.entry.key for score in board.scores if score.verdict == GIVEN]
    facts = (
        "sec2.",
        "sec4.",
        "sec5.double.time",
        "sec5.triple.time",
        "eq16.",
        "eq17.",
        "eq18.C_p",
        "eq26.",
        "fig6.k_p_range",
    )
    axes = ("frame", "t_axis", "t_tick", "y_tick")
    assert all(key.startswith(facts) or any(part in key for part in axes) for key in given)


def test_nothing_is_recomputed_under_a_key_that_is_not_printed():
    assert set(RECOMPUTED) <= {entry.key for entry in pl.published()}


@pytest.mark.parametrize("which", OBSERVERS)
def test_one_member_rounds_to_every_printed_digit(which):
    design = pl.paper_design(*which)
    coefficients, worst = printed_member(design.family, *OBSERVERS[which])
    assert worst < 1
    assert np.allclose(coefficients, design.coefficients)
    residuals = design.observer.residuals(design.model)
    assert max(residuals.values()) < 1e-10


def test_a_wrong_number_is_called_wrong():
    entry = pl.published("sec4.double.R")
    assert Score(entry, np.array(3.2)).verdict == REPRODUCED
    assert Score(entry, np.array(3.6)).verdict == DIFFERS
    assert Score(replace(entry, known="because"), np.array(3.6)).verdict == KNOWN
    assert Score(entry, None).verdict == GIVEN
    axis = replace(pl.published("fig15b.y_axis"), known="")
    assert Score(axis, share=0.5).verdict == FITS
    assert Score(axis, share=0.4).verdict == DIFFERS
    assert Score(replace(axis, known="because"), share=0.4).verdict == KNOWN


def test_text_and_table_hold_every_line(board):
    text, html = str(board), board._repr_html_()
    for entry in pl.published():
        assert entry.key in text and f"<td>{entry.key}" in html
    assert html.count("<tr>") == len(board.scores) + 1
    assert "Known differences:" in text


def test_unknown_prefix_is_named():
    with pytest.raises(ValueError, match="'eq99'"):
        pl.scoreboard("eq99")


def test_observer_that_the_paper_does_not_print():
    with pytest.raises(ValueError, match="'triple' with observer 2"):
        pl.paper_design("triple", 2)


def test_report_writes_figures_and_succeeds(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("pendlab.figures.numbers", lambda: [5, 8])
    assert main(["report", "--folder", str(tmp_path / "out")]) == 0
    written = {path.name for path in (tmp_path / "out").iterdir()}
    assert written == {"fig05.png", "fig05.svg", "fig08.png", "fig08.svg", "bench.svg"}
    printed = capsys.readouterr().out
    assert "0 DIFFERS" in printed
    assert str(tmp_path / "out") in printed


def test_report_fails_where_a_number_does_not_hold(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("pendlab.figures.numbers", lambda: [5])
    monkeypatch.setitem(verdicts.RECOMPUTED, "eq23.F", lambda: np.zeros(5))
    assert main(["report", "--folder", str(tmp_path)]) == 1
    assert "should hold" in capsys.readouterr().out


def test_report_into_a_file_says_so(tmp_path, capsys):
    blocked = tmp_path / "file"
    blocked.write_text("")
    assert main(["report", "--folder", str(blocked / "out")]) == 2
    assert "file" in capsys.readouterr().err
