"""The controller: its two forms, purity, limits, the lemma, separation."""

import dataclasses

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.linalg import matrix_balance
from strategies import dynamics, rigs, weights

import pendlab as pl
from pendlab.controllers import Controller


@st.composite
def designs(draw, integrators=True, zero_H=None):
    """A sampled model, a stabilising gain with or without integrator, and any observer."""
    rig = draw(rigs(n_links=st.integers(2, 3), least_motors=2))
    model = pl.sample(pl.linearize(rig))
    tracked = draw(st.sampled_from([(1,), (0,), ()])) if integrators else ()
    augmented = pl.add_integrator(model, list(tracked))
    F = pl.lqr(
        augmented, draw(weights(augmented.nstates, -1, 2)), draw(weights(rig.n_motors, -1, 2))
    )
    E = draw(dynamics(rig.n_links - 1))
    if draw(st.booleans()) if zero_H is None else zero_H:
        observer = pl.observer_family(model, E).best()
    else:
        K = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
        observer = pl.luenberger(model, E, K.standard_normal((rig.n_links - 1, rig.n_links + 1)))
    # A random K may leave [C; T] close to singular, where no digits are left to compare.
    rows = np.vstack([model.C, observer.T / np.linalg.norm(observer.T, axis=1, keepdims=True)])
    assume(np.linalg.cond(rows) < 1e3)
    return model, pl.controller(F, observer, 0.01, tracked)


@given(designs(), st.integers(0, 2**32 - 1))
def test_step_is_the_system_sample_by_sample(design, seed):
    _, controller = design
    system, state = controller.system, controller.start()
    x = np.zeros(system.nstates)
    scale = np.abs(controller.F).max() * np.abs(controller.observer.L2).max()
    for y in np.random.default_rng(seed).standard_normal((20, system.ninputs)):
        u, state = controller.step(state, y)
        size = 1 + np.abs(u).max() + scale * np.abs(x).max()
        np.testing.assert_allclose(u, system.C @ x + system.D @ y, atol=1e-10 * size)
        x = system.A @ x + system.B @ y
        np.testing.assert_allclose([*state.v, *state.w], x, atol=1e-10 * size * (1 + scale))
        x = np.array([*state.v, *state.w])  # open loop an unstable controller would drift apart


def closed_loop(model, controller):
    """Plant and controller in one matrix: u = system y, y = C x."""
    s = controller.system
    BD = model.B @ s.D @ model.C
    return np.block([[model.A + BD, model.B @ s.C], [s.B @ model.C, s.A]])


def assert_same_eigenvalues(A, blocks):
    """det(zI - A) is the product over the blocks at points that are not eigenvalues."""
    for z in (1.7j, -1.3, 2 + 0.5j, 0.3 + 1.4j):
        log_det = lambda M: np.array(np.linalg.slogdet(z * np.eye(len(M)) - M))  # noqa: E731, B023
        (sign, size), parts = log_det(A), [log_det(M) for M in blocks]
        # det(zI - A) is as exact as the condition of its factors in balanced units allows.
        allowed = 1e-6 + 1e-14 * np.linalg.cond(z * np.eye(len(A)) - matrix_balance(A)[0])
        assume(allowed < 1e-2)  # else no digits are left to compare
        assert abs(size.real - sum(p[1].real for p in parts)) < allowed
        assert abs(sign - np.prod([p[0] for p in parts])) < allowed


@given(designs())
def test_separation(design):
    """Closed-loop eigenvalues: those of state feedback with its integrator, and those of E."""
    model, controller = design
    augmented = pl.add_integrator(model, list(controller.tracked))
    feedback = augmented.A - augmented.B @ controller.F
    A = closed_loop(model, controller)
    assert_same_eigenvalues(A, [feedback, controller.observer.E])
    assert np.abs(np.linalg.eigvals(A)).max() < 1


def test_separation_of_the_papers_designs(design):
    """With k_p the state feedback is that of the aligned model."""
    augmented, controller = design.augmented, design.controller
    A = closed_loop(design.model, controller)
    feedback = augmented.A - augmented.B @ design.F
    ours = np.sort_complex(np.linalg.eigvals(A))
    theirs = np.concatenate([np.linalg.eigvals(feedback), np.linalg.eigvals(controller.observer.E)])
    np.testing.assert_allclose(ours, np.sort_complex(theirs), atol=1e-6)


@given(designs(integrators=False))
def test_lemma(design):
    """(10): I + P G = [I + F L2 (zI - E)^-1 H]^-1 [I + F (zI - A)^-1 B]; with H = 0, (11)."""
    model, controller = design
    o, F, omega = controller.observer, controller.F, np.geomspace(0.01, np.pi / 0.01, 40)
    I_m, I_E, I_A = (np.eye(k) for k in (len(F), len(o.E), model.nstates))
    PG = pl.loop_gain(controller, model, omega)
    for w, loop in zip(omega, PG, strict=True):
        z = np.exp(0.01j * w)
        degraded = I_m + F @ o.L2 @ np.linalg.solve(z * I_E - o.E, o.H)
        feedback = I_m + F @ np.linalg.solve(z * I_A - model.A, model.B)
        left, right = degraded @ (I_m + loop), feedback
        terms = np.abs(degraded) @ np.abs(I_m + loop) + np.abs(right)
        assert np.abs(left - right).max() < 1e-6 * terms.max()


