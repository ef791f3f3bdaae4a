"""Continuous models: energy, Jacobian, equations (1) and (2), filters."""

import dataclasses

import control
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from strategies import rigs, states

import pendlab as pl
from pendlab.models import derived


def with_friction(rig, factor):
    """The same rig with all viscous friction times `factor`."""
    return dataclasses.replace(
        rig,
        links=[dataclasses.replace(k, friction=k.friction * factor) for k in rig.links],
        motors=[dataclasses.replace(k, damping=k.damping * factor) for k in rig.motors],
    )


def powers(rig, x, u):
    """Power lost to viscous friction and power from the motors, from the hinges' own rates."""
    n, m = rig.n_links, rig.n_motors
    rates = x[n:]
    damping = np.array([link.friction for link in rig.links])
    damping[1 : m + 1] += [motor.damping for motor in rig.motors]
    # Motor i pushes hinge i+1 forward with G u: +G u on link i+1 and -G u on link i.
    torque = np.array([motor.gain for motor in rig.motors]) * u
    return damping @ rates**2, torque @ rates[1 : m + 1]


def jacobian(f, x, step=1e-5):
    columns = [(f(x + e) - f(x - e)) / (2 * step) for e in step * np.eye(len(x))]
    return np.array(columns).T


@given(st.data())
def test_linear_model_is_the_jacobian(data):
    rig = data.draw(rigs())
    n, m = rig.n_links, rig.n_motors
    f, plant = pl.nonlinear(rig), pl.linearize(rig)
    A = jacobian(lambda x: f(x, np.zeros(m)), np.zeros(2 * n))
    B = jacobian(lambda u: f(np.zeros(2 * n), u), np.zeros(m))
    np.testing.assert_allclose(plant.A, A, atol=1e-7 * np.abs(A).max())
    np.testing.assert_allclose(plant.B, B, atol=1e-7 * np.abs(B).max())
    np.testing.assert_array_equal(plant.C, np.eye(n + 1, 2 * n))


@given(st.data())
def test_power_balance_at_any_state(data):
    """dE/dt = motor power - friction power, along f, at large angles too."""
    rig = data.draw(rigs())
    x = data.draw(states(rig.n_links, angle=3, rate=5))
    u = np.array(
        data.draw(st.lists(st.floats(-9, 9), min_size=rig.n_motors, max_size=rig.n_motors))
    )
    gradient = jacobian(lambda z: np.array([pl.energy(rig, z)]), x)[0]
    rate = pl.nonlinear(rig)(x, u)
    lost, given_ = powers(rig, x, u)
    scale = lost + abs(given_) + np.abs(gradient) @ np.abs(rate)
    rounding = 1e-9 * np.abs(rate).sum()  # of the difference quotient, (J/rad) rad/s
    assert abs(gradient @ rate - given_ + lost) <= 1e-7 * scale + rounding


def run(rig, x0, u, t_end):
    f = pl.nonlinear(rig)
    solution = solve_ivp(lambda t, x: f(x, u(t)), (0, t_end), x0, rtol=1e-10, atol=1e-10)
    assert solution.success
    return solution


def test_energy_is_kept_without_friction(rig):
    free = with_friction(rig, 0.0)
    x0 = np.concatenate([np.full(rig.n_links, 0.4), np.zeros(rig.n_links)])
    path = run(free, x0, lambda t: np.zeros(rig.n_motors), 2.0)
    energies = [pl.energy(free, x) for x in path.y.T]
    assert np.ptp(path.y[0]) > 1, "the pendulum falls and swings"
    np.testing.assert_allclose(energies, energies[0], atol=1e-7)


def test_energy_balance_with_friction_and_voltage(rig):
    n, m = rig.n_links, rig.n_motors
    f = pl.nonlinear(rig)
    u = lambda t: 2 * np.sin(5 * t + np.arange(m))  # noqa: E731

    def balance(t, z):
        lost, given_ = powers(rig, z[:-1], u(t))
        return np.append(f(z[:-1], u(t)), given_ - lost)

    x0 = np.append(np.full(n, 0.2), np.zeros(n + 1))
    path = solve_ivp(balance, (0, 1.0), x0, method="Radau", rtol=1e-8, atol=1e-10)
    energies = np.array([pl.energy(rig, x) for x in path.y[:-1].T])
    np.testing.assert_allclose(energies - energies[0], path.y[-1], atol=1e-6)
    assert abs(path.y[-1, -1]) > 0.1, "energy was exchanged"


def test_upright_and_hanging_are_equilibria(rig):
    n, m = rig.n_links, rig.n_motors
    f = pl.nonlinear(rig)
    for angle, sign in ((0, 1), (np.pi, -1)):
        x = np.zeros(2 * n)
        x[0] = angle
        np.testing.assert_allclose(f(x, np.zeros(m)), 0, atol=1e-12)
        values = np.linalg.eigvals(jacobian(lambda z: f(z, np.zeros(m)), x))
        assert (values.real.max() > 0) == (sign > 0), "only upright is unstable"


def test_positive_voltage_turns_the_upper_link_forward(rig):
    """+u_i opens hinge i+1: the link above is pushed forward, the one below back."""
    for i in range(rig.n_motors):
        push = pl.nonlinear(rig)(np.zeros(2 * rig.n_links), np.eye(rig.n_motors)[i])
        assert push[rig.n_links + i + 1] > 0 > push[rig.n_links + i]


