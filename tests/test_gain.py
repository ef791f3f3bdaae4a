"""The regulator: Riccati residual, optimality, stability, and every weight that cannot work."""

import control
import numpy as np
import pytest
import scipy.linalg
from hypothesis import given
from hypothesis import strategies as st
from strategies import decades, full_weights, rigs, weights

import pendlab as pl
from pendlab.gain import unmoved_modes


@st.composite
def problems(draw):
    """A random rig's sampled model with its integrator, and weights of either form."""
    rig = draw(rigs(n_links=st.integers(2, 3), least_motors=2))
    model = pl.add_integrator(pl.sample(pl.linearize(rig)), 1)
    n, m = model.nstates, model.ninputs
    if draw(st.booleans()):
        return model, draw(weights(n)), draw(weights(m))
    return model, draw(full_weights(n)), draw(full_weights(m))


def matrix(weight):
    return np.diag(weight) if np.ndim(weight) < 2 else np.asarray(weight)


@given(problems())
def test_gain_solves_the_riccati_equation_and_stabilises(problem):
    """The cost X of using F, from a Lyapunov equation, has F as its own best gain.

    X = (A-BF)'X(A-BF) + Q + F'RF with (R + B'XB) F = B'XA is the Riccati equation.
    """
    model, Q, R = problem
    A, B = model.A, model.B
    F = pl.lqr(model, Q, R)
    Q, R = matrix(Q), matrix(R)
    closed = A - B @ F
    assert np.abs(np.linalg.eigvals(closed)).max() < 1
    X = scipy.linalg.solve_discrete_lyapunov(closed.T, Q + F.T @ R @ F)
    assert np.linalg.eigvalsh((X + X.T) / 2)[0] > 0
    left, right = (R + B.T @ X @ B) @ F, B.T @ X @ A
    terms = (R + np.abs(B.T) @ np.abs(X) @ np.abs(B)) @ np.abs(F)
    assert np.abs(left - right).max() < 1e-6 * terms.max()
    theirs = scipy.linalg.solve_discrete_are(A, B, Q, R)
    theirs = np.linalg.solve(R + B.T @ theirs @ B, B.T @ theirs @ A)
    np.testing.assert_allclose(F, theirs, atol=1e-6 * np.abs(theirs).max())


@given(rigs(n_links=st.integers(2, 3)), decades(-2, 2))
def test_one_motor_is_enough(rig, weight):
    model = pl.add_integrator(pl.sample(pl.linearize(rig)), 1)
    F = pl.lqr(model, np.ones(model.nstates), np.full(rig.n_motors, weight))
    assert np.abs(np.linalg.eigvals(model.A - model.B @ F)).max() < 1


def cost(model, F, Q, R):
    """trace X with X = (A-BF)'X(A-BF) + Q + F'RF: the sum of costs from unit initial states."""
    closed = model.A - model.B @ F
    if np.abs(np.linalg.eigvals(closed)).max() >= 1:
        return np.inf
    return np.trace(scipy.linalg.solve_discrete_lyapunov(closed.T, Q + F.T @ R @ F))


def test_no_other_gain_costs_less(design):
    model, Q, R = design.augmented, np.diag(design.Q), np.diag(design.R)
    F = pl.lqr(model, design.Q, design.R)
    least = cost(model, F, Q, R)
    rng = np.random.default_rng(0)
    for size in (1e-2, 1e-1):
        for _ in range(20):
            other = F * (1 + size * rng.standard_normal(F.shape))
            assert cost(model, other, Q, R) > least


def test_diagonal_and_matrix_weights_agree(design):
    F = pl.lqr(design.augmented, np.diag(design.Q), np.diag(design.R))
    np.testing.assert_array_equal(F, design.F)


@given(decades(-3, 3))
def test_only_the_ratio_of_weights_counts(factor):
    design = pl.paper_design("double")
    Q, R = factor * np.array(design.Q), factor * np.array(design.R)
    np.testing.assert_allclose(pl.lqr(design.augmented, Q, R), design.F, rtol=1e-6)


