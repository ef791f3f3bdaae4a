"""Observers that need not know the input (H = TB = 0): when there are any, and the quietest one."""

import control
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import solve_discrete_are, solve_discrete_lyapunov

import pendlab as pl

NOISE = np.array([1e-3, 1e-3, 1e-3, 1e-2])  # rad and rad/s


def variances(model):
    return NOISE[-model.noutputs :] ** 2


def kalman_gain(model, W, V):
    """The current estimator's M."""
    P = solve_discrete_are(model.A.T, model.C.T, W, V)
    return np.linalg.solve(model.C @ P @ model.C.T + V, model.C @ P).T


def loop_with(design, observer, plant):
    return pl.open_loop(pl.controller(design.F, observer, design.dt, design.tracked, design.kp), plant)  # fmt: skip


def noise_of(design, observer):
    """RMS of the voltages under sensor noise, with the rig's filters."""
    P = pl.controller(design.F, observer, design.dt, design.tracked, design.kp).system
    G = design.filtered
    closed = control.ss(
        np.block([[G.A + G.B @ P.D @ G.C, G.B @ P.C], [P.B @ G.C, P.A]]),
        np.vstack([G.B @ P.D, P.B]),
        np.hstack([P.D @ G.C, P.C]),
        P.D,
        G.dt,
    )
    return pl.rms(closed, np.sqrt(variances(G)))


def test_as_many_inputs_as_outputs_with_the_zero_among_E():
    """A zero at 0.6 inside the circle: E = 0.6 gives an observer, and only that E."""
    model = control.ss([[1.2, 1], [0, 0.5]], [[0], [1]], [[0.6, 1]], 0, 0.01)
    observer = pl.observer_family(model, 0.6).best()
    assert np.all(observer.H == 0) and max(observer.residuals(model).values()) < 1e-12
    with pytest.raises(ValueError, match=r"every invariant zero .* must be an eigenvalue of E"):
        pl.observer_family(model, 0.4)
    F = pl.lqr(model, [1, 1], 1)
    recovered = pl.open_loop(pl.controller(F, observer, tracked=()), model)
    omega = np.geomspace(0.1, 300, 50)
    np.testing.assert_allclose(
        pl.frequency_response(recovered, omega),
        pl.frequency_response(pl.state_feedback_loop(model, F), omega),
        rtol=1e-9,
    )


def test_rank_of_CB_decides():
    """Two integrators, the position alone measured: CB = 0."""
    model = control.ss([[1, 0.01], [0, 1]], [[0], [0.01]], [[1, 0]], 0, 0.01)
    with pytest.raises(ValueError, match=r"rank CB must be 1, the number of inputs, found 0"):
        pl.observer_family(model, 0.5)
    with pytest.raises(ValueError, match=r"model: .* needs rank CB = 1, .* found 0"):
        pl.unknown_input_observer(model, 1e-6)


def test_a_zero_outside_the_circle_leaves_none():
    model = control.ss([[1.2, 1], [0, 0.5]], [[0], [1]], [[-0.3, 1]], 0, 0.01)  # zero at 1.5
    with pytest.raises(ValueError, match=r"model: .* invariant zero is not inside the unit circle"):
        pl.unknown_input_observer(model, 1e-6)


@given(st.integers(0, 2**32 - 1), st.floats(0.1, 0.8), st.booleans())
def test_dimension_exceeds_the_count_where_E_meets_a_zero(seed, zero, met):
    """p (q - m) iff no eigenvalue of E is an invariant zero: a plant made with a zero."""
    rng = np.random.default_rng(seed)
    # x1 is hidden from y until it moves x2: with y = [x2, x3], u into x2, the zero is A11.
    A = rng.standard_normal((3, 3))
    A[0, 0], A[2, 0], A[0, 2] = zero, 0.0, 1.0
    model = control.ss(A, [[0], [1], [0]], [[0, 1, 0], [0, 0, 1]], 0, 0.01)
    E = zero if met else zero / 2 - 0.5
    if np.abs(np.linalg.eigvals(A) - E).min() < 1e-3:
        return
    S = pl.observers.kronecker_matrix(A, model.B, model.C, np.array([[E]]))
    null = S.shape[1] - np.linalg.matrix_rank(S, tol=1e-9)
    assert null == 1 + met
    if met:
        assert pl.observer_family(model, E).dimension == 2


def test_process_noise_may_leave_states_alone(double_design):
    """Of variance zero where it enters nowhere; below zero it is none."""
    model, noise = double_design.model, np.array([1e-4, 0, 0, 0])
    calm, moved = (
        pl.unknown_input_observer(model, variances(model), process) for process in (None, noise)
    )
    assert np.abs(moved.K - calm.K).max() > 1e-3 * np.abs(calm.K).max()
    with pytest.raises(ValueError, match="noise, process: expected variances above zero"):
        pl.unknown_input_observer(model, variances(model), -noise)