PRINTED = {
    "double": (
        [31.4752, 3.0426, -0.4107, 96.7383],
        [-24.8992],
        [-165.3448, -4.9396, 0.0879, 4.7437],
    ),
    "triple": (
        [38.0067, -1.6968, -5.0736, -0.3192, 77.3017, 1.5023],
        [-19.8965, -5.6332],
        [-191.8383, -12.2094, -4.5134, 0.1463, 2.7602, 5.0691],
    ),
}


def test_equations_1_and_2(rig):
    """The row of the lowest link's acceleration, and the eigenvalues, to the printed digits."""
    plant = pl.linearize(rig)
    row, inputs, eigenvalues = PRINTED[rig.name]
    half = 0.5e-4 * (1 + 1e-9)
    np.testing.assert_allclose(plant.A[rig.n_links], row, rtol=0, atol=half)
    np.testing.assert_allclose(plant.B[rig.n_links], inputs, rtol=0, atol=half)
    np.testing.assert_allclose(np.sort(plant.poles().real), eigenvalues, rtol=0, atol=half)
    assert np.abs(plant.poles().imag).max() == 0


def test_names_travel_with_the_matrices(triple):
    plant = pl.linearize(triple)
    assert plant.state_labels == [
        *("theta1", "theta2-theta1", "theta3-theta2"),
        *("dtheta1", "dtheta2-theta1", "dtheta3-theta2"),
    ]
    assert plant.input_labels == ["u1", "u2"]
    assert plant.output_labels == ["theta1", "theta2-theta1", "theta3-theta2", "dtheta1"]
    assert plant.dt == 0 and plant.name == "triple"
    assert pl.with_filters(plant, triple.filters).output_labels == plant.output_labels


@given(rigs())
def test_filters_add_their_poles_and_keep_the_gain(rig):
    plant = pl.linearize(rig)
    filtered = pl.with_filters(plant, rig.filters)
    cutoffs = 2 * np.pi * np.array([*rig.filters.input_hz, *rig.filters.output_hz])
    # det(sI - A) is the product of the blocks' at any s, and G_f = F_out G F_in.
    for s in (0.3j, 2 + 1j, 40j):
        F_in = np.diag(1 / (1 + s / (2 * np.pi * np.array(rig.filters.input_hz))))
        F_out = np.diag(1 / (1 + s / (2 * np.pi * np.array(rig.filters.output_hz))))
        G = plant(s, squeeze=False)
        np.testing.assert_allclose(
            filtered(s, squeeze=False), F_out @ G @ F_in, rtol=1e-8, atol=1e-12
        )
        char = lambda A: np.linalg.slogdet(s * np.eye(len(A)) - A)[1]  # noqa: E731, B023
        expected = char(plant.A) + np.log(np.abs(s + cutoffs)).sum()
        assert char(filtered.A) == pytest.approx(expected, rel=1e-10)
    np.testing.assert_allclose(
        filtered(0, squeeze=False), plant(0, squeeze=False), rtol=1e-6, atol=1e-9
    )


@pytest.mark.parametrize("part", [0, 1, 2])
def test_a_result_beyond_all_numbers_is_refused(double, part):
    model = pl.linearize(double)
    parts = [model.A, model.B, model.C, model.D]
    assert derived(model, *parts, name="same").state_labels == model.state_labels
    parts[part] = parts[part] + np.inf
    with pytest.raises(ValueError, match="model: the result 'large' is not finite"):
        derived(model, *parts, name="large")


def test_filters_of_a_model_with_direct_feedthrough():
    plant = control.ss([[-1.0]], [[1.0]], [[1.0]], [[2.0]])
    filtered = pl.with_filters(plant, pl.Filters([1.0], [2.0]))
    s = 3j
    expected = plant(s) / ((1 + s / (2 * np.pi)) * (1 + s / (4 * np.pi)))
    assert filtered(s) == pytest.approx(expected)


@pytest.mark.parametrize(
    "call, error, message",
    [
        (lambda p, r: pl.linearize("double"), TypeError, "rig: expected a pl.Pendulum such as"),
        (lambda p, r: pl.nonlinear(None), TypeError, "rig: expected a pl.Pendulum such as"),
        (
            lambda p, r: pl.nonlinear(r)([0, 0], [0]),
            ValueError,
            r"x: expected shape 4, found shape",
        ),
        (
            lambda p, r: pl.nonlinear(r)(np.zeros(4), [0, 0]),
            ValueError,
            "u: expected shape 1, found",
        ),
        (
            lambda p, r: pl.nonlinear(r)([0, np.nan, 0, 0], 0),
            ValueError,
            "x: every entry must be fin",
        ),
        (lambda p, r: pl.energy(r, [0, 0, 0]), ValueError, "x: expected shape 4"),
        (
            lambda p, r: pl.with_filters(p, None),
            TypeError,
            "filters: expected a pl.Filters such as",
        ),
        (
            lambda p, r: pl.with_filters(r, r.filters),
            TypeError,
            "plant: expected a control.StateSp",
        ),
        (
            lambda p, r: pl.with_filters(p, pl.load("triple").filters),
            ValueError,
            "filters.input_hz: expected 1 numbers, found 2",
        ),
        (
            lambda p, r: pl.with_filters(pl.sample(p), r.filters),
            ValueError,
            "plant: expected a continuous model, found one already sampled at 0.01 s",
        ),
    ],
)
def test_bad_input(double, call, error, message):
    with pytest.raises(error, match=message):
        call(pl.linearize(double), double)
