"""Loop analysis: responses, return differences, encirclements, margins, all by a second way."""

import dataclasses
import itertools
import warnings

import control
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.linalg import block_diag
from strategies import between, decades, rigs, weights

import pendlab as pl
from pendlab.loop import prepared, sorted_eigenvalues
from pendlab.nyquist import _phase_change, contour

NYQUIST = np.pi / 0.01


def random_system(seed, n, m, radius, gain=1.0):
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((n, n))
    A *= radius / np.abs(np.linalg.eigvals(A)).max()
    return control.ss(A, rng.standard_normal((n, m)), gain * rng.standard_normal((m, n)), 0, 0.01)


@given(st.integers(0, 2**32 - 1), st.integers(1, 8), st.integers(1, 3))
def test_frequency_response_is_python_controls(seed, n, m):
    system = random_system(seed, n, m, 0.95)
    omega = np.geomspace(0.1, NYQUIST, 50)
    theirs = np.moveaxis(system(np.exp(0.01j * omega), squeeze=False), -1, 0)
    np.testing.assert_allclose(pl.frequency_response(system, omega), theirs, atol=1e-9)
    continuous = control.ss(system.A, system.B, system.C, np.ones((m, m)))
    theirs = np.moveaxis(continuous(1j * omega, squeeze=False), -1, 0)
    np.testing.assert_allclose(pl.frequency_response(continuous, omega), theirs, atol=1e-9)


def test_transfer_of_a_jordan_block():
    """Three equal eigenvalues and one eigenvector: C (zI - A)^-1 B = 1/(z - 0.5)^3."""
    A = 0.5 * np.eye(3) + np.eye(3, k=1)
    system = control.ss(A, [[0], [0], [1]], [[1, 0, 0]], 0, 0.01)
    z = np.exp(1j * np.linspace(0, np.pi, 7))
    np.testing.assert_allclose(prepared(system)(z)[:, 0, 0], (z - 0.5) ** -3, rtol=1e-12)


def test_loop_gain_is_the_product(design):
    omega = np.geomspace(0.1, NYQUIST, 30)
    for plant in (design.model, design.filtered):
        P = -pl.frequency_response(design.controller.system, omega)
        G = pl.frequency_response(plant, omega)
        PG = pl.loop_gain(design.controller, plant, omega)
        assert PG.shape == (30, plant.ninputs, plant.ninputs)
        np.testing.assert_allclose(PG, P @ G, rtol=1e-6, atol=1e-9 * np.abs(P @ G).max())


@pytest.mark.parametrize("filters", [False, True])
def test_return_differences(triple_design, filters):
    """(33)-(35), each also as 1 + the loop broken at that input, and as eigenvalue quotient."""
    d = triple_design
    plant, loop = (d.filtered, d.filtered_loop) if filters else (d.model, d.nominal_loop)
    omega = np.geomspace(0.05, NYQUIST, 80)
    r = pl.return_differences(d.controller, plant, omega)
    PG = pl.loop_gain(d.controller, plant, omega)
    for k, rd in ((0, r.rd1), (1, r.rd2)):
        other = PG[:, 1 - k, 1 - k]
        np.testing.assert_allclose(rd * (1 + other), r.det, rtol=1e-9)
        broken = pl.frequency_response(pl.broken_at(loop, k), omega)[:, 0, 0]
        np.testing.assert_allclose(1 + broken, rd, rtol=1e-6, atol=1e-8)
        # One loop closed by hand: p1 g1 less what loop 2 takes away.
        by_hand = PG[:, k, k] - PG[:, k, 1 - k] * PG[:, 1 - k, k] / (1 + other)
        np.testing.assert_allclose(1 + by_hand, rd, rtol=1e-8, atol=1e-10)
    singular = np.linalg.svd(np.eye(2) + PG, compute_uv=False)
    np.testing.assert_allclose(r.sigma_min, singular[:, 1])
    np.testing.assert_allclose(np.prod(singular, axis=1), np.abs(r.det), rtol=1e-9)
    opened, closed = np.linalg.eigvals(loop.A), pl.closed_loop_eigenvalues(loop)
    z = np.exp(0.01j * omega)[:, None]
    quotient = np.prod((z - closed) / (z - opened), axis=1)
    np.testing.assert_allclose(r.det, quotient, rtol=1e-4)


def test_smallest_singular_value_bounds_both_loops(triple_design):
    """sigma_min(I + PG) <= 1/|[(I + PG)^-1]_kk| = |rd_k|."""
    omega = np.geomspace(0.05, NYQUIST, 200)
    r = pl.return_differences(triple_design.controller, triple_design.filtered, omega)
    assert np.all(r.sigma_min <= np.minimum(np.abs(r.rd1), np.abs(r.rd2)) * (1 + 1e-9))