def test_first_order_in_closed_form():
    """x+ = a x + b u: X solves X = a^2 X - (a b X)^2/(r + b^2 X) + q, a quadratic."""
    a, b, q, r = 1.2, 0.5, 2.0, 3.0
    p = r * (1 - a**2) - q * b**2
    X = (-p + np.sqrt(p**2 + 4 * b**2 * q * r)) / (2 * b**2)
    model = control.ss([[a]], [[b]], [[1]], 0, 0.1)
    assert pl.lqr(model, q, r).item() == pytest.approx(a * b * X / (r + b**2 * X), rel=1e-12)
    # Without any weight of the state the eigenvalue is mirrored in the circle: least voltage.
    assert a - b * pl.lqr(model, 0, r).item() == pytest.approx(1 / a, rel=1e-12)


def test_continuous_model(triple):
    plant = pl.linearize(triple)
    F = pl.lqr(plant, np.ones(6), np.ones(2))
    X = scipy.linalg.solve_continuous_are(plant.A, plant.B, np.eye(6), np.eye(2))
    np.testing.assert_allclose(F, plant.B.T @ X, rtol=1e-6, atol=1e-6)
    assert np.linalg.eigvals(plant.A - plant.B @ F).real.max() < 0


def test_rounding_in_a_symmetric_matrix_is_forgiven(double_design):
    Q = np.diag(double_design.Q)
    Q[0, 1], Q[1, 0] = 0.1, 0.1 * (1 + 1e-12)
    assert pl.lqr(double_design.augmented, Q, 1.0).shape == (1, 5)


def test_unmoved_modes_are_found():
    A, B = np.diag([1.5, 0.5, 2.0]), np.array([[1.0], [0.0], [1.0]])
    X = np.random.default_rng(3).standard_normal((3, 3))
    np.testing.assert_allclose(unmoved_modes(X @ A @ np.linalg.inv(X), X @ B), [0.5], rtol=1e-9)


@given(rigs())
def test_every_rig_can_be_moved(rig):
    """Popov-Belevitch-Hautus: one motor is enough, whatever the number of links."""
    plant = pl.linearize(rig)
    assert len(unmoved_modes(plant.A, plant.B)) == 0


def test_not_stabilisable():
    stuck = control.ss(np.diag([1.1, 0.5]), [[0.0], [1.0]], np.eye(2), 0, 0.01)
    with pytest.raises(ValueError, match=r"not stabilisable, no input moves the mode at 1\.1"):
        pl.lqr(stuck, [1, 1], 1)
    falling = control.ss(np.diag([1.1, 0.5]), [[1.0], [0.0]], np.eye(2), 0, 0.01)
    assert pl.lqr(falling, [1, 1], 1).shape == (1, 2), "an unmoved mode may decay by itself"
    with pytest.raises(ValueError, match="not stabilisable"):
        pl.lqr(control.ss([[0.0]], [[0.0]], [[1]], 0), 1, 1)


def test_two_integrators_of_one_motor_are_not_stabilisable(double_design):
    both = pl.add_integrator(double_design.model, [0, 1])
    with pytest.raises(ValueError, match="model: not stabilisable, no input moves the mode at 1"):
        pl.lqr(both, np.ones(6), 1)


