"""The simulator against identities and closed forms."""

import dataclasses
import logging
import os
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import ipyparallel
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

import pendlab as pl
from pendlab.bench import gearbox
from pendlab.bench.many import _bar


@dataclasses.dataclass(frozen=True)
class Voltages:
    """A controller that sends the same voltages whatever it reads."""

    u: tuple
    dt: float = 0.01

    def step(self, state, y, y_ref):
        return np.array(self.u), state


class Brittle:
    """A controller that breaks at its third sample."""

    def step(self, count, y, y_ref):
        return [0.0, 0.0 / (2 - (count or 0))], (count or 0) + 1


class Dying:
    """A controller that takes its process along."""

    def step(self, state, y, y_ref):
        os._exit(1)


@dataclasses.dataclass(frozen=True)
class Plain:
    """The paper's controller as an ordinary Python object."""

    inner: pl.Controller

    @property
    def dt(self):
        return self.inner.dt

    def start(self, x0):
        return self.inner.start(x0)

    def estimate(self, state, y):
        return self.inner.estimate(state, y)

    def step(self, state, y, y_ref):
        return self.inner.step(state, y, y_ref)


def frictionless(rig):
    return dataclasses.replace(
        rig,
        links=[dataclasses.replace(link, friction=0.0) for link in rig.links],
        motors=[dataclasses.replace(motor, damping=0.0) for motor in rig.motors],
    )


def states_of(run):
    return np.hstack([run.angles, run.rates])


def small_start(rig, size=1e-6):
    return size * np.array([1.0, -2.0, 0.5])[: rig.n_links]


def input_matrix(A, B, start, end):
    """Integral of e^(A s) B ds from `start` to `end`, through one matrix exponential."""
    n, m = B.shape
    both = np.block([[A, B], [np.zeros((m, n + m))]])
    return expm(both * end)[:n, n:] - expm(both * start)[:n, n:]


# ---- Ideal rig


def test_energy_is_kept_without_friction(rig):
    free = frictionless(rig)
    x0 = np.array([0.4, -0.1, 0.05])[: rig.n_links]
    run = pl.simulate(free, Voltages((0.0,) * rig.n_motors), 5.0, initial=x0, inner_step=2e-4)
    assert run.fell and len(run.t) > 10
    energy = np.array([pl.energy(free, x) for x in states_of(run)])
    assert np.ptp(energy) < 1e-10 * np.abs(energy).max()
    assert np.abs(run.rates[-1]).max() > 1  # it did move


def test_energy_balance_with_friction_and_motors(rig):
    u = np.array([0.5, -0.1])[: rig.n_motors]
    x0 = np.array([0.1, -0.1, 0.05])[: rig.n_links]
    run = pl.simulate(rig, Voltages(tuple(u), dt=2e-4), 0.3, initial=x0)
    damping = np.array([link.friction for link in rig.links])
    damping[1 : rig.n_motors + 1] += [motor.damping for motor in rig.motors]
    torque = np.array([motor.gain for motor in rig.motors]) * u
    power = run.rates[:, 1 : rig.n_motors + 1] @ torque - run.rates**2 @ damping
    assert len(power) % 2 == 1  # Simpson's rule
    work = run.dt / 3 * (power[:-2:2] + 4 * power[1:-1:2] + power[2::2]).sum()
    gained = pl.energy(rig, states_of(run)[-1]) - pl.energy(rig, states_of(run)[0])
    assert gained == pytest.approx(work, rel=1e-6) and abs(work) > 1e-3


def test_fall_is_an_event_with_its_time(rig):
    x0 = np.array([0.2, 0.1, -0.1])[: rig.n_links]
    run = pl.simulate(rig, Voltages((0.0,) * rig.n_motors), 10.0, initial=x0)
    f, u = pl.nonlinear(rig), np.zeros(rig.n_motors)
    past = [
        lambda t, x, i=i: np.abs(np.cumsum(x[: rig.n_links])[i]) - np.pi / 2
        for i in range(rig.n_links)
    ]
    for event in past:
        event.terminal = True
    exact = solve_ivp(lambda t, x: f(x, u), (0, 10), [*x0, *np.zeros(rig.n_links)], events=past,
                      rtol=1e-9, atol=1e-11)  # fmt: skip
    assert 0 <= run.fell_at - exact.t[-1] <= run.inner_step + 1e-6
    assert run.t[-1] < run.fell_at <= run.t[-1] + run.dt + 1e-9
    assert np.abs(run.theta).max() < np.pi / 2


def test_a_fall_before_the_new_voltage_arrives_keeps_its_time(rig):
    idle, x0 = Voltages((0.0,) * rig.n_motors), np.array([0.2, 0.1, -0.1])[: rig.n_links]
    at_once, late = (
        pl.simulate(rig, idle, 10.0, initial=x0, inner_step=1e-4,
                    imperfections=pl.Imperfections(delay=delay)).fell_at
        for delay in (0.0, 0.0095)
    )  # fmt: skip
    assert at_once % 0.01 < 0.009 and late == pytest.approx(at_once, abs=1.1e-4)