@given(designs(zero_H=True))
def test_lemma_with_integrator(design):
    """H = 0 recovers the loop of the augmented state feedback, (31) and (11)."""
    model, controller = design
    omega = np.geomspace(0.01, np.pi / 0.01, 60)
    augmented = pl.add_integrator(model, list(controller.tracked))
    recovered = pl.frequency_response(pl.state_feedback_loop(augmented, controller.F), omega)
    PG = pl.loop_gain(controller, model, omega)
    scale = np.abs(recovered).max(axis=(1, 2), keepdims=True)
    np.testing.assert_allclose(PG / scale, recovered / scale, atol=1e-6)


def test_lemma_needs_H_zero(triple_design):
    """An observer with H = TB as it comes changes the loop."""
    d = triple_design
    other = pl.luenberger(d.model, d.E, np.arange(1.0, 9.0).reshape(2, 4) % 5)
    omega = np.geomspace(0.1, 100, 50)
    nominal = pl.loop_gain(d.controller, d.model, omega)
    changed = pl.loop_gain(pl.controller(d.F, other, kp=d.kp), d.model, omega)
    assert np.abs(changed / nominal - 1).max() > 0.1


def test_steps_of_section_5_by_hand(double_design):
    """Read, estimate, control, limit, update: the arithmetic written out once for one motor."""
    d, c = double_design, double_design.controller
    o, F = c.observer, c.F[0]
    state = pl.ControllerState(np.array([0.02]), np.array([0.01]))
    y = np.array([0.01, -0.02, 0.1])
    u, after = c.step(state, y, y_ref=0.05)
    xhat = o.L1 @ y + o.L2 @ state.v
    np.testing.assert_allclose(xhat[:3], y, atol=1e-12)
    expected = -(F[:4] @ xhat + F[4] * 0.01)
    np.testing.assert_allclose(u, [np.clip(expected, -9, 9)], rtol=1e-12)
    np.testing.assert_allclose(after.v, 0.9 * 0.02 + o.K @ y, rtol=1e-12)
    np.testing.assert_allclose(after.w, 0.01 + d.dt * (0.05 - y[1]), rtol=1e-12)


def test_step_is_pure(design):
    c, rng = design.controller, np.random.default_rng(0)
    state = c.start(rng.standard_normal(design.model.nstates))
    y = rng.standard_normal(design.model.noutputs)
    before = [x.copy() for x in (*state, y)]
    first, second = c.step(state, y, 0.1), c.step(state, y, 0.1)
    np.testing.assert_array_equal(first[0], second[0])
    for a, b in zip((*first[1],), (*second[1],), strict=True):
        np.testing.assert_array_equal(a, b)
    for now, then in zip((*state, y), before, strict=True):
        np.testing.assert_array_equal(now, then)
    np.testing.assert_array_equal(c.step(state, list(y), 0.1)[0], first[0])


def test_voltage_limits_act_before_the_observer_hears_of_u(triple_design):
    d = triple_design
    o = pl.luenberger(d.model, [0.5, 0.6], np.ones((2, 4)) * [1, 2, 3, 4])  # H is not zero
    limited = pl.controller(d.F, o, kp=10, u_max=(12, 2.5))
    free = dataclasses.replace(limited, u_max=None)
    y = np.array([0.3, -0.2, 0.5, 1.0])
    u, after = limited.step(limited.start(), y)
    u_free, _ = free.step(free.start(), y)
    assert np.all(np.abs(u_free) > [12, 2.5])
    np.testing.assert_allclose(u, np.sign(u_free) * [12, 2.5])
    np.testing.assert_allclose(after.v, o.H @ u + o.K @ y)
    small, _ = limited.step(limited.start(), 1e-6 * y)
    np.testing.assert_allclose(small, 1e-6 * u_free)


def test_a_limit_of_one_motor_leaves_the_other_free(triple_design):
    free, half = (
        dataclasses.replace(triple_design.controller, u_max=u_max)
        for u_max in (None, (np.inf, 2.5))
    )
    y = np.array([0.3, -0.2, 0.5, 1.0])
    u = free.control(free.start(), y)
    np.testing.assert_array_equal(half.control(half.start(), y), [u[0], 2.5 * np.sign(u[1])])


def test_start_knows_the_state(design):
    """From v(0) = T x(0) the estimate is exact from the first sample."""
    c, x0 = design.controller, np.random.default_rng(1).standard_normal(design.model.nstates)
    xhat = c.estimate(c.start(x0), design.model.C @ x0)
    np.testing.assert_allclose(xhat, x0, atol=1e-9)
    assert np.all(c.start().v == 0) and np.all(c.start().w == 0)


