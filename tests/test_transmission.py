"""Closed-loop transmission and structured margin against definitions, grids and the simulator."""

from dataclasses import replace

import control
import numpy as np
import pytest

import pendlab as pl
from pendlab.studies.structured import structured_sigma

PAPER = {name: pl.paper_design(name) for name in ("double", "triple")}
BOTH = replace(
    PAPER["triple"], Q=(0.1, 1, 1, 1, 1, 1, 10, 10), R=(1, 1), kp=None, tracked=(1, 2),
    coefficients=None,
)  # fmt: skip


@pytest.mark.parametrize("filters", [False, True])
@pytest.mark.parametrize("design", [*PAPER.values(), BOTH], ids=["double", "triple", "both"])
def test_eigenvalues_are_those_of_the_loop(design, filters):
    loop = design.filtered_loop if filters else design.nominal_loop
    ours = np.linalg.eigvals(pl.closed_loop(design, filters).A)
    for value in pl.closed_loop_eigenvalues(loop):
        assert np.abs(ours - value).min() < 1e-5  # double eigenvalues of the observer: eps^(1/2)


def test_torque_enters_as_in_the_nonlinear_model():
    """A constant torque's first accelerations, against virtual work on the energy's mass matrix."""
    rig = pl.load("triple")
    plant = pl.with_torques(pl.linearize(rig), rig)
    motion = pl.derive(3, 2)
    M, _ = motion.nonlinear(np.zeros(3), np.zeros(3), motion.values(rig))
    absolute = np.cumsum(plant.B[3:, 2:], axis=0)  # absolute accelerations from relative ones
    assert np.allclose(np.asarray(M) @ absolute, np.eye(3), atol=1e-12)


def test_small_torque_and_reference_agree_with_the_simulation():
    rig, t = BOTH.rig, 2.0
    size = 1e-6
    run = pl.simulate(
        rig, BOTH.controller, t, reference=lambda s: (size, -size),
        imperfections=pl.Imperfections(filters=True), disturbance=lambda s: np.array([0, 0, size]),
    )  # fmt: skip
    loop = pl.closed_loop(BOTH)
    drive = loop[:, ["torque 3", "reference theta2-theta1", "reference theta3-theta2"]]
    inputs = size * np.array([[1], [1], [-1]]) * np.ones(len(run.t))
    linear = control.forced_response(drive, run.t, inputs).outputs
    assert np.allclose(run.angles, linear[:3].T, atol=1e-3 * np.abs(linear[:3]).max())
    assert np.allclose(run.u, linear[3:].T, atol=1e-3 * np.abs(linear[3:]).max())


def test_rms_is_the_energy_of_the_impulse_responses():
    loop = pl.closed_loop(BOTH)
    pulses = [control.impulse_response(loop[:, i], T=60).outputs for i in range(4)]
    sizes = np.array([1, 2, 3, 4])
    energy = sum(size**2 * (h.reshape(5, -1) ** 2).sum(1) for size, h in zip(sizes, pulses))
    # control scales a discrete impulse to 1/dt
    expected = np.sqrt(energy) * BOTH.dt
    assert np.allclose(pl.rms(loop[:, :4], sizes), expected, rtol=1e-4)


def test_peak_gain_agrees_with_control_where_it_answers():
    path = pl.closed_loop(BOTH)[["u1", "u2"], :4]
    for u in ("u1", "u2"):
        for i in range(4):
            single = path[u, i]
            assert pl.peak_gain(single)[0] == pytest.approx(control.norm(single, "inf"), rel=1e-5)


def test_rms_is_the_root_of_the_sum_of_the_squared_impulse_response():
    path = pl.closed_loop(BOTH)[["u1", "u2"], :4]
    states, total = path.B, np.sum(path.D**2)
    for _ in range(5000):
        total += np.sum((path.C @ states) ** 2)
        states = path.A @ states
    assert np.abs(states).max() < 1e-9
    assert np.linalg.norm(pl.rms(path)) == pytest.approx(np.sqrt(total), rel=1e-9)


def test_rms_of_modes_that_fade_at_once_and_slowly():
    """Variance 1/(1 - a^2) each, from no noise to more than can be squared."""
    modes = np.array([0.0, 0.5, 0.9999])
    system = control.ss(np.diag(modes), np.eye(3), np.eye(3), 0, 0.01)
    for size in (0.0, 1e-200, 1.0, 1e200):
        expected = size / np.sqrt(1 - modes**2)
        np.testing.assert_allclose(pl.rms(system, size), expected, rtol=1e-9)


def test_rms_predicts_a_noisy_run():
    noise = 2e-4
    run = pl.simulate(
        BOTH.rig,
        BOTH.controller,
        150,
        imperfections=pl.Imperfections(filters=True, noise=noise, seed=1),
    )
    predicted = pl.rms(pl.closed_loop(BOTH)[["u1", "u2"], :4], noise)
    assert run.u[500:].std(axis=0) == pytest.approx(predicted, rel=0.03)


@pytest.mark.parametrize("loop", [PAPER["triple"].nominal_loop, PAPER["triple"].filtered_loop,
                                  BOTH.filtered_loop])  # fmt: skip