@pytest.mark.parametrize("filters", [False, True])
def test_tiny_start_is_the_linear_prediction(design, filters):
    rig, c = design.rig, design.controller
    plant = pl.linearize(rig)
    model = pl.sample(pl.with_filters(plant, rig.filters) if filters else plant, c.dt)
    x0 = small_start(rig)
    run = pl.simulate(rig, c, 3.0, initial=x0, inner_step=2e-4,
                      imperfections=pl.Imperfections(filters=filters))  # fmt: skip
    n, m = rig.n_links, rig.n_motors
    x = np.concatenate([x0, np.zeros(n)])
    if filters:  # the filters have settled at the start
        x = np.concatenate([x, np.zeros(m), x[: n + 1]])
    state, expected = c.start(np.concatenate([x0, np.zeros(n)])), []
    for _ in run.t:
        expected.append(x[: 2 * n])
        u, state = c.step(state, model.C @ x)
        x = model.A @ x + model.B @ u
    scale = np.abs(expected).max(axis=0)
    assert np.abs((states_of(run) - expected) / scale).max() < 1e-6


def test_separation_seen_in_time(triple_design):
    # v - T x obeys its own equation e(n+1) = E e(n), whatever F and the reference do.
    rig, c = triple_design.rig, triple_design.controller

    class Unaware(Plain):
        def start(self, x0):
            return self.inner.start()

    x0 = np.array([1e-6, -2e-6, 5e-7, 3e-6, -1e-6, 2e-6])
    run = pl.simulate(rig, Unaware(c), 0.5, initial=x0, reference=1e-6, inner_step=1e-4)
    T, E = c.observer.T, c.observer.E
    error = (run.estimate - states_of(run)) @ T.T
    expected = np.array([np.linalg.matrix_power(E, k) @ (-T @ x0) for k in range(len(run.t))])
    np.testing.assert_allclose(error, expected, atol=1e-5 * np.abs(T @ x0).max())


def test_reference_is_tracked_without_offset(double_design):
    # The integrator is slow: its closed-loop time constant is 10 s.
    rig, c = double_design.rig, double_design.controller
    run = pl.simulate(rig, c, 150.0, reference=0.05)
    assert run.angles[-1, 1] == pytest.approx(0.05, abs=1e-6)


def test_reference_as_number_function_or_rows(design):
    rig, c = design.rig, design.controller
    later = pl.simulate(rig, c, 2.0, reference=lambda t: 0.05 * (t >= 1))
    assert np.abs(later.angles[later.t <= 1]).max() == 0 < np.abs(later.angles).max()
    rows = pl.simulate(rig, c, 2.0, reference=later.y_ref[:, 0])
    np.testing.assert_array_equal(later.angles, rows.angles)
    number, constant = (pl.simulate(rig, c, 1.0, reference=r) for r in (0.05, lambda t: 0.05))
    np.testing.assert_array_equal(number.angles, constant.angles)


# ---- One imperfection at a time


def test_saturation_clips_what_the_controller_asks():
    rig = pl.load("triple")
    on = pl.Imperfections(saturation=True)
    run = pl.simulate(rig, Voltages((20.0, -3.0)), 0.05, imperfections=on)
    np.testing.assert_array_equal(run.u, np.tile([12.0, -2.5], (len(run.t), 1)))
    np.testing.assert_array_equal(run.saturated, [1, 1])
    asked = pl.simulate(rig, Voltages((12.0, -2.5)), 0.05)
    np.testing.assert_array_equal(run.angles, asked.angles)
    free = pl.simulate(rig, Voltages((20.0, -3.0)), 0.05)
    assert np.abs(free.angles - run.angles).max() > 1e-3


def test_the_amplifier_saturates_after_its_filter():
    # A step of 20 V reaches the amplifier as 20 (1 - e^(-w t)); its limit of 12 V cuts that off.
    rig = pl.load("triple")
    w, fine = 2 * np.pi * rig.filters.input_hz[0], 1e-4

    class Expected:
        dt = fine

        def step(self, k, y, y_ref):
            k = 0 if k is None else k
            return [min(20 * (1 - np.exp(-w * (k + 0.5) * fine)), 12.0), 0.0], k + 1

    on = pl.Imperfections(filters=True, saturation=True)
    run = pl.simulate(rig, Voltages((20.0, 0.0)), 0.05, imperfections=on)
    expected = pl.simulate(rig, Expected(), 0.05)
    angles = expected.angles[:: round(run.dt / fine)]
    np.testing.assert_allclose(run.angles, angles, atol=1e-4 * np.abs(angles).max())
    before = pl.simulate(rig, Voltages((12.0, 0.0)), 0.05, imperfections=on)
    assert np.abs(before.angles - run.angles).max() > 0.1 * np.abs(angles).max()
    np.testing.assert_array_equal(run.u[:, 0], 12.0)


