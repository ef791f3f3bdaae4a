"""Units and coordinates decide nothing: each state in units of its own, apart by many decades."""

import dataclasses

import control
import numpy as np
import pytest

import pendlab as pl

CLOSED = pl.closed_loop(pl.paper_design("triple"))


def in_other_units(system, decades, seed=0):
    """The same system, states in units that differ by powers of two, up to `decades` decades."""
    exponents = np.random.default_rng(seed).uniform(-1, 1, system.nstates)
    unit = 2.0 ** np.round(decades * np.log2(10) / 2 * exponents)
    A = system.A * unit[:, None] / unit
    return control.ss(A, system.B * unit[:, None], system.C / unit, system.D, system.dt)


@pytest.mark.parametrize("decades", [4, 8, 12, 24])
def test_rms(decades):
    assert pl.rms(in_other_units(CLOSED, decades)) == pytest.approx(pl.rms(CLOSED), rel=1e-9)


@pytest.mark.parametrize("decades", [4, 8, 12, 24])
def test_peak_gain(decades):
    value, omega = pl.peak_gain(CLOSED)
    other, there = pl.peak_gain(in_other_units(CLOSED, decades))
    assert other == pytest.approx(value, rel=1e-6) and there == pytest.approx(omega, rel=1e-3)


@pytest.mark.parametrize("decades", [4, 8, 12, 24])
def test_margins(decades):
    loop = pl.paper_design("triple").filtered_loop
    ours, other = (pl.structured_margin(x).value for x in (loop, in_other_units(loop, decades)))
    assert other == pytest.approx(ours, rel=1e-6)
    ours, other = (
        pl.margins(pl.broken_at(x, 0)).modulus for x in (loop, in_other_units(loop, decades))
    )
    assert other == pytest.approx(ours, rel=1e-6)


def test_rms_of_any_size():
    unit = pl.rms(CLOSED)
    assert pl.rms(CLOSED, 1e200) == pytest.approx(1e200 * unit)
    assert pl.rms(CLOSED, 1e-200) == pytest.approx(1e-200 * unit)
    assert np.all(pl.rms(CLOSED, 0.0) == 0)


def test_distance_to_uncontrollability_scales_with_the_pair():
    A, B = pl.in_units(pl.linearize(pl.load("double")), 0.1, 0.2, (9.0,))
    distance, s = pl.distance_to_uncontrollability(A, B)
    for factor in (1e-150, 1e150):
        scaled, there = pl.distance_to_uncontrollability(factor * A, factor * B)
        assert scaled == pytest.approx(factor * distance, rel=1e-6)
        assert there.real == pytest.approx(factor * s.real, rel=1e-4)


def test_a_direction_is_the_same_whatever_its_length():
    rig = pl.load("triple")
    tilt = pl.recoverable_tilt(rig)
    for length in (1e-9, 1e9):
        direction = length * np.eye(6)[0]
        assert length * pl.recoverable_tilt(rig, direction) == pytest.approx(tilt, rel=1e-6)


def test_effort_does_not_depend_on_the_unit_of_voltage():
    """Half the limit costs four times the effort, however large the unit of the voltage is."""
    rig, lean = pl.load("triple"), [0.05, 0, 0, 0, 0, 0]
    effort = pl.least_effort(rig, lean)
    for unit in (1e-9, 1e9):
        limits = tuple(unit * limit for limit in rig.u_max)
        scaled = pl.least_effort(dataclasses.replace(rig, u_max=limits), lean)
        assert scaled * unit**2 == pytest.approx(effort, rel=1e-9)