def test_structured_change_reaches_the_circle_and_no_smaller_one_does(loop):
    found = pl.structured_margin(loop)
    assert np.abs(found.delta) == pytest.approx([found.value] * 2)
    changed = np.linalg.eigvals(loop.A - loop.B @ np.diag(found.factors) @ loop.C)
    assert np.abs(changed - np.exp(1j * found.omega * loop.dt)).min() < 1e-9
    # Brute force: at each frequency and phase of d1, the d2 that makes the determinant zero.
    L = pl.frequency_response(loop, pl.frequency_grid(loop.dt, 400))
    a, b, c = 1 + L[:, 0, 0], 1 + L[:, 1, 1], L[:, 0, 1] * L[:, 1, 0]
    d1 = 0.98 * found.value * np.exp(1j * np.linspace(0, 2 * np.pi, 361))
    for shrink in (1.0, 0.5, 0.0):
        d2 = c[:, None] / (a[:, None] + shrink * d1) - b[:, None]
        assert np.abs(d2).min() > 0.98 * found.value


def test_structured_margin_is_used_up_at_rest():
    """x+ = 1.5 x + u, u = -0.5 x beside a loop at ease: the eigenvalue 1 is met at frequency 0."""
    found = pl.structured_margin(
        control.ss(np.diag([1.5, 0.5]), np.eye(2), np.diag([0.5, 0.1]), 0, 0.01)
    )
    assert found.value == pytest.approx(0, abs=1e-12) and found.omega == 0 and not found.stable


def test_structured_lies_between_the_unstructured_and_the_single_margins():
    L = pl.frequency_response(PAPER["triple"].filtered_loop, pl.frequency_grid(0.01, 300))
    Rd = np.eye(2) + L
    det = np.abs(np.linalg.det(Rd))
    structured = structured_sigma(L)
    assert np.all(structured >= np.linalg.svd(Rd, compute_uv=False)[:, -1] * (1 - 1e-9))
    assert np.all(structured <= det / np.abs(Rd[:, 1, 1]) * (1 + 1e-9))
    assert np.all(structured <= det / np.abs(Rd[:, 0, 0]) * (1 + 1e-9))
    scaled = np.diag([7.0, 0.2]) @ L @ np.diag([1 / 7.0, 5.0])  # other units of the inputs
    assert np.allclose(structured_sigma(scaled), structured)


def test_structured_of_uncoupled_loops_is_the_nearest_of_the_two():
    A, B = np.diag([0.5, 0.7]), np.eye(2)
    loop = control.ss(A, B, np.diag([0.3, 0.2]), 0, 0.01)
    single = [pl.margins(pl.broken_at(loop, i)).modulus for i in (0, 1)]
    found = pl.structured_margin(loop)
    assert found.value == pytest.approx(min(single), rel=1e-6)
    assert np.count_nonzero(found.delta) == 1 and found.stable
    falling = control.ss(np.diag([1.5, 0.7]), B, np.diag([0.3, 0.2]), 0, 0.01)  # one of the two
    assert not pl.structured_margin(falling).stable


def test_bad_input():
    rig = pl.load("triple")
    with pytest.raises(TypeError, match=r"rig: expected a pl\.Pendulum"):
        pl.with_torques(pl.linearize(rig), "triple")
    with pytest.raises(ValueError, match="plant: expected the continuous model"):
        pl.with_torques(pl.sample(pl.linearize(rig)), rig)
    with pytest.raises(TypeError, match=r"design: expected a pl\.Design"):
        pl.closed_loop(rig)
    with pytest.raises(ValueError, match="must be stable"):
        pl.rms(pl.sample(pl.linearize(rig)))
    with pytest.raises(ValueError, match=r"use pl\.sample"):
        pl.peak_gain(pl.linearize(rig))
    with pytest.raises(ValueError, match="deviations"):
        pl.rms(pl.closed_loop(BOTH), [1.0, 2.0])
    with pytest.raises(ValueError, match="expected two inputs"):
        pl.structured_margin(PAPER["double"].filtered_loop)


def test_figures_tell_designs_apart():
    first, second = {"a": PAPER["triple"]}, {"a": BOTH}
    from pendlab.figures.disturbances import gain_region_figure, transmission_figure

    for make, options in (
        (transmission_figure, {"points": 40}),
        (gain_region_figure, {"points": 9}),
    ):
        one, other, both = (
            make(designs, **options) for designs in (first, second, first | {"b": BOTH})
        )
        assert one.caption != other.caption
        assert one.alt and "b" in both.caption
        with pytest.raises(TypeError, match="designs"):
            make(BOTH)


def test_gain_region_agrees_with_the_margins_of_one_input():
    from pendlab.figures.disturbances import largest_eigenvalue

    loop = PAPER["triple"].filtered_loop
    limit = pl.margins(pl.broken_at(loop, 1)).gain_up
    for factor, stable in ((0.999 * limit, True), (1.001 * limit, False)):
        table = largest_eigenvalue(loop, np.array([1.0, factor]))
        assert (table[1, 0] < 1) == stable  # rows: input 2, columns: input 1