@pytest.mark.parametrize("asked, on, sent", [
    (9.0, dict(saturation=True, voltage_resolution=0.4), 9.0),  # the nearest code is 9.2 V
    (9.0, dict(voltage_resolution=0.4), 9.2),
    (-50.0, dict(saturation=True, voltage_resolution=0.4), -9.0),
    (8.9, dict(saturation=True, voltage_resolution=0.4), 8.8),
    (8.99, dict(voltage_resolution=0.4), 8.8),  # the edges of the code 22
    (8.61, dict(voltage_resolution=0.4), 8.8),
])  # fmt: skip
def test_no_rounding_leaves_the_amplifiers_limits(asked, on, sent):
    rig, on = pl.load("double"), pl.Imperfections(**on)
    run = pl.simulate(rig, Voltages((asked,)), 0.1, imperfections=on)
    np.testing.assert_allclose(run.u, sent, rtol=1e-12)
    same = pl.simulate(rig, Voltages((sent,)), 0.1)
    np.testing.assert_allclose(run.angles, same.angles, rtol=1e-9)


def test_resolution_rounds_to_the_nearest_step():
    rig, steps = pl.load("triple"), np.array([1e-3, 2e-3, 5e-4, 1e-2])
    on = pl.Imperfections(resolution=tuple(steps), voltage_resolution=(0.01, 0.003))
    run = pl.simulate(rig, Voltages((0.123, -0.0456)), 0.3, initial=(0.1, -0.1, 0.05),
                      imperfections=on)  # fmt: skip
    truth = np.column_stack([run.angles, run.rates[:, 0]])
    np.testing.assert_allclose(run.y, steps * np.floor(truth / steps + 0.5), atol=1e-15)
    assert np.abs(run.y - truth).max() > 1e-4
    np.testing.assert_allclose(run.u[0], [0.12, -0.045], atol=1e-15)


@pytest.mark.parametrize("delay", [0.0, 0.0004, 0.00777, 0.01])
def test_delay_is_the_two_part_hold(delay):
    rig = pl.load("triple")
    plant = pl.linearize(rig)
    u = 1e-6 * np.random.default_rng(1).standard_normal((40, 2))

    class Sequence:
        dt = 0.01

        def start(self, x0):
            return 0

        def step(self, k, y, y_ref):
            return u[k], k + 1

    on = pl.Imperfections(delay=delay)
    run = pl.simulate(rig, Sequence(), 0.39, imperfections=on, inner_step=1e-4)
    old = input_matrix(plant.A, plant.B, 0.01 - delay, 0.01)
    new = input_matrix(plant.A, plant.B, 0.0, 0.01 - delay)
    x, before, expected = np.zeros(6), np.zeros(2), []
    for k in range(40):
        expected.append(x)
        x = expm(plant.A * 0.01) @ x + old @ before + new @ u[k]
        before = u[k]
    np.testing.assert_allclose(states_of(run), expected, atol=1e-6 * np.abs(expected).max())


def test_pulse_keeps_its_impulse_between_the_steps():
    rig = pl.load("triple")
    plant, kick = pl.linearize(rig), pl.Pulse(2, 0.0133, 0.0047, 1e-6)
    run = pl.simulate(rig, Voltages((0.0, 0.0)), 0.1, disturbance=kick, inner_step=1e-5)
    # A torque on link 2 enters like a motor's, without the opposite torque on the link below.
    motion = pl.derive(3, 2)
    W, M = (np.asarray(a, float) for a in motion.linear(*motion.values(rig))[:2])
    B = np.concatenate([np.zeros(3), W @ np.linalg.solve(M, [0, 1, 0])])[:, None] * kick.height
    end = kick.start + kick.length
    for t, x in zip(run.t, states_of(run)):
        if t >= end:
            expected = input_matrix(plant.A, B, t - end, t - kick.start)[:, 0]
            np.testing.assert_allclose(x, expected, rtol=0, atol=1e-4 * np.abs(expected).max())


