"""The sampled plant: hold, alignment, integrator."""

import control
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from strategies import between, decades, rigs

import pendlab as pl


def close(a, b, digits=9):
    np.testing.assert_allclose(a, b, atol=10.0**-digits * max(1, np.abs(b).max()))


@given(rigs(), between(0.001, 0.05))
def test_hold_is_the_block_exponential(rig, dt):
    plant = pl.linearize(rig)
    n, m = plant.nstates, plant.ninputs
    block = expm(dt * np.block([[plant.A, plant.B], [np.zeros((m, n + m))]]))
    model = pl.sample(plant, dt)
    close(model.A, block[:n, :n])
    close(model.B, block[:n, n:])
    np.testing.assert_array_equal(model.C, plant.C)
    assert model.dt == dt and model.state_labels == plant.state_labels


@given(rigs(), between(0.001, 0.02))
def test_two_holds_make_one_of_twice_the_time(rig, dt):
    plant = pl.with_filters(pl.linearize(rig), rig.filters)
    one, two = pl.sample(plant, dt), pl.sample(plant, 2 * dt)
    close(two.A, one.A @ one.A)
    close(two.B, one.A @ one.B + one.B)


def test_hold_is_what_the_continuous_model_does_between_samples(triple):
    plant = pl.linearize(triple)
    model = pl.sample(plant)
    rng = np.random.default_rng(0)
    x, u = rng.standard_normal(6), rng.standard_normal(2)
    path = solve_ivp(lambda t, x: plant.A @ x + plant.B @ u, (0, 0.01), x, rtol=1e-11, atol=1e-12)
    close(model.A @ x + model.B @ u, path.y[:, -1], 8)


def test_hold_is_python_controls(rig):
    plant = pl.linearize(rig)
    theirs = control.sample_system(plant, 0.01, method="zoh")
    close(pl.sample(plant).A, theirs.A, 12)
    close(pl.sample(plant).B, theirs.B, 12)
    assert pl.sample(plant).output_labels == plant.output_labels


@given(rigs(n_links=st.integers(3, 4), least_motors=2), decades(-2, 2))
def test_align_is_state_feedback_from_the_last_motors_hinge(rig, kp):
    """Closing u_m = -k_p x_m by hand gives the aligned model, whatever the other inputs do."""
    model, m = pl.sample(pl.linearize(rig)), rig.n_motors
    aligned = pl.align(model, kp)
    rng = np.random.default_rng(1)
    x, u = rng.standard_normal(model.nstates), rng.standard_normal(m - 1)
    full = np.append(u, -kp * x[m])  # hinge m+1 has state m, counted from 0
    close(aligned.A @ x + aligned.B @ u, model.A @ x + model.B @ full)
    assert aligned.input_labels == model.input_labels[:-1] and aligned.dt == model.dt
    np.testing.assert_array_equal(aligned.C, model.C)


def test_align_is_python_controls_feedback(triple):
    model = pl.sample(pl.linearize(triple))
    Cp = np.array([[0, 0, 1, 0]])
    loop = control.ss([], [], [], np.vstack([np.zeros((1, 4)), 10 * Cp]), 0.01)
    closed = control.feedback(model, loop)
    close(pl.align(model, 10).A, closed.A)
    assert pl.align(model, 10).ninputs == 1


def test_align_with_no_gain_only_drops_the_input(triple):
    model = pl.sample(pl.linearize(triple))
    np.testing.assert_array_equal(pl.align(model, 0).A, model.A)


def test_alignment_leaves_two_unstable_eigenvalues_inside_its_interval(triple):
    model = pl.sample(pl.linearize(triple))

    def unstable(kp):
        return np.sum(np.abs(np.linalg.eigvals(pl.align(model, kp).A)) > 1)

    low, high = pl.alignment_interval(model)
    assert 0 < low < 10 < high
    for end, inside, outside in ((low, 1.001, 0.999), (high, 0.999, 1.001)):
        assert unstable(end * inside) == 2 < unstable(end * outside)
    # Without sampling the same gain balances at rest, and none is too high.
    assert pl.alignment_interval(pl.linearize(triple)) == (pytest.approx(low, rel=1e-6), np.inf)


def test_interval_ends_where_the_count_rises_and_not_where_it_falls_again():
    """s^3 + (2 + k) s^2 + (2 + k) s + 3.0025 + 6 k: stable but for (k - 0.95)(k - 1.05) < 0 (Routh)."""
    A, C = np.diag([1.0, 1.0], 1), np.zeros((3, 3))
    A[2], C[2] = (-3.0025, -2.0, -2.0), (6.0, 1.0, 1.0)
    model = control.ss(A, np.eye(3)[:, 1:] * [0.0, 1.0], C, np.zeros((3, 2)))
    low, high = pl.alignment_interval(model)
    assert low == 0 and high == pytest.approx(0.95, abs=1e-9)


@given(rigs(), st.data())
def test_integrator_structure(rig, data):
    model = pl.sample(pl.linearize(rig))
    k = data.draw(st.integers(0, rig.n_links))
    augmented = pl.add_integrator(model, k)
    n = model.nstates
    A = augmented.A
    np.testing.assert_array_equal(A[:n, :n], model.A)
    np.testing.assert_array_equal(A[:n, n], 0)
    np.testing.assert_array_equal(A[n], [*(-0.01 * model.C[k]), 1])
    np.testing.assert_array_equal(augmented.B, np.vstack([model.B, np.zeros(rig.n_motors)]))
    np.testing.assert_array_equal(augmented.C[:, :n], model.C)
    assert augmented.state_labels == [*model.state_labels, "w"]
    by_name = pl.add_integrator(model, model.output_labels[k])
    np.testing.assert_array_equal(by_name.A, A)