@given(st.integers(0, 2**32 - 1), st.integers(2, 6), st.integers(2, 3))
def test_broken_at_keeps_the_closed_loop(seed, n, m):
    loop = random_system(seed, n, m, 1.3)
    for k in range(m):
        np.testing.assert_allclose(
            np.poly(pl.closed_loop_eigenvalues(pl.broken_at(loop, k))).real,
            np.poly(pl.closed_loop_eigenvalues(loop)).real,
            atol=1e-6 * np.abs(np.poly(pl.closed_loop_eigenvalues(loop))).max(),
        )


def test_eigenvalues_sorted():
    A = np.diag([0.5, -2.0, 0.0, 1.0])
    A = block_diag(A, [[0, 1], [-1, 0]])
    np.testing.assert_allclose(sorted_eigenvalues(A), [-2, 1j, -1j, 1, 0.5, 0], atol=1e-15)


def unstable(A):
    return int(np.sum(np.abs(np.linalg.eigvals(A)) > 1))


@settings(max_examples=150)
@given(
    st.integers(0, 2**32 - 1),
    st.integers(1, 7),
    st.integers(1, 3),
    st.sampled_from([0.5, 0.95, 0.999, 1.0001, 1.2, 2.0]),
    decades(-4, 1),
)
def test_encirclements_are_unstable_poles(seed, n, m, radius, gain):
    """Stable and unstable loops, resonances close to the circle, one to three inputs."""
    loop = random_system(seed, n, m, radius, gain)
    count = pl.encirclements(loop)
    assert count.unstable_open == unstable(loop.A)
    assert count.unstable_closed == unstable(loop.A - loop.B @ loop.C)
    assert count.turns == count.unstable_open - count.unstable_closed
    assert count.stable == (count.unstable_closed == 0)


ON_CIRCLE = {
    "at 1": [[1.0]],
    "at -1": [[-1.0]],
    "at 1 and -1": np.diag([1.0, -1.0]),
    "pair": [[np.cos(1), -np.sin(1)], [np.sin(1), np.cos(1)]],
    "slow pair": [[np.cos(1e-3), -np.sin(1e-3)], [np.sin(1e-3), np.cos(1e-3)]],
    "twice at 1": [[1.0, 0.01], [0.0, 1.0]],
    "at 1 and 1.1": np.diag([1.0, 1.1]),
    "close pairs": np.diag(np.exp([1j, -1j, 1.001j, -1.001j])),
}


@pytest.mark.parametrize("where", ON_CIRCLE)
def test_poles_on_the_circle_are_left_inside(where):
    """The contour goes round them outside, so that they count as stable open-loop poles."""
    A = np.array(ON_CIRCLE[where])
    if np.iscomplexobj(A):  # as real 2 x 2 blocks
        X = np.kron(np.eye(2), [[1, 1], [1j, -1j]])
        A = (X @ A @ np.linalg.inv(X)).real
    n = len(A)
    rng = np.random.default_rng(11)
    for _ in range(30):
        C = rng.standard_normal((1, n)) * 10 ** rng.uniform(-3, 0.5)
        loop = control.ss(A, rng.standard_normal((n, 1)), C, 0, 0.01)
        closed = np.linalg.eigvals(loop.A - loop.B @ loop.C)
        if np.abs(np.abs(closed) - 1).min() < 1e-6:
            continue
        count = pl.encirclements(loop)
        assert count.unstable_open == int("1.1" in where)
        assert count.turns == count.unstable_open - unstable(loop.A - loop.B @ loop.C)


@given(st.integers(0, 2**32 - 1), st.integers(1, 5), decades(-2, 0.5))
def test_encirclements_are_python_controls(seed, n, gain):
    """With an integrator; python-control counts clockwise turns about -1."""
    base = random_system(seed, n, 1, 1.2, gain)
    A = np.block([[base.A, np.zeros((n, 1))], [np.ones((1, n)), np.eye(1)]])
    loop = control.ss(A, np.vstack([base.B, [[0.1]]]), np.hstack([base.C, [[0.3 * gain]]]), 0, 0.01)
    closed = np.linalg.eigvals(loop.A - loop.B @ loop.C)
    assume(np.abs(np.abs(closed) - 1).min() > 1e-3)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # its notes on frequency ranges
        theirs = control.nyquist_response(loop).count
    assert pl.encirclements(loop).turns == -theirs


