"""What would keep a simulation busy for ever gets a sentence, or the answer of its limit."""

import dataclasses

import numpy as np
import pytest

import pendlab as pl

DESIGN = pl.paper_design("double")


def simulate(t_end=1.0, **changes):
    good = dict(rig=DESIGN.rig, controller=DESIGN.controller, initial=(0.02, 0.0))
    return pl.simulate(**good | changes, t_end=t_end)


@pytest.mark.parametrize("changes, message", [
    (dict(inner_step=1e-12), r"inner_step: .* at most 20,000,000 steps .* 1e-12 s .* at least 5.1e-08"),
    (dict(inner_step=1e-300), "inner_step: .* at most 20,000,000 steps"),
    (dict(t_end=1e12), r"t_end: expected less than 10000 s, a million samples of 0\.01 s"),
    (dict(t_end=1e308), "t_end: expected less than"),
    (dict(imperfections=pl.Imperfections(gap=0.05, contact_stiffness=1e15)),
     "imperfections, dt: .* steps of integration, found a motion of .* softer contact"),
    (dict(imperfections=pl.Imperfections(gear_friction=1e12)), "imperfections, dt: .* steps"),
    (dict(imperfections=pl.Imperfections(gap=0.05, contact_stiffness=1e308)),
     "imperfections, dt: .* steps"),
])  # fmt: skip
def test_endless_runs_are_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        simulate(**changes)


@pytest.mark.parametrize("hertz", [3.5e3, 1e9, 1e300])
def test_a_filter_faster_than_any_motion_is_none(hertz):
    rig = dataclasses.replace(DESIGN.rig, filters=pl.Filters((hertz,), (hertz,) * 3))
    fast = simulate(rig=rig, imperfections=pl.Imperfections(filters=True))
    none = simulate()
    np.testing.assert_array_equal(fast.angles, none.angles)


def test_filters_approach_none_as_they_become_fast():
    # A lag of 1/(2 pi f) at each end: the difference shrinks in proportion.
    none, apart = simulate(0.3), []
    for hertz in (250.0, 500.0, 1000.0, 3000.0):
        rig = dataclasses.replace(DESIGN.rig, filters=pl.Filters((hertz,), (hertz,) * 3))
        run = simulate(0.3, rig=rig, imperfections=pl.Imperfections(filters=True))
        apart.append(hertz * np.abs(run.angles - none.angles).max())
    assert max(apart) < 1.2 * min(apart)
