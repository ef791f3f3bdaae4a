"""Admissible pushes: brackets that hold, and forces as torques."""

import numpy as np
import pytest

import pendlab as pl
from pendlab.studies.pushes import _bisect, _bracket, _pulses


@pytest.fixture(scope="module")
def double():
    return pl.paper_design("double")


def falls(design, link, length, height, **more):
    pulse = pl.Pulse(link, 3.0, length, height)
    return pl.simulate(design.rig, design.controller, 10, disturbance=pulse, **more).fell


def test_limit_lies_between_what_recovers_and_what_falls(double):
    found = pl.largest_pulses(double.rig, double.controller, [0.05, 0.3], accuracy=0.05)
    assert found.heights.shape == (2, 2)
    for link in (1, 2):
        for j, length in enumerate(found.lengths):
            height = found.heights[link - 1, j]
            assert not falls(double, link, length, height)
            assert not falls(double, link, length, -height)
            assert falls(double, link, length, 1.06 * height) or falls(
                double, link, length, -1.06 * height
            )


def test_search_ends_as_close_as_asked_below_each_limit():
    """Against limits that are known, from none at all to far beyond the first try."""
    limits = np.array([0.0, 3e-13, 0.07, 0.1, 0.11, 5.0, 1e10])

    def recovers(heights, which):
        return which & (heights < limits)

    low, high = _bracket(recovers, len(limits))
    np.testing.assert_array_equal(high, np.where(low > 0, 2 * low, 0.1))
    assert np.all((low < limits) & (limits <= high) | (low == 0) & (limits <= 0.1))
    low, high = _bisect(recovers, low, high, 0.02)
    assert np.all(low[1:] < limits[1:]) and np.all(limits <= high)
    assert np.all(high - low <= np.where(limits > 0, 0.02 * high, 1e-15)) and np.all(low[1:] > 0)


def test_search_for_a_limit_that_is_none_ends():
    tried = []

    def recovers(heights, which):
        tried.append(heights.copy())
        return which

    with pytest.raises(ValueError, match="not enough to make the rig fall in time"):
        _bracket(recovers, 1)
    np.testing.assert_array_equal(np.ravel(tried), 0.1 * 2.0 ** np.arange(40))


def test_a_push_is_a_pulse_on_every_link_that_its_lever_turns():
    pulses = _pulses(np.array([0.5, 0.0, 2.0]), 0.2, -1, 3.0, 1.0)
    assert pulses == [pl.Pulse(1, 1.0, 0.2, -1.5), pl.Pulse(3, 1.0, 0.2, -6.0)]


def test_short_pulses_count_by_their_impulse(double):
    """A pulse much shorter than the fall acts like a kick: height times length decides."""
    found = pl.largest_pulses(double.rig, double.controller, [0.005, 0.01], accuracy=0.01)
    assert found.impulses[:, 0] == pytest.approx(found.impulses[:, 1], rel=0.05)


def test_filters_cost_some_of_it(double):
    ideal, filtered = (
        pl.largest_pulses(double.rig, double.controller, [0.1], imperfections=imperfections)
        for imperfections in (None, pl.Imperfections(filters=True))
    )
    assert np.all(filtered.heights < ideal.heights)


def test_force_turns_every_link_below():
    rig = pl.load("triple")
    l1, l2 = rig.links[0].length, rig.links[1].length
    levers = pl.force_levers(rig)
    assert levers[2] == pytest.approx([l1, l2, rig.links[2].com])
    assert np.all(np.triu(levers, 1) == 0)


def test_force_levers_are_the_work_of_a_force():
    """Row i is the derivative of the horizontal position of link i's centre of mass."""
    rig = pl.load("triple")
    for i, row in enumerate(pl.force_levers(rig)):
        for k in range(3):
            theta = np.zeros(3)
            theta[k] = 1e-6
            x = sum(rig.links[j].length * np.sin(theta[j]) for j in range(i))
            x += rig.links[i].com * np.sin(theta[i])
            assert row[k] == pytest.approx(x / 1e-6, abs=1e-9)


def test_rig_that_falls_by_itself_is_named(double):
    with pytest.raises(ValueError, match="falls without any push"):
        pl.largest_pulses(double.rig, double.controller, [0.1], initial=(0.5, 0.0))


def test_lengths_must_be_positive(double):
    with pytest.raises(ValueError, match="lengths"):
        pl.largest_pulses(double.rig, double.controller, [0.0])


@pytest.mark.parametrize("wrong", [dict(accuracy=1e-17), dict(accuracy=1.0), dict(recovery=0)])
def test_no_search_without_end_or_sense(double, wrong):
    (name,) = wrong
    with pytest.raises(ValueError, match=f"^{name}: expected"):
        pl.largest_pulses(double.rig, double.controller, [0.1], **wrong)


def test_a_kick_of_a_microsecond_is_bracketed_too(double):
    """Its impulse is that of a longer one."""
    short, kick = (
        pl.largest_pulses(double.rig, double.controller, [t], recovery=3.0).impulses
        for t in (1e-3, 1e-6)
    )
    assert kick == pytest.approx(short, rel=0.05)


def test_no_answer_is_no_number(double):
    """Too little time to fall in, or a lever that turns nothing: a sentence, never the last try."""
    run = dict(rig=double.rig, controller=double.controller, lengths=[0.05])
    with pytest.raises(ValueError, match="not enough to make the rig fall in time"):
        pl.largest_pulses(**run, recovery=1e-3)
    with pytest.raises(ValueError, match=r"levers: .* that turn a link each"):
        pl.largest_pulses(**run, levers=[[1.0, 0.0], [0.0, 0.0]])


def test_levers_are_only_a_unit(double):
    """Heights in a unit a billion times smaller or larger are the same pushes."""
    run = dict(rig=double.rig, controller=double.controller, lengths=[0.05], recovery=3.0)
    torque = pl.largest_pulses(**run).heights
    for unit in (1e-6, 1e9):
        heights = unit * pl.largest_pulses(**run, levers=unit * np.eye(2)).heights
        assert heights == pytest.approx(torque, rel=0.03)