def test_start_torque_fades_and_keeps_its_impulse(triple, triple_design):
    law = np.array([0.02, 0.0, -0.01])
    on = pl.Imperfections(start_torque=law)

    def mean(t):  # of law e^(-t/5) over the sample that begins at t
        return law * 5.0 / 0.01 * (np.exp(-t / 5.0) - np.exp(-(t + 0.01) / 5.0))

    fading = pl.simulate(triple, triple_design.controller, 3.0, imperfections=on)
    by_hand = pl.simulate(triple, triple_design.controller, 3.0, disturbance=mean)
    np.testing.assert_allclose(fading.angles, by_hand.angles, atol=1e-12)
    push = dict(disturbance=pl.Pulse(1, 1.0, 0.1, 0.01))
    both = pl.simulate(triple, triple_design.controller, 3.0, imperfections=on, **push)
    assert np.abs(both.angles - fading.angles).max() > 1e-4
    np.testing.assert_array_equal(both.angles[:101], fading.angles[:101])
    # Faded within one sample, it is a pulse of the impulse torque times time constant.
    short = pl.Imperfections(start_torque=(0.0, 0.0, 1e-6), start_torque_time=1e-4)
    free = pl.simulate(triple, Voltages((0.0, 0.0)), 0.02, imperfections=short)
    kick = pl.Pulse(3, 0.0, 0.01, 1e-8)
    same = pl.simulate(triple, Voltages((0.0, 0.0)), 0.02, disturbance=kick)
    np.testing.assert_allclose(free.angles, same.angles, rtol=1e-9)


def test_disturbance_as_a_function_is_held_over_each_sample(triple):
    def torques(t):
        return np.array([0.0, 0.02, 0.0]) * (t >= 0.1)

    by_function = pl.simulate(triple, Voltages((0.0, 0.0)), 0.2, disturbance=torques)
    by_pulse = pl.simulate(triple, Voltages((0.0, 0.0)), 0.2,
                           disturbance=[pl.Pulse(2, 0.1, 0.1, 0.02)])  # fmt: skip
    np.testing.assert_allclose(by_function.angles, by_pulse.angles, atol=1e-12)
    assert np.abs(by_pulse.angles).max() > 1e-4


def test_offset_and_noise_reach_the_readings_only():
    rig, offset, noise = pl.load("double"), (0.01, -0.02, 0.03), np.array([1e-3, 2e-3, 4e-3])
    quiet = Voltages((0.0,), dt=1e-4)  # 5001 readings: five standard deviations of their mean
    on = pl.Imperfections(offset=offset, noise=noise, seed=5)
    run, ideal = (pl.simulate(rig, quiet, 0.5, initial=(0.01, 0), imperfections=i)
                  for i in (on, None))  # fmt: skip
    np.testing.assert_array_equal(run.angles, ideal.angles)
    error = run.y - np.column_stack([run.angles, run.rates[:, 0]]) - offset
    np.testing.assert_allclose(error.std(axis=0), noise, rtol=0.05)
    assert np.all(np.abs(error.mean(axis=0)) < 5 * noise / np.sqrt(len(error)))
    again, other = (pl.simulate(rig, quiet, 0.5, initial=(0.01, 0),
                                imperfections=dataclasses.replace(on, seed=s)) for s in (5, 6))  # fmt: skip
    np.testing.assert_array_equal(run.y, again.y)
    assert np.abs(run.y - other.y).max() > 1e-4


def test_start_is_what_the_sensors_read(double_design):
    c, T = double_design.controller, double_design.observer.T
    on = pl.Imperfections(offset=(0.01, -0.02, 0.0))
    run = pl.simulate(double_design.rig, c, 0.0, initial=(0.03, 0.0), imperfections=on)
    expected = T @ [0.04, -0.02, 0.0, 0.0]
    np.testing.assert_allclose(T @ run.estimate[0], expected, rtol=1e-9)


def test_dry_friction_holds_a_leaning_pendulum_for_ever(rig):
    n, m = rig.n_links, rig.n_motors
    x0 = np.array([0.1, 0.05, -0.1])[:n]
    on = pl.Imperfections(hinge_friction=5.0)
    run = pl.simulate(rig, Voltages((0.0,) * m), 40.0, initial=x0, imperfections=on)
    assert not run.fell and np.abs(run.angles - x0).max() < 1e-3  # within presliding
    assert np.ptp(run.angles[run.t > 30], axis=0).max() < 1e-9  # no creep
    weak = dataclasses.replace(on, hinge_friction=0.05)
    assert pl.simulate(rig, Voltages((0.0,) * m), 40.0, initial=x0, imperfections=weak).fell


@pytest.mark.parametrize("impact", [0.0, 1.0])
def test_closing_gap_converges_to_the_rigid_gear(rig, impact):
    # Voltages that keep pushing one way: half the gap is lost once, so the error is of first order.
    x0 = np.array([0.02, -0.03, 0.01])[: rig.n_links]
    push = Voltages((3.0, -0.8)[: rig.n_motors])
    rigid = pl.simulate(rig, push, 0.3, initial=x0)
    errors, gaps = [], (1e-2, 1e-3, 1e-4, 1e-5)
    for gap in gaps:
        on = pl.Imperfections(gap=gap, contact_stiffness=20 / gap, contact_damping=impact)
        run = pl.simulate(rig, push, 0.3, initial=x0, imperfections=on)
        errors.append(np.abs(run.angles - rigid.angles).max())
    assert all(0.3 * gap < error < gap for gap, error in zip(gaps, errors))


