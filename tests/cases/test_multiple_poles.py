"""Several poles at one point of the unit circle, in any coordinates: the right count or a sentence."""

import control
import numpy as np
import pytest
from scipy.linalg import block_diag

import pendlab as pl
from pendlab.loop import on_circle

DT = 0.01


def chain(k):
    """k integrators one behind the other: a single Jordan block at z = 1."""
    return np.eye(k) + DT * np.eye(k, k=1)


ROTATION = np.array([[np.cos(0.3), -np.sin(0.3)], [np.sin(0.3), np.cos(0.3)]])
OPENED = {
    "double": (chain(2), 0),
    "triple": (chain(3), 0),
    "fourfold": (chain(4), 0),
    "double at -1": (-chain(2), 0),
    "double pair": (np.kron(np.eye(2), ROTATION) + np.eye(4, k=2), 0),
    "double and unstable": (block_diag(chain(2), [[1.2]]), 1),
    "double and stable": (block_diag(chain(2), [[0.5]]), 0),
    "double and slowly unstable": (block_diag(chain(2), [[1.00001]]), 1),
}


@pytest.mark.parametrize("name", OPENED)
def test_count_or_sentence(name):
    A, outside = OPENED[name]
    n, counted = len(A), 0
    rng = np.random.default_rng(3)
    for _ in range(40):
        X = rng.standard_normal((n, n))
        B, C = rng.standard_normal((n, 1)), rng.standard_normal((1, n)) * 10 ** rng.uniform(-3, 0)
        closed = np.abs(np.linalg.eigvals(A - B @ C))  # in the coordinates that show the poles
        loop = control.ss(X @ A @ np.linalg.inv(X), X @ B, C @ np.linalg.inv(X), 0, DT)
        try:
            count = pl.encirclements(loop)
        except ValueError as problem:
            assert str(problem).startswith("loop: ")
            continue
        counted += 1
        assert count.unstable_open == outside
        assert count.unstable_closed == np.sum(closed > 1)
        assert count.turns == outside - count.unstable_closed
    assert counted >= 30, "a sentence is for the few that rounding hides"


@pytest.mark.parametrize("others", [(), (0.995,), (0.993, 1.004)])
@pytest.mark.parametrize("k", [1, 2, 3, 4])
def test_on_circle_puts_back_what_rounding_moved(k, others):
    """k poles at 1, whatever stands close to them."""
    n = k + len(others)
    X = np.random.default_rng(k).standard_normal((n, n))
    values = on_circle(X @ block_diag(chain(k), np.diag(others)) @ np.linalg.inv(X))
    distances = np.sort(np.abs(values - 1))
    np.testing.assert_allclose(distances[:k], 0, atol=1e-12)
    np.testing.assert_allclose(distances[k:], np.sort(np.abs(np.array(others) - 1)), atol=1e-6)


def close_to_a_chain(k, away):
    """k integrators in a row and a pole this far outside the circle, in coordinates that hide them."""
    X = np.random.default_rng(k).standard_normal((k + 1, k + 1))
    return X @ block_diag(chain(k), [[1 + away]]) @ np.linalg.inv(X)


@pytest.mark.parametrize("away", [1e-2, 1e-3, 1e-4, 1e-5, 1e-6])
@pytest.mark.parametrize("k", [2, 3])
def test_a_pole_close_to_several_at_1_is_told_from_them_or_a_sentence(k, away):
    """Never a wrong count; a sentence only where rounding moves the chain about as far."""
    A = close_to_a_chain(k, away)
    moved, counted = np.sort(np.abs(np.linalg.eigvals(A) - 1))[k - 1], 0
    rng = np.random.default_rng(7)
    for _ in range(20):
        B, C = rng.standard_normal((k + 1, 1)), rng.standard_normal((1, k + 1))
        loop = control.ss(A, B, C, 0, DT)
        closed = np.abs(np.linalg.eigvals(A - B @ C))
        if np.abs(closed - 1).min() < away / 100:
            continue
        try:
            count = pl.encirclements(loop)
        except ValueError as problem:
            assert str(problem).startswith("loop: ")
            continue
        counted += 1
        assert (count.unstable_open, count.unstable_closed) == (1, np.sum(closed > 1))
        assert count.turns == 1 - count.unstable_closed
    assert counted >= 15 or away < 100 * moved


def test_on_circle_leaves_what_is_near_it():
    values = np.array([1 + 1e-5, 1 - 1e-5, 1 - 2e-5, 0.9999, 1.0000097])
    np.testing.assert_array_equal(on_circle(np.diag(values)), values)


def test_margins_of_a_double_integrator_do_not_depend_on_coordinates():
    """No spurious crossings where the response is rounding only."""
    A, B, C = chain(2), np.array([[0.0], [1.0]]), np.array([[2.0, 0.3]])
    plain = pl.margins(control.ss(A, B, C, 0, DT))
    X = np.random.default_rng(5).standard_normal((2, 2))
    other = pl.margins(control.ss(X @ A @ np.linalg.inv(X), X @ B, C @ np.linalg.inv(X), 0, DT))
    assert len(other.crossover) == len(plain.crossover) == 1
    for name in ("gain_up", "gain_down", "phase", "modulus"):
        assert getattr(other, name) == pytest.approx(getattr(plain, name), rel=1e-6), name


@pytest.mark.parametrize("factor", [1 - 1e-12, 1.0, 1 + 1e-12])
def test_closed_loop_poles_on_the_circle_are_a_sentence(factor):
    """In coordinates that round them off it: the curve goes through the critical point."""
    X = np.array([[1.0, 300.0], [0.1, 31.0]])
    B = X @ np.array([[1.0], [1.0]])
    C = factor * np.array([[0.5, 0.0]]) @ np.linalg.inv(X)
    loop = control.ss(X @ np.diag([1.5, 0.3]) @ np.linalg.inv(X), B, C, 0, DT)
    with pytest.raises(ValueError, match="loop: "):
        pl.encirclements(loop)