@pytest.mark.parametrize("seed", range(5))
def test_unknown_input_observer_is_an_observer(rig, seed):
    model = pl.sample(pl.linearize(rig))
    V = np.random.default_rng(seed).uniform(1e-7, 1e-5, model.noutputs)
    observer = pl.unknown_input_observer(model, V)
    size = np.abs(observer.T).max() * np.abs(model.B).max()
    assert np.all(observer.H == 0) and np.abs(observer.T @ model.B).max() < 1e-10 * size
    gap = observer.T @ model.A - observer.E @ observer.T - observer.K @ model.C
    assert np.abs(gap).max() < 1e-10 * np.abs(observer.K).max()
    np.testing.assert_allclose(observer.L1 @ model.C + observer.L2 @ observer.T, np.eye(len(model.A)), atol=1e-12)  # fmt: skip


def test_it_is_the_recovery_limit_of_the_kalman_filter(design):
    """Process noise q BB': the gap falls like 1/q."""
    model, V = design.model, np.diag(variances(design.model))
    M = pl.unknown_input_observer(model, V).L1
    gaps = [np.abs(kalman_gain(model, q * model.B @ model.B.T, V) - M).max() for q in (1e2, 1e4)]
    assert gaps[1] < 2e-3 * np.abs(M).max() and gaps[1] == pytest.approx(gaps[0] / 100, rel=0.2)


def test_margins_are_those_of_state_feedback(design):
    observer = pl.unknown_input_observer(design.model, variances(design.model))
    loop = loop_with(design, observer, design.model)
    first = loop if loop.ninputs == 1 else pl.broken_at(loop, 0)
    ours, wanted = pl.margins(first), pl.margins(design.state_feedback_loop)
    for name in ("gain_up", "gain_down", "phase", "modulus"):
        assert getattr(ours, name) == pytest.approx(getattr(wanted, name), rel=1e-6), name
    assert pl.encirclements(loop).stable


def test_no_other_observer_with_H_zero_is_as_quiet(design):
    """Against members of the paper's family: variance of the estimate under the same noise.

    The unknown-input observer has the least trace of the covariance, for any choice of E.
    """

    def spread(observer):
        system = control.ss(observer.E, observer.K, observer.L2, observer.L1, 0.01)
        # Error of the estimate: noise through K and L1, the plant's part cancels.
        return np.sum(pl.rms(system, np.sqrt(variances(design.model))) ** 2)

    least = spread(pl.unknown_input_observer(design.model, variances(design.model)))
    rng = np.random.default_rng(2)
    for E in (0.3, 0.5, 0.7, 0.9, 0.95):
        family = pl.observer_family(design.model, E)
        for c in (family._best, *rng.standard_normal((10, family.dimension))):
            assert spread(family.member(c)) >= least * (1 - 1e-9)


def test_the_fourth_of_the_noise_at_the_same_margins(triple_design):
    """The minimal observer pays for its order and for E = 0.9, not for H = 0."""
    observer = pl.unknown_input_observer(triple_design.model, variances(triple_design.model))
    quiet, minimal = noise_of(triple_design, observer), noise_of(triple_design, triple_design.observer)  # fmt: skip
    assert quiet[0] < minimal[0] / 3


def test_each_is_best_under_its_own_process_noise(double_design):
    """Sum of the variances of the estimate's error: P = E P E' + T W T' + M V M'."""
    model = double_design.model
    V, shaking = variances(model), np.full(4, 1e-4)
    calm, shaken = (pl.unknown_input_observer(model, V, process=W) for W in (None, shaking))

    def error(o, W):
        noise = o.T @ np.diag(W) @ o.T.T + o.L1 @ np.diag(V) @ o.L1.T
        return np.trace(solve_discrete_lyapunov(o.E, noise))

    assert error(shaken, shaking) < error(calm, shaking)
    assert error(calm, np.zeros(4)) < error(shaken, np.zeros(4))


@pytest.mark.parametrize(
    "noise, process, message",
    [
        ([1, 1], None, r"noise: expected shape 3, found shape \(2,\)"),
        ([1, 1, 0], None, "noise, process: expected variances above zero"),
        ([1, 1, 1], [1, 1, 1, -1], "noise, process: expected variances above zero"),
        (None, None, "noise: expected an array of real numbers"),
        ([1, 1, np.nan], None, "noise: every entry must be finite"),
    ],
)
def test_bad_variances(double_design, noise, process, message):
    with pytest.raises((ValueError, TypeError), match=message):
        pl.unknown_input_observer(double_design.model, noise, process)


def test_continuous_models_are_refused(double_design):
    for call in (
        lambda m: pl.unknown_input_observer(m, [1, 1, 1]),
        lambda m: pl.observer_family(m, 0.9),
        lambda m: pl.luenberger(m, 0.9, [[1, 2, 3]]),
    ):
        with pytest.raises(ValueError, match="model: expected a sampled one, found a continuous"):
            call(double_design.plant)