def test_encirclements_of_the_papers_loops(design):
    """Stable closed loops, with filters and without: turns = unstable poles, here all the plant's."""
    plant_poles = unstable(design.model.A)
    for filters in (False, True):
        loop = design.filtered_loop if filters else design.nominal_loop
        count = pl.encirclements(loop)
        assert count.stable and count.turns == count.unstable_open == plant_poles
    assert pl.encirclements(design.state_feedback_loop).stable


@pytest.mark.parametrize(
    "place, width, change",
    [(0.3012, 1e-3, 4 * np.pi + 1), (0.7954, 1.27e-4, -19.26), (0.3012, 3e-12, 4 * np.pi + 1)],
)
def test_turns_within_one_step_are_followed(place, width, change):
    """Turns within less than one step of 1/200 are seen only by halving the steps at that place."""

    def det(z):
        return np.exp(1j * change * np.clip((z.real - place) / width, 0, 1))

    def piece(t):
        return np.asarray(t, dtype=complex)

    assert _phase_change(det, piece) == pytest.approx(change, abs=1e-9)


@pytest.mark.parametrize("dt", [1, 1.0])
def test_sampled_every_second(dt):
    """python-control's True says sampled without a time; 1 is a time like any other."""
    model = control.ss([[1.2]], [[1.0]], [[1.0]], [[0.0]], dt)
    loop = pl.state_feedback_loop(model, pl.lqr(model, [1.0], [1.0]))
    assert loop.dt == 1 and pl.encirclements(loop).stable and pl.margins(loop).stable
    unknown = control.ss([[1.2]], [[1.0]], [[1.0]], [[0.0]], True)
    with pytest.raises(ValueError, match="and a sampling time"):
        pl.lqr(unknown, [1.0], [1.0])


def test_contour_is_the_curve_that_is_counted(design):
    """From outside z = 1 over the upper circle to -1; the turning of the curve gives the count."""
    loop = design.nominal_loop
    z, L = contour(loop, points=4000)
    assert z[0].real > 1 and z[-1] == pytest.approx(-1) and np.all(z.imag > -1e-12)
    np.testing.assert_allclose(L, np.linalg.det(np.eye(loop.ninputs) + prepared(loop)(z)) - 1)
    angle = np.unwrap(np.angle(1 + L))
    assert 2 * (angle[-1] - angle[0]) / (2 * np.pi) == pytest.approx(
        pl.encirclements(loop).turns, abs=1e-6
    )


def test_count_through_the_critical_point_is_refused():
    loop = control.ss([[1.5]], [[1.0]], [[0.5]], 0, 0.01)  # closed-loop eigenvalue at 1
    with pytest.raises(ValueError, match="loop: a closed-loop eigenvalue lies on the unit circle"):
        pl.encirclements(loop)


@st.composite
def single_loops(draw, least_motors=1):
    """The loop of a random rig's regulator at one input, with filters or without."""
    rig = draw(rigs(n_links=st.integers(2, 3), least_motors=least_motors))
    plant = pl.linearize(rig)
    model = pl.add_integrator(pl.sample(plant), 1)
    F = pl.lqr(model, draw(weights(model.nstates, -1, 2)), draw(weights(rig.n_motors, -1, 2)))
    if draw(st.booleans()):
        loop = pl.state_feedback_loop(model, F)
    else:
        observer = pl.observer_family(pl.sample(plant), draw(between(0.3, 0.9))).best()
        filtered = pl.sample(pl.with_filters(plant, rig.filters))
        loop = pl.open_loop(pl.controller(F, observer), filtered)
    return loop if loop.ninputs == 1 else pl.broken_at(loop, draw(st.integers(0, 1)))


def radius(loop, factor):
    """Largest closed-loop eigenvalue with the gain multiplied by `factor`, which may be complex."""
    return np.abs(np.linalg.eigvals(loop.A - factor * loop.B @ loop.C)).max()


def assert_margins(loop):
    """Multiply the gain: inside the margins the loop is stable, at them an eigenvalue crosses."""
    found = pl.margins(loop)
    assert found.stable and radius(loop, 1) < 1
    down, up, phase = found.gain_down, found.gain_up, found.phase
    assert down < 1 < up and phase > 0
    for limit, inside in ((up, 1 - 1e-4), (down, 1 + 1e-4)):
        if 0 < limit < np.inf:
            assert radius(loop, limit * inside) < 1 < radius(loop, limit * (2 - inside))
            crossing = np.linalg.eigvals(loop.A - limit * loop.B @ loop.C)
            assert np.abs(np.abs(crossing) - 1).min() < 1e-6
    low, high = max(down * 1.0001, 1e-3), min(up * 0.9999, 1e3)
    assert all(radius(loop, k) < 1 for k in np.geomspace(low, high, 100)), "no gap between"
    if np.isfinite(phase):
        assert radius(loop, np.exp(1j * phase * (1 - 1e-4))) < 1
        assert radius(loop, np.exp(-1j * phase * (1 - 1e-4))) < 1
        assert max(radius(loop, np.exp(s * 1j * phase * (1 + 1e-4))) for s in (1, -1)) > 1
    for omega in found.crossover:
        assert np.abs(pl.frequency_response(loop, omega).item()) == pytest.approx(1, rel=1e-6)
    return found


