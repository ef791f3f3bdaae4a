"""The judge of exercises and the students' own rigs."""

import re
import sys
import warnings

import numpy as np
import pytest

import pendlab as pl
from pendlab.classroom.checks import exercises
from pendlab.classroom.checks.judging import all_right, choose, compare
from pendlab.design import Design

STATES = pl.paper_design("double").model  # whose text is a page


@pytest.mark.parametrize(
    ("answer", "hint"),
    [
        (-2.0, "sign"),
        (np.degrees(2.0), "degrees"),
        (2.0 / (2 * np.pi), "hertz"),
        (0.5, "upside down"),
        (2.1, "near"),
        (np.nan, "nan"),
        ([2.0, 2.0], "shape"),
        (2.0 + 1.0j, "complex"),
        (77.0, "too large"),
        (-77.0, "wrong sign"),
    ],
)
def test_hint_names_the_mistake(answer, hint):
    verdict = compare("x", answer, 2.0)
    assert not verdict
    assert hint in verdict.message


def test_right_within_tolerance_only():
    assert compare("x", 2.0001, 2.0)
    assert not compare("x", 2.02, 2.0)


def test_arrays_transposed_reversed_and_wrong_entry():
    truth = np.array([[1.0, 2.0], [3.0, 4.0]])
    assert "transposed" in compare("A", truth.T, truth).message
    assert "order" in compare("v", [3.0, 1.0], [1.0, 3.0]).message
    assert "(1, 0)" in compare("A", [[1, 2], [9, 4]], truth).message


def test_hints_do_not_give_the_answer():
    for wrong in (-1.2345, 70.73, 0.1965, 9.0, "abc"):
        try:
            message = compare("x", wrong, 1.2345).message
        except TypeError as problem:
            message = str(problem)
        assert "1.2345" not in message


def test_choice_explains_the_wrong_word():
    assert choose("end", "Upper", "upper", {"lower": "That one shrinks."})
    wrong = choose("end", "lower", "upper", {"lower": "That one shrinks."})
    assert wrong.message.startswith("That")
    assert "one of lower, upper" in choose("end", "left", "upper", {"lower": "no"}).message


def test_every_check_takes_nonsense_without_an_error():
    assert exercises()
    for number in exercises():
        for nonsense in (None, "?", np.nan, [], {}, np.zeros((7, 3)), 1e300, object(), STATES):
            with warnings.catch_warnings(action="error"):
                verdict = pl.check(number, nonsense)
            assert isinstance(verdict, pl.Verdict)
            assert verdict.message and not re.search(r" at 0x|\n", verdict.message)
            assert verdict.right in (False, None), f"{number} takes {nonsense!r} for right"
            assert not verdict and not verdict.share


def test_a_check_of_ones_own_may_yield_what_is_wrong():
    def exercise_1(answer, rig=None):
        if answer < 0:
            yield """Lengths are
                positive."""
        return "So long."

    assert pl.check(exercise_1, 1) == pl.Verdict(True, "So long.")
    assert pl.check(exercise_1, -1) == pl.Verdict(False, "Lengths are positive.")


def test_more_answers_than_asked_for():
    assert pl.check("04.6", 1, 2).message == "Asked for: kp_max; given were 2 answers."


def test_unknown_exercise_names_the_known_ones():
    with pytest.raises(ValueError, match=r"no check for '99\.1'; there are"):
        pl.check("99.1", 1)


def test_my_rig_is_the_same_for_the_same_name_and_differs_between_names():
    assert pl.my_rig("Anna") == pl.my_rig(" anna ")
    assert pl.my_rig("Anna") != pl.my_rig("Bela")
    assert pl.my_rig(7, "triple").links[0] != pl.my_rig(7).links[0]
    # A fixed stream: this number must not change between machines and NumPy versions.
    assert pl.my_rig("anna").links[0].length == pytest.approx(0.1830, abs=2e-3)