# ---- The bench


@pytest.fixture(scope="module", params=["double", "triple"])
def bench(request):
    rig = pl.load(request.param)
    return dict(
        rig=rig,
        controller=pl.paper_design(request.param).controller,
        initial=pl.bench_start(rig),
        imperfections=pl.bench_imperfections(rig),
    )


def test_bench_has_one_motor_1():
    one, two = (pl.bench_imperfections(pl.load(name)) for name in ("double", "triple"))
    for name in ("gear_friction", "gap", "contact_stiffness", "contact_damping"):
        assert getattr(one, name)[0] == getattr(two, name)[0] > 0


def test_compiled_loop_is_controller_step(bench):
    ours = pl.simulate(**bench, t_end=3.0)
    same = pl.simulate(**bench | dict(controller=Plain(bench["controller"])), t_end=3.0)
    np.testing.assert_array_equal(ours.y, same.y)  # quantised, so equal or a step apart
    np.testing.assert_allclose(ours.u, same.u, atol=1e-12)
    np.testing.assert_allclose(ours.angles, same.angles, atol=1e-9)
    # And sample by sample, each from the same state and reading.
    c = bench["controller"]
    state = c.start(np.concatenate([ours.y[0, :-1], np.zeros(ours.rig.n_links)]))
    exact = dataclasses.replace(bench["imperfections"], voltage_resolution=0.0)
    ours = pl.simulate(**bench | dict(imperfections=exact), t_end=3.0)
    for k in range(len(ours.t)):
        np.testing.assert_allclose(ours.estimate[k], c.estimate(state, ours.y[k]), atol=1e-10)
        u, state = c.step(state, ours.y[k], 0.0)
        np.testing.assert_allclose(ours.u[k], u, atol=1e-11)


@pytest.mark.parametrize("limit", [None, 0.5])
def test_compiled_loop_keeps_the_controllers_own_limits(design, limit):
    u_max = limit and (limit,) * design.rig.n_motors
    c = dataclasses.replace(design.controller, u_max=u_max)
    ours, same = (pl.simulate(design.rig, k, 0.2, initial=small_start(design.rig, 0.03))
                  for k in (c, Plain(c)))  # fmt: skip
    np.testing.assert_allclose(ours.u, same.u, atol=1e-9)
    largest = np.abs(ours.u).max()
    assert largest > 0.5 if limit is None else largest == limit


def test_halving_the_inner_step_changes_no_visible_digit(bench):
    """A line on a page is about 2e-3 rad wide in Figs 15-17."""
    exact = dataclasses.replace(bench["imperfections"], resolution=0.0, voltage_resolution=0.0)
    for on, t_end, least in [
        (pl.Imperfections(), 37.0, 1e-6),
        (dataclasses.replace(exact, gap=0.0), 10.0, 2e-5),
        (exact, 3.0, 2e-3),
    ]:
        coarse = pl.simulate(**bench | dict(imperfections=on), t_end=t_end)
        half = coarse.inner_step / 2
        fine = pl.simulate(**bench | dict(imperfections=on), t_end=t_end, inner_step=half)
        assert fine.inner_step <= half * (1 + 1e-9) and not fine.fell
        assert np.abs(coarse.angles - fine.angles).max() < least


def test_halving_the_inner_step_keeps_the_ranges_of_chaotic_motion(bench):
    """Rounding in the converters turns any difference, however small, into one of a whole step, and
    motion in the gap multiplies it: no step size fixes a single trace, but it fixes their ranges."""
    cases = [dict(initial=np.array(bench["initial"]) + e) for e in np.linspace(-1e-3, 1e-3, 12)]
    arguments = {key: value for key, value in bench.items() if key != "initial"}
    coarse = pl.simulate_many(**arguments, t_end=18.0, cases=cases)
    half = coarse[0].inner_step / 2
    fine = pl.simulate_many(**arguments, t_end=18.0, cases=cases, inner_step=half)
    for column in range(bench["rig"].n_links):
        ranges = [
            np.median([np.ptp(run.angles[run.t > 10, column]) for run in runs])
            for runs in (coarse, fine)
        ]
        assert ranges[0] == pytest.approx(ranges[1], rel=0.06)


def test_equal_calls_give_equal_results(bench):
    one, two = (pl.simulate(**bench, t_end=2.0) for _ in range(2))
    for field in ("angles", "rates", "u", "y", "estimate"):
        np.testing.assert_array_equal(getattr(one, field), getattr(two, field))