@settings(max_examples=25)
@given(single_loops())
def test_margins_by_moving_the_gain(loop):
    assume(radius(loop, 1) < 1 - 1e-7)
    assert_margins(loop)


@settings(max_examples=15)
@given(single_loops(least_motors=2))
def test_modulus_margin_is_one_over_the_peak_of_the_sensitivity(loop):
    closed = np.abs(pl.closed_loop_eigenvalues(loop))
    assume(1e-6 < closed.min() and closed.max() < 1 - 1e-4)  # python-control needs both
    S = control.ss(loop.A - loop.B @ loop.C, loop.B, -loop.C, 1, loop.dt)
    peak = control.norm(S, "inf", tol=1e-8)
    assert pl.margins(loop).modulus == pytest.approx(1 / peak, rel=1e-4)


def test_margins_of_the_papers_loops(design):
    for index, filters in itertools.product(range(design.rig.n_motors), (False, True)):
        found = assert_margins(design.loop(index, filters))
        assert found.gain_up >= (1 - 1e-4) / (1 - found.modulus), "the disc about -1 bounds it"
        assert found.gain_down <= (1 + 1e-4) / (1 + found.modulus)


def test_upper_gain_margin_at_half_the_sampling_rate():
    """x+ = a x + u with u = -k x: eigenvalue a - k, stable for a - 1 < k < a + 1."""
    a, k = 1.2, 1.0
    found = pl.margins(control.ss([[a]], [[1.0]], [[k]], 0, 0.01))
    assert found.gain_up == pytest.approx((a + 1) / k)
    assert found.gain_up_omega == pytest.approx(NYQUIST)
    assert found.gain_down == pytest.approx((a - 1) / k)
    assert found.gain_down_omega == 0
    # 1 + L = (z - a + k)/(z - a): nearest to -1 at z = 1 or z = -1.
    assert found.modulus == pytest.approx(min((1 - a + k) / abs(1 - a), (1 + a - k) / (1 + a)))
    # |L| = k/|z - a| = 1 where cos(omega dt) = (1 + a^2 - k^2)/(2 a).
    omega = np.arccos((1 + a**2 - k**2) / (2 * a)) / 0.01
    assert found.crossover == pytest.approx((omega,))
    z = np.exp(0.01j * omega)
    assert found.phase == pytest.approx(abs(np.angle(k / (a - z))))
    assert found.phase_omega == pytest.approx(omega)


def test_margins_of_a_very_slow_loop():
    """An integrator of 1e-6 per sample: the crossing of a slow loop is not overlooked."""
    found = pl.margins(control.ss([[1.0]], [[1.0]], [[1e-6]], 0, 0.01))
    assert found.crossover == pytest.approx((1e-4,), rel=1e-6)
    assert found.phase == pytest.approx(np.pi / 2, abs=1e-5)
    assert found.gain_up == pytest.approx(2e6)


def test_margins_of_an_unstable_loop_say_so():
    found = pl.margins(control.ss([[1.2]], [[1.0]], [[0.1]], 0, 0.01))
    assert not found.stable and found.gain_up == pytest.approx(2.0)


def test_margins_of_a_loop_on_the_limit_are_used_up():
    """x+ = 1.5 x + u, u = -0.5 x: the eigenvalue 1 stands on the circle, neither way is left."""
    found = pl.margins(control.ss([[1.5]], [[1.0]], [[0.5]], 0, 0.01))
    assert (found.gain_up, found.gain_down) == (1, 1) and not found.stable
    assert found.modulus == pytest.approx(0, abs=1e-12) and found.modulus_omega == 0


def test_margins_without_any_crossing():
    found = pl.margins(control.ss([[0.5]], [[1.0]], [[0.1]], 0, 0.01))
    assert (found.gain_down, found.phase, found.crossover) == (0.0, np.inf, ())
    assert found.gain_up == pytest.approx(15)


def test_frequency_grid():
    omega = pl.frequency_grid(0.01, points=200, lowest=0.1)
    assert np.all(np.diff(omega) > 0)
    assert (omega[0], omega[-1]) == (pytest.approx(0.1), pytest.approx(NYQUIST))