def test_integrator_adds_up_the_error(triple):
    """w(n) is minus Ts times the sum of the outputs so far, also through a direct feedthrough."""
    model = pl.sample(pl.linearize(triple))
    model = control.ss(model.A, model.B, model.C, np.full((4, 2), 0.1), 0.01)
    augmented = pl.add_integrator(model, [1, 0])
    assert augmented.state_labels[-2:] == ["w1", "w2"]
    rng = np.random.default_rng(2)
    z, total = np.append(rng.standard_normal(6), [0, 0]), np.zeros(2)
    for _ in range(10):
        u = rng.standard_normal(2)
        total -= 0.01 * (augmented.C @ z + augmented.D @ u)[[1, 0]]
        z = augmented.A @ z + augmented.B @ u
    close(z[-2:], total)


def test_no_integrator_at_all(double):
    model = pl.sample(pl.linearize(double))
    np.testing.assert_array_equal(pl.add_integrator(model, []).A, model.A)


@pytest.mark.parametrize(
    "call, error, message",
    [
        (lambda p, s: pl.sample(p, 0), ValueError, "dt: expected a number above 0, found 0"),
        (lambda p, s: pl.sample(p, -0.01), ValueError, "dt: expected a number above 0"),
        (lambda p, s: pl.sample(p, np.nan), ValueError, "dt: expected a finite number, found nan"),
        (lambda p, s: pl.sample(p, np.inf), ValueError, "dt: expected a finite number, found inf"),
        (lambda p, s: pl.sample(p, "10 ms"), TypeError, "dt: expected a number, found '10 ms'"),
        (lambda p, s: pl.sample(s), ValueError, "plant: expected a continuous model, .* at 0.01 s"),
        (
            lambda p, s: pl.sample(pl.load("triple")),
            TypeError,
            "plant: expected a control.StateSpa",
        ),
        (lambda p, s: pl.align(s.A, 10), TypeError, "model: expected a control.StateSpace"),
        (lambda p, s: pl.align(s, np.nan), ValueError, "kp: expected a finite number"),
        (lambda p, s: pl.align(s, None), TypeError, "kp: expected a number, found None"),
        (lambda p, s: pl.align(pl.align(s, 1), 1), ValueError, "model: aligning .* found 1; a rig"),
        (
            lambda p, s: pl.align(s[:2, :], 1),
            ValueError,
            "model: expected the angle of every hinge",
        ),
        (lambda p, s: pl.add_integrator(p, 1), ValueError, "model: .* use pl.sample"),
        (lambda p, s: pl.add_integrator(s, 4), ValueError, "output: expected an index from 0 to 3"),
        (lambda p, s: pl.add_integrator(s, -1), ValueError, "output: expected an index"),
        (lambda p, s: pl.add_integrator(s, "theta2"), ValueError, "output: .*found 'theta2'"),
        (lambda p, s: pl.add_integrator(s, [1, 1]), ValueError, "output: each output takes one"),
    ],
)
def test_bad_input(triple, call, error, message):
    plant = pl.linearize(triple)
    with pytest.raises(error, match=message):
        call(plant, pl.sample(plant))


@pytest.mark.parametrize("delay", [0.0, 0.00056, 0.004, 0.01])
def test_delayed_hold_equals_a_finer_hold_with_the_old_voltage_first(delay):
    """In steps of 10 ms / 250 the delay is a whole number of holds of the old voltage."""
    plant = pl.linearize(pl.load("double"))
    delay = round(delay / 4e-5) * 4e-5
    late, fine = pl.sample(plant, 0.01, delay), pl.sample(plant, 4e-5)
    x, old, new = np.array([0.01, -0.02, 0.1, 0.2]), 1.3, -0.7
    expected = x
    for k in range(250):
        voltage = old if k < round(delay / 4e-5) else new
        expected = fine.A @ expected + fine.B[:, 0] * voltage
    state = x if delay == 0 else np.append(x, old)
    assert (late.A @ state + late.B[:, 0] * new)[:4] == pytest.approx(expected, rel=1e-9)
    np.testing.assert_array_equal(late.C @ state, plant.C @ x)


@pytest.mark.parametrize("rate, works", [(600.0, True), (800.0, False)])
def test_the_fastest_motion_limits_the_sampling_time(rate, works):
    """exp(800) and exp(-800) are beyond what a double holds."""
    for sign in (1, -1):
        plant = control.ss(np.diag([0.0, sign * rate]), [[0], [1]], [[1, 0]], 0)
        if works:
            assert pl.sample(plant, 1.0).A[1, 1] == pytest.approx(np.exp(sign * rate), rel=1e-9)
        else:
            with pytest.raises(ValueError, match="dt: 1 s is 800 times"):
                pl.sample(plant, 1.0)


def test_delay_longer_than_a_sample_is_refused():
    with pytest.raises(ValueError, match="delay: expected at most the sampling time"):
        pl.sample(pl.linearize(pl.load("double")), 0.01, 0.02)
