"""Times of control steps: what a median must obey on any machine."""

from time import perf_counter

import pytest

import pendlab as pl


@pytest.mark.parametrize("repeat", [1, 300])
def test_half_of_the_steps_take_at_least_the_median(double_design, repeat):
    begun = perf_counter()
    times = pl.step_times(double_design.controller, repeat)
    elapsed = perf_counter() - begun
    assert 0 < repeat / 2 * (times.to_send + times.to_end) <= elapsed


@pytest.mark.parametrize("repeat", [0, 100_001, 2.5])
def test_how_many_steps(double_design, repeat):
    with pytest.raises(ValueError, match="repeat: expected a whole number from 1 to 100000"):
        pl.step_times(double_design.controller, repeat)
