"""Weights, units and coordinates scaled: the same gain, the same observers, the same verdicts."""

import control
import numpy as np
import pytest

import pendlab as pl
from pendlab.loop import open_loop


def in_units(model, states=1.0, inputs=1.0, outputs=1.0):
    """The same model with states, inputs and outputs counted in units of these sizes."""
    x, u, y = (np.broadcast_to(s, n).astype(float) for s, n in
               ((states, model.nstates), (inputs, model.ninputs), (outputs, model.noutputs)))  # fmt: skip
    return control.ss(
        model.A * x / x[:, None],
        model.B * u / x[:, None],
        model.C * x / y[:, None],
        model.D * u / y[:, None],
        model.dt,
    )


@pytest.mark.parametrize("c", [1e-30, 1e-16, 1e-7, 1e-3, 1e3, 1e7, 1e16, 1e30])
def test_gain_depends_on_the_ratio_of_the_weights_alone(design, c):
    Q, R = np.array(design.Q), np.array(design.R)
    np.testing.assert_allclose(pl.lqr(design.augmented, c * Q, c * R), design.F, rtol=1e-7)
    full = pl.lqr(design.augmented, np.diag(c * Q), np.diag(c * R))
    np.testing.assert_allclose(full, design.F, rtol=1e-7)


@pytest.mark.parametrize("c", [2.0**-60, 2.0**60])
def test_powers_of_two_change_no_digit(design, c):
    scaled = pl.lqr(design.augmented, c * np.array(design.Q), c * np.array(design.R))
    np.testing.assert_array_equal(scaled, design.F)


@pytest.mark.parametrize("volt", [1e-9, 1e-3, 1e6])
def test_units_of_the_voltage(double_design, volt):
    """F in new volts is F/volt; nothing is called unreachable."""
    model = in_units(double_design.augmented, inputs=volt)
    F = pl.lqr(model, double_design.Q, volt**2 * np.array(double_design.R))
    np.testing.assert_allclose(F * volt, double_design.F, rtol=1e-6)


@pytest.mark.parametrize("angle", [1e-6, 1e-3, 57.3])
def test_units_of_the_angles(double_design, angle):
    """States and outputs in other units: F times the unit, the same observer, the same margins."""
    d = double_design
    sizes = np.full(5, angle)
    F = pl.lqr(in_units(d.augmented, sizes), angle**2 * np.array(d.Q), d.R)
    np.testing.assert_allclose(F / angle, d.F, rtol=1e-6)
    model = in_units(d.model, angle, outputs=angle)
    member = pl.observer(model, d.observer.E, d.observer.T * angle, d.observer.K * angle)
    np.testing.assert_allclose(member.L1, d.observer.L1, rtol=1e-6, atol=1e-9)
    controller = pl.controller(F, member)
    loop = open_loop(controller, model)
    assert pl.margins(loop).modulus == pytest.approx(pl.margins(d.nominal_loop).modulus, rel=1e-6)
    assert pl.encirclements(loop) == pl.encirclements(d.nominal_loop)


@pytest.mark.parametrize(
    "sizes",
    [dict(states=1e-6), dict(inputs=1e-9), dict(inputs=1e9), dict(outputs=1e-9), dict(outputs=1e9)],
)
def test_dimension_of_the_family(design, sizes):
    family = pl.observer_family(in_units(design.model, **sizes), design.E)
    assert family.dimension == design.family.dimension
    assert np.abs(family.S @ family.basis.T).max() < 1e-9 * np.abs(family.S).max()


@pytest.mark.parametrize("c", [1e-20, 1.0, 1e20])
def test_what_is_wrong_stays_wrong(double_design, c):
    model = double_design.augmented
    for Q, message in (
        ((1, 1, 1, 1, 0), "Q: no weight sees the mode at 1"),
        ((1, 1, 1, 1, -1e-3), "Q: expected a positive semidefinite"),
        (np.eye(5) + 1e-6 * np.eye(5, k=1), "Q: expected a symmetric"),
    ):
        with pytest.raises(ValueError, match=message):
            pl.lqr(model, c * np.array(Q, dtype=float), c)


@pytest.mark.parametrize("seconds", [1e-12, 1.0, 1e12])
def test_units_of_time_in_a_continuous_model(seconds):
    """An unmoved mode that decays, however slowly it does in these units, is no obstacle."""
    A, B = np.diag([1.0, -0.5]), np.array([[1.0], [0.0]])
    plant = control.ss(A * seconds, B * seconds, np.eye(2), 0)
    np.testing.assert_allclose(pl.lqr(plant, [1, 1], 1), [[1 + np.sqrt(2), 0]], rtol=1e-6)
