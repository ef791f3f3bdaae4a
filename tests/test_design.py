"""The chain from a rig to a controller: each link, replaced choices, nothing computed too early."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import dynamics, rigs, weights

import pendlab as pl
from pendlab.design import NEEDS


def test_links_of_the_chain(triple_design):
    d = triple_design
    np.testing.assert_array_equal(d.plant.A, pl.linearize(d.rig).A)
    np.testing.assert_array_equal(d.model.A, pl.sample(d.plant, 0.01).A)
    filtered = pl.sample(pl.with_filters(d.plant, d.rig.filters))
    np.testing.assert_array_equal(d.filtered.A, filtered.A)
    augmented = pl.add_integrator(pl.align(d.model, 10), "theta2-theta1")
    np.testing.assert_array_equal(d.augmented.A, augmented.A)
    np.testing.assert_array_equal(d.F, pl.lqr(augmented, d.Q, d.R))
    np.testing.assert_array_equal(d.controller.F[0], d.F[0])
    assert d.controller.u_max == d.rig.u_max == (12.0, 2.5)
    assert d.nominal_loop.nstates == 6 + 3 and d.filtered_loop.nstates == 12 + 3
    assert d.loop(1).ninputs == 1 and d.state_feedback_loop.ninputs == 1


def test_gain_of_the_double_to_the_printed_digits(double_design):
    """Equation (23), copied here once by hand."""
    printed = pl.published("eq23.F")
    assert printed.holds(double_design.F)


def test_replace_changes_what_follows_and_nothing_else(triple_design):
    softer = dataclasses.replace(triple_design, kp=5.0)
    assert softer.kp == 5.0 and triple_design.kp == 10.0
    np.testing.assert_array_equal(softer.model.A, triple_design.model.A)
    assert not np.allclose(softer.F, triple_design.F)
    assert softer.controller.F[1, 2] == 5.0


CHANGES = {
    "rig": lambda d: dataclasses.replace(d.rig, g=9.0),
    "Q": lambda d: tuple(2 * q for q in d.Q),
    "R": lambda d: tuple(3 * r for r in d.R),
    "E": lambda d: (0.8, 0.7),
    "kp": lambda d: 5.0,
    "coefficients": lambda d: tuple(2 * c for c in d.coefficients),
    "dt": lambda d: 0.02,
    "tracked": lambda d: 2,
}


def test_changes_are_those_of_every_choice(triple_design):
    assert list(CHANGES) == [field.name for field in dataclasses.fields(triple_design)]


def same(one, two):
    """Whether two computed values are equal in all their numbers."""
    if isinstance(one, np.ndarray):
        return one.shape == two.shape and np.array_equal(one, two)
    parts = (
        "ABCD" if hasattr(one, "A") else ("E", "K", "T", "L1") if hasattr(one, "L1") else ("E", "S")
    )
    return all(same(np.asarray(getattr(one, p)), np.asarray(getattr(two, p))) for p in parts)


@pytest.mark.parametrize("choice", CHANGES)
def test_changed_carries_along_what_stays_and_nothing_else(triple_design, choice):
    for name in NEEDS:
        getattr(triple_design, name)
    change = {choice: CHANGES[choice](triple_design)}
    new, fresh = triple_design.changed(**change), dataclasses.replace(triple_design, **change)
    for name in NEEDS:
        carried = vars(new).get(name)
        assert carried is None or carried is getattr(triple_design, name)
        stays = same(getattr(triple_design, name), getattr(fresh, name))
        assert (carried is not None) == stays, name
        assert same(getattr(new, name), getattr(fresh, name))


def test_changed_carries_nothing_that_was_not_computed(triple):
    d = pl.Design(triple, Q=[1] * 7, R=1, E=[0.9, 0.8], kp=10.0)
    _ = d.model
    assert set(vars(d.changed(kp=5.0))) & set(NEEDS) == {"plant", "model"}


def test_nothing_is_computed_before_it_is_asked_for(triple):
    d = pl.Design(triple, Q=[1] * 7, R=1, E=[1.5, 0.9], kp=10.0)  # E cannot work, F can
    assert set(vars(d)) == {field.name for field in dataclasses.fields(d)}
    assert d.F.shape == (1, 7) and "family" not in vars(d)
    with pytest.raises(ValueError, match="E: the observer's eigenvalues must lie inside"):
        _ = d.controller
    assert d.F is d.F, "computed once"


def test_best_observer_unless_coefficients_are_given(double_design):
    free = dataclasses.replace(double_design, coefficients=None)
    np.testing.assert_array_equal(free.observer.T, free.family.best().T)
    chosen = dataclasses.replace(double_design, coefficients=(1.0, 2.0))
    np.testing.assert_array_equal(chosen.observer.T, chosen.family.member([1, 2]).T)


@given(rigs(n_links=st.integers(2, 3)), st.data())
def test_every_design_recovers_the_state_feedback_loop(rig, data):
    """From any rig, weights and E to a stable loop whose response is F (zI - A)^-1 B."""
    n, m = rig.n_links, rig.n_motors
    Q, R = data.draw(weights(2 * n + 1, -1, 2)), data.draw(weights(m, -1, 2))
    d = pl.Design(rig, Q, R, data.draw(dynamics(n - 1)))
    assert np.abs(pl.closed_loop_eigenvalues(d.nominal_loop)[0]) < 1
    omega = np.geomspace(0.1, np.pi / d.dt, 40)
    recovered = pl.frequency_response(d.nominal_loop, omega)
    wanted = pl.frequency_response(d.state_feedback_loop, omega)
    scale = np.abs(wanted).max(axis=(1, 2), keepdims=True)
    np.testing.assert_allclose(recovered / scale, wanted / scale, atol=1e-6)


def test_aligned_loop_broken_at_input_1_is_the_state_feedback_loop(triple_design):
    """(33): with loop 2 closed only the aligned model is left, so H = 0 recovers its loop."""
    omega = np.geomspace(0.05, np.pi / 0.01, 100)
    broken = pl.frequency_response(triple_design.loop(0), omega)
    wanted = pl.frequency_response(triple_design.state_feedback_loop, omega)
    np.testing.assert_allclose(broken, wanted, rtol=1e-5, atol=1e-7)
    np.testing.assert_array_equal(broken, pl.frequency_response(triple_design.loop(), omega))


def test_a_loop_is_broken_at_a_motor_of_the_rig(design):
    m = design.rig.n_motors
    assert design.loop(m - 1).ninputs == 1
    with pytest.raises(ValueError, match=f"index: expected a whole number from 0 to {m - 1}"):
        design.loop(m)


def test_both_motors_by_the_regulator_with_two_references(triple):
    d = pl.Design(triple, Q=(1,) * 8, R=(1, 1), E=(0.9, 0.9), tracked=(1, 2))
    assert d.F.shape == (2, 8) and d.controller.tracked == (1, 2)
    assert pl.encirclements(d.nominal_loop).stable


def test_another_sampling_time(double_design):
    slow = dataclasses.replace(double_design, dt=0.02, coefficients=None)
    assert slow.model.dt == slow.controller.dt == slow.nominal_loop.dt == 0.02
    assert np.abs(pl.closed_loop_eigenvalues(slow.nominal_loop)[0]) < 1


@pytest.mark.parametrize(
    "change, part, error, message",
    [
        (dict(dt=0), "model", ValueError, "dt: expected a number above 0"),
        (dict(Q=(1, 1)), "F", ValueError, "Q: expected shape 5"),
        (dict(Q=(1, 1, 1, 1, 0)), "F", ValueError, "Q: no weight sees the mode"),
        (dict(R=(-1,)), "F", ValueError, "R: expected a positive definite"),
        (dict(E=(1.0,)), "family", ValueError, "E: the observer's eigenvalues"),
        (dict(kp=3.0), "augmented", ValueError, "model: aligning takes the last of at least 2"),
        (dict(tracked=3), "augmented", ValueError, "output: expected an index from 0 to 2"),
        (dict(coefficients=(1,)), "observer", ValueError, "coefficients: expected shape 2"),
        (dict(rig="double"), "plant", TypeError, "rig: expected a pl.Pendulum"),
    ],
)
def test_bad_choices_are_named(double_design, change, part, error, message):
    with pytest.raises(error, match=message):
        getattr(dataclasses.replace(double_design, **change), part)


def test_rig_without_filters(double_design):
    bare = dataclasses.replace(double_design.rig, filters=None)
    d = dataclasses.replace(double_design, rig=bare)
    assert d.nominal_loop.nstates == 6
    with pytest.raises(
        TypeError, match=r"filters: expected a pl\.Filters such as rig\.filters, found None"
    ):
        _ = d.filtered_loop