def test_stretches_of_the_compiled_loop_join_without_a_seam(bench, monkeypatch):
    held = dict(disturbance=lambda t: 0.01 * np.sin(t + np.arange(bench["rig"].n_links)))
    for loads in (held, dict(disturbance=pl.Pulse(2, 0.295, 0.02, 0.1))):
        whole = pl.simulate(**bench, **loads, t_end=1.0)
        with monkeypatch.context() as patch:
            patch.setattr("pendlab.bench.stepping.PATIENCE", 10 * round(0.01 / whole.inner_step))
            parts = pl.simulate(**bench, **loads, t_end=1.0)
        for field in ("angles", "rates", "u", "y", "estimate"):
            np.testing.assert_array_equal(getattr(whole, field), getattr(parts, field))


def test_simulate_many_equals_a_loop(bench):
    cases = [dict(disturbance=pl.Pulse(1, 0.5, 0.1, 0.02 * k)) for k in range(6)]
    cases.append(dict(imperfections=pl.Imperfections(), t_end=0.5))
    seen = []
    many = pl.simulate_many(**bench, t_end=1.0, cases=cases, workers=3,
                            progress=lambda done, total: seen.append((done, total)))  # fmt: skip
    assert not many.stopped and many.done == len(many) == 7
    for run, case in zip(many, cases):
        alone = pl.simulate(**dict(t_end=1.0) | bench | case)
        np.testing.assert_array_equal(run.angles, alone.angles)
        np.testing.assert_array_equal(run.u, alone.u)
    assert seen[0] == (0, 7) and seen[-1] == (7, 7) and seen == sorted(seen)


@pytest.fixture(scope="module")
def processes():
    with ProcessPoolExecutor(2, get_context("spawn")) as executor:
        yield executor


def test_processes_give_what_a_loop_gives(bench, processes):
    cases = [dict(disturbance=pl.Pulse(1, 0.5, 0.1, 0.02 * k)) for k in range(4)]
    cases.append(dict(controller=Plain(bench["controller"]), t_end=0.2))
    seen = []
    many = pl.simulate_many(**bench, t_end=0.6, cases=cases, executor=processes,
                            progress=lambda done, total: seen.append(done))  # fmt: skip
    assert many.done == 5 and seen[-1] == 5
    for run, case in zip(many, cases):
        alone = pl.simulate(**dict(t_end=0.6) | bench | case)
        for field in ("t", "angles", "rates", "u", "y", "estimate"):
            np.testing.assert_array_equal(getattr(run, field), getattr(alone, field))


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("IPYTHONDIR", str(tmp_path_factory.mktemp("engines")))
        with ipyparallel.Cluster(n=1, log_level=logging.ERROR) as engines:
            yield engines


def test_a_cluster_gives_what_a_loop_gives(bench, cluster):
    assert cluster[0].apply_sync(os.getpid) != os.getpid()
    executor = cluster.executor()
    cases = [dict(disturbance=pl.Pulse(1, 0.1, 0.1, 0.02 * k)) for k in range(3)]
    many = pl.simulate_many(**bench, t_end=0.4, cases=cases, executor=executor)
    assert many.done == 3
    for run, case in zip(many, cases):
        alone = pl.simulate(**bench, t_end=0.4, **case)
        for field in ("t", "angles", "rates", "u", "y", "estimate"):
            np.testing.assert_array_equal(getattr(run, field), getattr(alone, field))


def test_what_goes_wrong_on_a_cluster_is_named(triple_design, cluster):
    rig, c = triple_design.rig, triple_design.controller
    with pytest.raises(ValueError, match=r"cases\[1\].*initial: expected 3 relative angles"):
        pl.simulate_many(rig, c, 0.1, [{}, dict(initial=(1,))], executor=cluster.executor())


def test_what_goes_wrong_in_another_process_is_named(triple_design, processes):
    rig, c = triple_design.rig, triple_design.controller
    with pytest.raises(ValueError, match=r"cases\[1\]: initial: expected 3 relative angles"):
        pl.simulate_many(rig, c, 0.1, [{}, dict(initial=(1,))], executor=processes)
    with pytest.raises(ValueError, match=r"cases\[0\]: cannot be sent to another process"):
        pl.simulate_many(rig, c, 0.1, [dict(reference=lambda t: 0.0)], executor=processes)
    with pytest.raises(ValueError, match=r"cases\[0\]: controller: step failed at t = 0\.02 s"):
        pl.simulate_many(rig, Brittle(), 0.1, [{}], executor=processes)
    assert pl.simulate_many(rig, c, 0.1, [{}], executor=processes).done == 1  # it stays open
    closed = ProcessPoolExecutor(1, get_context("spawn"))
    closed.shutdown()
    with pytest.raises(ValueError, match=r"executor: took no case 0 \(RuntimeError"):
        pl.simulate_many(rig, c, 0.1, [{}], executor=closed)
    with pytest.raises(TypeError, match=r"executor: expected a concurrent\.futures executor"):
        pl.simulate_many(rig, c, 0.1, [{}], executor=4)
    with pytest.raises(
        TypeError, match=r"cases\[0\]: expected arguments of pl\.simulate .*'pulse'"
    ):
        pl.simulate_many(rig, c, 0.1, [dict(pulse=1)])
    with ProcessPoolExecutor(1, get_context("spawn")) as broken:
        with pytest.raises(ValueError, match=r"executor: failed at cases\[0\] \(BrokenProcessPool"):
            pl.simulate_many(rig, Dying(), 0.1, [{}], executor=broken)


