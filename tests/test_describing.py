"""Harmonic balance of gears: describing functions against integrals, cycles against the simulator."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import OptimizeResult

import pendlab as pl
from pendlab.studies.describing import _twist, at_the_gears, play


def first_harmonic(answer, amplitude):
    """2/a times the mean of answer times cosine: the definition."""
    psi = np.linspace(0, 2 * np.pi, 200_000, endpoint=False)
    return 2 * np.mean(answer(amplitude * np.cos(psi)) * np.cos(psi)) / amplitude


@pytest.mark.parametrize("amplitude", [0.02, 0.026, 0.04, 0.5])
def test_play_is_the_first_harmonic_of_a_dead_zone(amplitude):
    def spring(x):
        return 200 * np.sign(x) * np.maximum(np.abs(x) - 0.025, 0)

    expected = first_harmonic(spring, amplitude)
    assert play(amplitude, 0.05, 200.0) == pytest.approx(expected, rel=1e-4, abs=1e-9)


def test_twist_is_the_inverse_of_the_torque_that_play_passes():
    for torque in np.geomspace(1e-3, 1e3, 30):
        twist = _twist(torque, 0.05, 200.0)
        assert twist > 0.025
        assert play(twist, 0.05, 200.0) * twist == pytest.approx(torque, rel=1e-4)


@pytest.fixture(scope="module")
def double():
    return pl.paper_design("double")


def cycle(run):
    late = run.t >= 15
    bend = run.angles[late, 1] - run.angles[late, 1].mean()
    up = np.flatnonzero((bend[:-1] < 0) & (bend[1:] >= 0))
    return (len(up) - 1) / (run.dt * np.ptp(up)), np.ptp(bend) / 2


def test_a_soft_gear_swings_as_predicted(double):
    """A soft contact keeps the twist near a cosine: where the method is good, it must be good."""
    gear = pl.Imperfections(filters=True, gap=0.05, contact_stiffness=20.0, contact_damping=0.0)
    (predicted,) = pl.limit_cycles(double, gear)
    run = pl.simulate(double.rig, double.controller, 30, [0.01, -0.01], imperfections=gear)
    hertz, size = cycle(run)
    assert predicted.hertz == pytest.approx(hertz, rel=0.06)
    assert predicted.joints[0] == pytest.approx(size, rel=0.05)


@pytest.mark.parametrize("gap, dry", [(0.05, 0.0), (0.05, 0.5), (0.02, 1.5), (0.0, 1.0)])
def test_every_cycle_of_one_gear_balances_the_rotor(double, gap, dry):
    """(I s^2 + c s) phi + j (4 F/pi) phi/|phi| = drive, with the torque through the gear as phase 0."""
    motor, stiffness = double.rig.motors[0], 50.0
    gear = pl.Imperfections(gap=gap, contact_stiffness=stiffness, gear_friction=dry)
    cycles = pl.limit_cycles(double, gear)
    assert cycles and [c.hertz for c in cycles] == sorted(c.hertz for c in cycles)
    for cycle in cycles:
        s = 2j * np.pi * cycle.hertz
        joints, drives = (
            part.item() for part in at_the_gears(double.controller, double.rig, [s.imag])
        )
        twist = cycle.twists[0]
        tau = play(twist, gap, stiffness) * twist if gap else cycle.joints[0] / abs(joints)
        assert abs(joints) * tau == pytest.approx(cycle.joints[0], rel=1e-3)
        phi = joints * tau + twist
        terms = (motor.inertia * s**2 + motor.damping * s) * phi, 4j * dry / np.pi * phi / abs(phi)
        assert abs(sum(terms) - drives * tau) < 1e-3 * max(map(abs, (*terms, drives * tau)))


@pytest.mark.parametrize("missing, found", [(1e-8, True), (1e-6, False)])
def test_what_does_not_balance_is_no_cycle(double, monkeypatch, missing, found):
    def stopped(function, start, args):
        return OptimizeResult(x=start, fun=np.array([0.0, missing]))

    monkeypatch.setattr("pendlab.studies.describing.root", stopped)
    assert bool(pl.limit_cycles(double, pl.Imperfections(gap=0.05))) is found


def test_size_scales_with_the_gap_and_the_frequency_does_not(double):
    small, large = (
        pl.limit_cycles(double, pl.Imperfections(gap=gap, contact_stiffness=50.0))[0]
        for gap in (0.02, 0.04)
    )
    assert large.joints[0] == pytest.approx(2 * small.joints[0], rel=1e-3)
    assert large.hertz == pytest.approx(small.hertz, rel=1e-4)


def test_friction_alone_scales_with_the_torque(double):
    weak, strong = (
        pl.limit_cycles(double, pl.Imperfections(gear_friction=torque))[0] for torque in (0.5, 1.0)
    )
    assert strong.joints[0] == pytest.approx(2 * weak.joints[0], rel=1e-4)
    assert strong.hertz == pytest.approx(weak.hertz, rel=1e-4)
    assert strong.twists == (0.0,)


def test_linear_gears_have_no_cycle(double):
    assert pl.limit_cycles(double, pl.Imperfections()) == []


def test_gear_2_sticks_while_the_triple_hunts():
    triple = pl.paper_design("triple")
    dry = replace(pl.bench_imperfections(triple.rig), gap=0.0)
    (hunting,) = pl.limit_cycles(triple, dry, rig=pl.bench_rig(triple.rig))
    assert hunting.joints[1] == pytest.approx(0, abs=1e-6) and hunting.joints[0] > 0.02


def test_what_is_no_design_or_has_no_filters_is_named(double):
    with pytest.raises(TypeError, match=r"design: expected a pl\.Design"):
        pl.limit_cycles(double.rig, pl.Imperfections())
    with pytest.raises(ValueError, match="filters are None"):
        pl.limit_cycles(double, pl.Imperfections(gap=0.05), rig=replace(double.rig, filters=None))