@pytest.mark.parametrize(
    "Q, R, error, message",
    [
        ([1, 1, 1, 1, -1], 1, ValueError, "Q: expected a positive semidefinite .* eigenvalue -1"),
        ([1e-15, 0, 0, 0, -1e-15], 1, ValueError, "Q: expected a positive semidefinite"),
        ([1, 1, 1, 1, 1], 0, ValueError, "R: expected a positive definite .* eigenvalue 0"),
        ([1, 1, 1, 1, 1], -2, ValueError, "R: expected a positive definite .* eigenvalue -2"),
        ([1, 1, 1, 1], 1, ValueError, r"Q: expected shape 5, found shape \(4,\)"),
        (np.eye(4), 1, ValueError, r"Q: expected shape 5 x 5, found shape \(4, 4\)"),
        ([1, 1, 1, 1, 1], [1, 1], ValueError, r"R: expected shape 1, found shape \(2,\)"),
        (np.eye(5) + np.eye(5, k=1), 1, ValueError, r"Q: expected a symmetric .* use \(Q \+ Q.T\)"),
        ([1, 1, np.nan, 1, 1], 1, ValueError, "Q: every entry must be finite"),
        ([1, 1, 1, 1, 1], np.inf, ValueError, "R: every entry must be finite"),
        (
            [1, 1, 1, 1, 0],
            1,
            ValueError,
            "Q: no weight sees the mode at 1.* integrator needs a wei",
        ),
        (["a", 1, 1, 1, 1], 1, TypeError, "Q: expected an array of real numbers"),
        ([[1, 2], [3]], 1, TypeError, "Q: expected an array of real numbers"),
        (np.ones(5) * 1j, 1, TypeError, "Q: expected an array of real numbers"),
        (np.ones(5, bool), 1, TypeError, "Q: expected an array of real numbers"),
    ],
)
def test_bad_weights(double_design, Q, R, error, message):
    with pytest.raises(error, match=message):
        pl.lqr(double_design.augmented, Q, R)


@pytest.mark.parametrize("size", [1e-6, 1.0, 1e6])
def test_an_eigenvalue_of_Q_is_negative_beyond_rounding_only(double_design, size):
    lean = np.diag([1.0, 1.0, 0.0, 1.0, 1.0])
    lean[2, 2] = -1e-13
    assert pl.lqr(double_design.augmented, size * lean, size).shape == (1, 5)
    lean[2, 2] = -1e-11
    with pytest.raises(ValueError, match="Q: expected a positive semidefinite"):
        pl.lqr(double_design.augmented, size * lean, size)


def test_asymmetry_beyond_rounding_is_refused(double_design):
    Q = np.diag([1.0, 2.0, 1.0, 1.0, 1.0])
    Q[0, 1], Q[1, 0] = 0.5, 0.5 * (1 + 1e-11)
    assert pl.lqr(double_design.augmented, Q, 1.0).shape == (1, 5)
    Q[1, 0] = 0.5 * (1 + 1e-8)
    with pytest.raises(ValueError, match="Q: expected a symmetric"):
        pl.lqr(double_design.augmented, Q, 1.0)


def test_a_mode_that_decays_slowly_may_be_unmoved_and_one_on_the_circle_may_not():
    for radius, works in ((1 - 1e-7, True), (1 - 1e-11, False), (1.0, False), (1 + 1e-7, False)):
        model = control.ss(np.diag([radius, 0.5]), [[0.0], [1.0]], np.eye(2), 0, 0.01)
        if works:
            assert pl.lqr(model, [1, 1], 1).shape == (1, 2)
        else:
            with pytest.raises(ValueError, match="not stabilisable"):
                pl.lqr(model, [1, 1], 1)


def test_a_mode_on_the_circle_must_be_seen_and_one_inside_or_outside_need_not():
    for radius, works in ((1 - 1e-6, True), (1 - 1e-11, False), (1.0, False), (1 + 1e-6, True)):
        model = control.ss(np.diag([radius, 0.5]), [[1.0], [1.0]], np.eye(2), 0, 0.01)
        if works:
            F = pl.lqr(model, [0, 1], 1)
            assert np.abs(np.linalg.eigvals(model.A - model.B @ F)).max() < 1
        else:
            with pytest.raises(ValueError, match="no weight sees the mode"):
                pl.lqr(model, [0, 1], 1)


@pytest.mark.parametrize("reach, moved", [(1e-7, True), (1e-11, False)])
def test_an_input_reaches_a_mode_or_rounding_does(reach, moved):
    A = np.diag([1.1, 0.5])
    for size in (1e-8, 1.0, 1e8):  # of the input: no matter
        assert (len(unmoved_modes(A, size * np.array([[reach], [1.0]]))) == 0) is moved


def test_model_must_be_a_state_space():
    with pytest.raises(TypeError, match=r"model: expected a control\.StateSpace"):
        pl.lqr(np.eye(2), [1, 1], 1)