def test_simulate_many_can_be_stopped(bench):
    def stop(done, total):
        if done >= 3:
            raise KeyboardInterrupt

    many = pl.simulate_many(**bench, t_end=0.5, cases=[{}] * 50, workers=1, progress=stop)
    assert many.stopped and 3 <= many.done < 50
    assert all(run is not None for run in many[:3]) and many[-1] is None


def test_progress_bar_is_for_terminals_or_on_request(bench, capsys):
    pl.simulate_many(**bench, t_end=0.1, cases=[{}, {}])
    assert capsys.readouterr() == ("", "")
    pl.simulate_many(**bench, t_end=0.1, cases=[{}, {}], progress=True)
    assert capsys.readouterr().err.endswith("2/2\n")
    _bar(1, 4)
    assert capsys.readouterr().err == "\r[" + 10 * "#" + 30 * "." + "] 1/4"


@pytest.mark.parametrize("start, length", [(0.0203, 0.0004), (0.0208, 0.0005), (0.0295, 0.0032)])
def test_a_pulse_keeps_its_impulse_whatever_the_inner_step(start, length):
    rig = pl.load("double")
    pulse = pl.Pulse(2, start, length, 1e-4)
    coarse, fine = (
        pl.simulate(rig, Voltages((0.0,)), 0.1, disturbance=pulse, inner_step=step)
        for step in (1e-3, 2e-5)
    )
    assert np.abs(fine.angles[-1]).min() > 0
    np.testing.assert_allclose(coarse.angles[-1], fine.angles[-1], rtol=0.02)


# ---- Figs 15-17 without a mechanism (their ticks: test_experiment.py)


def panel_traces(run, start, end):
    """Angles, rate and voltages as recorded by the computer, one entry per panel."""
    rows = (run.t > start - 1e-9) & (run.t < end + 1e-9)
    return [run.y[rows, :-1], run.y[rows, -1:], *run.u[rows].T]


def test_backlash_alone_does_not_look_like_the_figures(triple, triple_design):
    on = pl.bench_imperfections(triple)
    bare = dataclasses.replace(on, gear_friction=0.0, offset=0.0)
    ranges = {}
    for label, settings in (("both", on), ("backlash", bare)):
        run = pl.simulate(triple, triple_design.controller, 37.0, initial=pl.bench_start(triple),
                          imperfections=settings)  # fmt: skip
        ranges[label] = [np.ptp(trace) for trace in panel_traces(run, 30, 37)]
    for with_friction, without in zip(ranges["both"], ranges["backlash"]):
        assert without > 1.3 * with_friction


# ---- Misuse


class Failing:
    dt = 0.01

    def __init__(self, answer):
        self.answer = answer

    def start(self, x0):
        return 0

    def step(self, k, y, y_ref):
        return self.answer(k), k + 1


@pytest.mark.parametrize(
    "answer, message",
    [
        (lambda k: [0.0, np.nan if k == 7 else 0.0], r"at t = 0\.07 s returned .*finite"),
        (lambda k: [0.0] * (3 if k == 7 else 2), r"at t = 0\.07 s must return 2 voltages"),
        (lambda k: "one" if k == 7 else [0, 0], r"at t = 0\.07 s must return 2 voltages"),
        (lambda k: [0, 1 / (7 - k)], r"step failed at t = 0\.07 s \(ZeroDivisionError"),
    ],
)
def test_failing_controller_is_named_with_its_time(triple, answer, message):
    with pytest.raises(ValueError, match=message) as caught:
        pl.simulate(triple, Failing(answer), 1.0)
    if "ZeroDivision" in message:
        assert isinstance(caught.value.__cause__, ZeroDivisionError)


def test_step_must_return_a_pair(triple):
    class Bare(Failing):
        def step(self, state, y, y_ref):
            return np.zeros(2)

    with pytest.raises(ValueError, match=r"at t = 0 s must return the pair \(u, next state\)"):
        pl.simulate(triple, Bare(None), 1.0)