def test_a_step_of_the_reference_is_reached(design):
    """Integral action: at rest the tracked output is at its reference."""
    A = closed_loop(design.model, design.controller)
    reference = np.zeros(len(A))
    reference[-1] = design.dt * 0.1  # w(n+1) = w(n) + Ts (y_r - y)
    rest = np.linalg.solve(np.eye(len(A)) - A, reference)
    np.testing.assert_allclose((design.model.C @ rest[: design.model.nstates])[1], 0.1, rtol=1e-6)


def test_upper_motor_of_38_holds_the_last_hinge(triple_design):
    """The row [k_p C_p C, 0]: u2 = -k_p (theta3 - theta2), exactly as measured."""
    c = dataclasses.replace(triple_design.controller, u_max=None)
    rng = np.random.default_rng(2)
    state = pl.ControllerState(rng.standard_normal(2), rng.standard_normal(1))
    y = rng.standard_normal(4)
    np.testing.assert_allclose(c.step(state, y)[0][1], -triple_design.kp * y[2], rtol=1e-9)
    np.testing.assert_array_equal(c.F[1], [0, 0, triple_design.kp, 0, 0, 0, 0])


@given(rigs(n_links=st.just(4), least_motors=2))
def test_kp_agrees_with_align_for_any_number_of_motors(rig):
    model = pl.sample(pl.linearize(rig))
    augmented = pl.add_integrator(pl.align(model, 2.0), 1)
    F = pl.lqr(augmented, np.ones(9), np.ones(rig.n_motors - 1))
    family = pl.observer_family(model, [0.5, 0.4, 0.3])
    some = np.random.default_rng(0).standard_normal(family.dimension)
    c = pl.controller(F, family.member(some), kp=2.0)
    A = closed_loop(model, c)
    assert_same_eigenvalues(A, [augmented.A - augmented.B @ F, c.observer.E])


def test_several_references(triple_design):
    """Both motors by the regulator, the attitude of both upper links tracked."""
    model = triple_design.model
    augmented = pl.add_integrator(model, [1, 2])
    F = pl.lqr(augmented, np.ones(8), [1, 1])
    c = pl.controller(F, triple_design.observer, tracked=[1, 2])
    assert c.system.nstates == 4 and c.system.state_labels == ["v1", "v2", "w1", "w2"]
    x, state = np.zeros(6), c.start()
    for _ in range(6000):
        u, state = c.step(state, model.C @ x, [0.1, -0.05])
        x = model.A @ x + model.B @ u
    np.testing.assert_allclose((model.C @ x)[1:3], [0.1, -0.05], atol=1e-6)


@pytest.mark.parametrize(
    "change, error, message",
    [
        (dict(F=np.ones((1, 4))), ValueError, r"F: expected shape 1 x 5, found shape \(1, 4\)"),
        (dict(F=np.ones((2, 5))), ValueError, "F: expected shape 1 x 5"),
        (dict(F=[1, 2, 3, 4, np.nan]), ValueError, "F: every entry must be finite"),
        (dict(observer="best"), TypeError, "observer: expected a pl.Observer, found 'best'"),
        (dict(dt=0), ValueError, "dt: expected a number above 0"),
        (dict(dt=None), TypeError, "dt: expected a number, found None"),
        (dict(tracked=3), ValueError, "tracked: expected a whole number from 0 to 2, found 3"),
        (dict(tracked=-1), ValueError, "tracked: expected a whole number from 0 to 2, found -1"),
        (dict(tracked="theta1"), ValueError, "tracked: expected a whole number"),
        (dict(tracked=(0, 1)), ValueError, "F: expected shape 1 x 6"),
        (dict(tracked=(1, 1)), ValueError, "tracked: each output takes one integrator"),
        (dict(u_max=(9, 9)), ValueError, "u_max: expected 1 numbers, found 2"),
        (dict(u_max=(-9,)), ValueError, r"u_max\[0\]: expected a number above 0"),
        (dict(kp=10), ValueError, "F: expected shape 1 x 5, found shape"),
    ],
)
def test_bad_input(double_design, change, error, message):
    good = dict(F=double_design.F, observer=double_design.observer, dt=0.01, tracked=1)
    assert isinstance(pl.controller(**good), Controller)
    with pytest.raises(error, match=message):
        pl.controller(**good | change)


def test_bad_kp_and_start(triple_design):
    d = triple_design
    with pytest.raises(ValueError, match="kp: expected a finite number"):
        pl.controller(d.F, d.observer, kp=np.inf)
    with pytest.raises(ValueError, match="F: expected shape 2 x 7"):
        pl.controller(d.F, d.observer)
    with pytest.raises(ValueError, match=r"x0: expected shape 6, found shape \(5,\)"):
        d.controller.start(np.zeros(5))
