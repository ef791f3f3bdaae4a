"""Searches end: what refines, bisects or covers has a bound and says when it is met."""

import numpy as np
import pytest

import pendlab as pl

CHAIN = np.diag([1.0, 1.0, 1.0], 1)  # four states in a row


@pytest.mark.parametrize(
    "A, B",
    [
        (CHAIN, np.zeros((4, 1))),  # no input at all
        (CHAIN, np.eye(4)[:, :1]),  # three multiple modes out of reach
        (np.eye(3), np.ones((3, 1))),  # one input for three equal modes
        (np.diag([1.0, 2.0, 3.0]), np.array([[1.0], [1.0], [0.0]])),
        (np.zeros((2, 2)), np.zeros((2, 1))),
    ],
)
@pytest.mark.parametrize("size", [1e-12, 1.0, 1e12])
def test_an_uncontrollable_pair_has_distance_zero(A, B, size):
    distance, s = pl.distance_to_uncontrollability(size * A, size * B)
    assert distance <= 1e-9 * size
    shifted = np.hstack([size * A - s * np.eye(len(A)), size * B])
    assert np.linalg.svd(shifted, compute_uv=False)[-1] <= 1e-9 * size


def test_a_tolerance_that_would_take_for_ever_is_refused():
    with pytest.raises(ValueError, match=r"tolerance: .* more than 100000 cells"):
        pl.distance_to_uncontrollability(CHAIN, np.eye(4)[:, 3:], tolerance=1e-12)


def test_units_that_would_take_for_ever_are_named():
    with pytest.raises(ValueError, match="angle, second: no distance in units of"):
        pl.controllability_measures(pl.load("double"), second=1e-3)


def test_a_pair_near_the_border_keeps_its_distance():
    """A mode that the input hardly moves: the distance is what moves it, down to 1e-8 of A."""
    for weak in (1e-3, 1e-6, 1e-8):
        distance, s = pl.distance_to_uncontrollability(np.diag([1.0, 3.0]), [[1.0], [weak]])
        assert distance == pytest.approx(weak * np.sqrt(4 / 5), rel=1e-3)
        assert s == pytest.approx(3, abs=1e-6)