@pytest.mark.parametrize(
    "changes, message",
    [
        (dict(initial=(0.1, 0.2)), "initial: expected 3 relative angles"),
        (dict(initial=(2.0, 0, 0)), "initial: a link starts past the horizontal"),
        (dict(reference=[0.0, 1.0]), "reference: expected a number"),
        (dict(dt=0.02), "dt: the controller is made for 0.01 s"),
        (dict(inner_step=0.012), "inner_step: 0.012 s is too coarse .* use at most"),
        (dict(inner_step=-1.0), "inner_step: expected a number above 0"),
        (dict(t_end=np.nan), "t_end: expected a finite number"),
        (dict(disturbance=pl.Pulse(4, 0, 1, 1)), "disturbance: the rig has links 1 to 3, found 4"),
        (dict(imperfections=pl.Imperfections(delay=0.02)), "delay: expected at most .* 0.01 s"),
        (dict(imperfections=pl.Imperfections(gap=(0.1, 0.1, 0.1))), "gap: expected 2 numbers"),
        (dict(imperfections=pl.Imperfections(offset=(0, 0))), "offset: expected 4 numbers"),
        (dict(rig=pl.load("double")), "controller: the rig has 4 states"),
    ],
)
def test_bad_arguments_are_named(triple_design, changes, message):
    arguments = dict(rig=triple_design.rig, controller=triple_design.controller, t_end=1.0)
    with pytest.raises(ValueError, match=message):
        pl.simulate(**arguments | changes)


@pytest.mark.parametrize(
    "changes, message",
    [
        (dict(gap=-0.1), "gap.*at least 0"),
        (dict(delay=-1e-3), "delay: expected a number of at least 0"),
        (dict(noise=(0, -1)), r"noise\[1\]: expected a number of at least 0"),
        (dict(presliding=0.0), "presliding: expected a number above 0"),
        (dict(contact_stiffness=0.0), "contact_stiffness: expected numbers above 0"),
        (dict(seed=-1), "seed: expected a whole number"),
        (dict(offset=np.inf), "offset.*finite"),
    ],
)
def test_bad_imperfections_are_named(changes, message):
    with pytest.raises(ValueError, match=message):
        pl.Imperfections(**changes)


def test_wrong_kinds_are_named(triple_design):
    rig, c = triple_design.rig, triple_design.controller
    with pytest.raises(TypeError, match=r"controller: expected an object with step"):
        pl.simulate(rig, object(), 1.0)
    with pytest.raises(TypeError, match=r"imperfections: expected a pl\.Imperfections"):
        pl.simulate(rig, c, 1.0, imperfections=dict(gap=0.05))
    with pytest.raises(TypeError, match=r"disturbance: entry 1: expected a pl\.Pulse"):
        pl.simulate(rig, c, 1.0, disturbance=[0.1])
    with pytest.raises(
        TypeError, match=r"disturbance: expected a list of pl\.Pulse or a function of t, found 0\.1"
    ):
        pl.simulate(rig, c, 1.0, disturbance=0.1)
    with pytest.raises(TypeError, match=r"cases: expected dicts of arguments"):
        pl.simulate_many(rig, c, 0.1, None)
    with pytest.raises(ValueError, match=r"cases\[1\]: initial: expected 3 relative angles"):
        pl.simulate_many(rig, c, 0.1, [{}, dict(initial=(1,))])
    with pytest.raises(ValueError, match=r"filters: switched on, but rig\.filters is None"):
        bare = dataclasses.replace(rig, filters=None)
        pl.simulate(bare, c, 1.0, imperfections=pl.Imperfections(filters=True))


@pytest.mark.parametrize(
    "old, new, message",
    [
        ("[sensors]", "[sensor]", r"section \[sensors\] is missing"),
        (
            "gap               = {value",
            "gap               = {number",
            "entry 'gap' is missing or has no value",
        ),
        (
            "gap               = {value",
            'gap               = {value = "wide", was',
            "entry 'gap': expected numbers, found 'wide'",
        ),
        ("{value = 12,", "{value = [1, 2],", r"entry 'bits': expected a whole number .* \[1, 2\]"),
        ("[sensors]", "[sensors", "not readable as TOML"),
    ],
)
def test_damaged_bench_file_names_file_and_entry(tmp_path, monkeypatch, old, new, message):
    source = gearbox.DATA / "gearbox.toml"
    text = source.read_text(encoding="utf-8")
    assert old in text
    (tmp_path / source.name).write_text(text.replace(old, new, 1), encoding="utf-8")
    monkeypatch.setattr(gearbox, "DATA", tmp_path)
    with pytest.raises((TypeError, ValueError), match=rf"gearbox\.toml: {message}"):
        pl.bench_imperfections(pl.load("triple"))


def test_settings_compare_and_replace():
    one = pl.Imperfections(gap=[0.05, 0.04])
    assert one == pl.Imperfections(gap=(0.05, 0.04))
    assert len({one, pl.Imperfections(gap=(0.05, 0.04)), pl.Imperfections(gap=0.05)}) == 2
    assert dataclasses.replace(one, gap=0.0) == pl.Imperfections()