@pytest.mark.parametrize("width", [0.0, 1e-5])
def test_frequency_grid_spreads_round_a_resonance(width):
    """As many points below its frequency as above, from a quarter of its width; none on a pole."""
    own = 20.0
    omega = pl.frequency_grid(0.01, 200, eigenvalues=[np.exp((-width + 1j * own) * 0.01)])
    near = omega[np.abs(omega - own) < 0.5]
    assert len(near) > 10
    np.testing.assert_allclose(2 * own - near[::-1], near, rtol=1e-12)
    distances = np.unique(np.abs(near - own))
    if width:
        assert distances[0] < 1e-12 and distances[1] == pytest.approx(width / 4, rel=1e-6)
    else:
        assert distances[0] > 1e-9


@pytest.mark.parametrize(
    "call, error, message",
    [
        (
            lambda d: pl.loop_gain(d.F, d.model, 1),
            TypeError,
            "controller: expected a pl.Controller",
        ),
        (
            lambda d: pl.loop_gain(d.controller, d.F, 1),
            TypeError,
            "plant: expected a control.StateSp",
        ),
        (
            lambda d: pl.loop_gain(d.controller, d.plant, 1),
            ValueError,
            "plant: expected one sampled",
        ),
        (
            lambda d: pl.open_loop(d.controller, pl.sample(d.plant, 0.02)),
            ValueError,
            r"plant: expected one sampled at the controller's 0.01 s, found dt = 0.02; use pl.sample",
        ),
        (
            lambda d: pl.open_loop(d.controller, pl.paper_design("double").model),
            ValueError,
            "plant: expected 2 inputs and 4 outputs to match the controller, found 1 and 3",
        ),
        (lambda d: pl.loop_gain(d.controller, d.model, np.nan), ValueError, "omega: every entry"),
        (lambda d: pl.frequency_response(d.model, "1"), TypeError, "omega: expected an array"),
        (lambda d: pl.frequency_response(d, 1), TypeError, "system: expected a control.StateSpace"),
        (
            lambda d: pl.broken_at(d.nominal_loop, 2),
            ValueError,
            "index: expected a whole number from 0 to 1, found 2",
        ),
        (lambda d: pl.broken_at(d.nominal_loop, -1), ValueError, "index: expected a whole number"),
        (
            lambda d: pl.margins(d.nominal_loop),
            ValueError,
            "loop: margins belong to .* found 2 x 2",
        ),
        (lambda d: pl.margins(d.plant[0, 0]), ValueError, "loop: expected a sampled one"),
        (lambda d: pl.margins(d), TypeError, "loop: expected a control.StateSpace"),
        (lambda d: pl.encirclements(d.plant[0, 0]), ValueError, "loop: expected a sampled one"),
        (
            lambda d: pl.encirclements(d.model),
            ValueError,
            "loop: expected as many inputs as outputs",
        ),
        (
            lambda d: pl.encirclements(control.ss(0.5, 1, 1, 1, 0.01)),
            ValueError,
            "loop: expected D = 0",
        ),
        (lambda d: pl.encirclements(1), TypeError, "loop: expected a control.StateSpace"),
        (
            lambda d: pl.loop_gain(d.controller, d.model, [1.0, 0.0]),
            ValueError,
            "omega: the system has a pole at 0 rad/s",
        ),
        (lambda d: pl.frequency_grid(0), ValueError, "dt: expected a number above 0"),
        (
            lambda d: pl.state_feedback_loop(d.augmented, d.F[:, 1:]),
            ValueError,
            r"F: expected shape 1 x 7, found shape \(1, 6\)",
        ),
        (
            lambda d: pl.return_differences(
                pl.paper_design("double").controller, pl.paper_design("double").model, 1.0
            ),
            ValueError,
            "controller: return_differences takes two inputs, found 1; use pl.loop_gain",
        ),
    ],
)
def test_bad_input(triple_design, call, error, message):
    with pytest.raises(error, match=message):
        call(triple_design)


def test_loops_stay_what_they_were(triple_design):
    """Analysis changes nothing that it is given."""
    loop = triple_design.filtered_loop
    before = loop.A.copy(), loop.B.copy(), loop.C.copy()
    pl.encirclements(loop), pl.margins(pl.broken_at(loop, 0))
    for now, then in zip((loop.A, loop.B, loop.C), before, strict=True):
        np.testing.assert_array_equal(now, then)
    again = dataclasses.replace(triple_design)
    np.testing.assert_array_equal(again.filtered_loop.A, loop.A)