@pytest.mark.parametrize("base", ["double", "triple"])
def test_my_rig_is_balanced_by_the_papers_weights_with_filters(base):
    paper = pl.paper_design(base)
    for who in range(60):
        design = Design(pl.my_rig(who, base), paper.Q, paper.R, paper.E, paper.kp)
        assert abs(pl.closed_loop_eigenvalues(design.filtered_loop)[0]) < 1


@pytest.mark.parametrize(
    "names",
    [
        ("Zoé", "Zoe\u0301"),
        ("Łukasz", " łukasz "),
        ("\uae40\uc9c0", "\u1100\u1175\u11b7\u110c\u1175"),
        ("İnci", "I\u0307nci"),
    ],
)
def test_my_rig_knows_one_student_however_the_name_is_typed(names):
    one, other = map(pl.my_rig, names)
    assert one == other


@pytest.mark.parametrize("who", [None, True, ["Ada"], 1j])
def test_my_rig_wants_a_name(who):
    with pytest.raises(TypeError, match="who: expected a name or a"):
        pl.my_rig(who)


def test_my_rig_bad_input():
    with pytest.raises(ValueError, match="who"):
        pl.my_rig(" ")
    with pytest.raises(ValueError, match="spread"):
        pl.my_rig("a", spread=0.5)


# ---- Shares of the points


def test_two_values_are_taken_apart():
    right, wrong = compare("a", 2.0, 2.0), compare("b", 7.0, 2.0)
    assert (right.share, wrong.share) == (1, 0)
    assert all_right(right, right).share == 1 and all_right(right, right)
    half = all_right(right, wrong)
    assert half.share == 0.5 and not half and half.message == wrong.message
    assert all_right(half, right, right).share == pytest.approx(5 / 6)


@pytest.mark.parametrize("nonsense", [..., None, "?", {}, 1j, np.nan])
def test_nonsense_for_one_value_leaves_the_other_its_share(nonsense):
    own = pl.my_rig("Ada")
    rotor = own.motors[0].inertia / own.motors[0].ratio ** 2
    verdict = pl.check("02.1", rotor, nonsense, rig=own)
    assert verdict.share == 0.5 and not verdict
    assert pl.check("03.5", 1.5, nonsense).share == pl.check("03.5", nonsense, -0.5).share == 0.5


def test_entries_that_are_answers_of_their_own_earn_their_shares():
    assert compare("delays", [1, 2, 5], [1, 2, 3], apart=True).share == pytest.approx(2 / 3)
    assert compare("delays", [1, 2, 5], [1, 2, 3]).share == 0
    assert compare("delays", [1, 2], [1, 2, 3], apart=True).share == 0
    assert pl.check("04.5", (1, 0, 7)).share == pytest.approx(2 / 3)


def test_nbgrader_gets_points_and_a_student_a_verdict(monkeypatch, capsys):
    rates = np.linalg.eigvals(pl.linearize(pl.load("double")).A).real
    half = np.log(30) / rates.max(), 1.0
    assert isinstance(pl.check("02.2", *half, points=3), pl.Verdict)
    assert capsys.readouterr().out == ""
    monkeypatch.setenv("NBGRADER_EXECUTION", "autograde")
    assert repr(pl.check("02.2", *half, points=3)) == "1.5"
    assert capsys.readouterr().out.startswith("Not yet: t_triple")
    assert repr(pl.check("02.2", None, points=3)) == "0.0"


def test_a_warning_in_an_answer_costs_nothing(monkeypatch, capsys):
    """nbgrader gives no points to a check cell that writes to stderr."""
    monkeypatch.setenv("NBGRADER_EXECUTION", "autograde")

    def alias(f, dt):
        print("careful", file=sys.stderr)
        return abs(f - round(f * dt) / dt)

    assert pl.check("hw1.2", alias, points=4) == 4
    assert capsys.readouterr().err == ""
