"""Measures of controllability: closed forms, a second method for each, invariance, bad input."""

from dataclasses import replace

import control
import numpy as np
import pytest
from scipy.linalg import null_space
from scipy.optimize import brentq, minimize

import pendlab as pl
from pendlab.studies.controllability import _cover


def random_pair(seed, n=4, m=1):
    rng = np.random.default_rng(seed)
    return rng.standard_normal((n, n)), rng.standard_normal((n, m))


def orthogonal(seed, n):
    return np.linalg.qr(np.random.default_rng(seed).standard_normal((n, n)))[0]


def critical_bar(rig):
    """Inertia on link 1 with which a straight fall of the double needs no torque at hinge 2.

    The rows of (M s^2 + N s + P) [1, 1]' = 0; the second gives s, the first the inertia.
    """
    M, N, P = (np.asarray(x, float) for x in pl.derive(2, 1).linear(*values(rig))[1:4])
    one = np.ones(2)
    s = np.sqrt(-(P @ one)[1] / (M @ one)[1])
    return -((N @ one)[0] * s + (P @ one)[0]) / s**2 - (M @ one)[0]


def values(rig):
    return pl.derive(2, 1).values(rig)


# --- ratio ---


def test_ratio_of_a_chain_with_gain():
    # [B, AB] = [[0, b], [b, 0]] has equal singular values; a rate constant tilts them.
    assert pl.controllability_ratio([[0, 1], [0, 0]], [[0], [7]]) == pytest.approx(1)
    assert pl.controllability_ratio(np.diag([1.0, 2.0]), [[1], [1]]) == pytest.approx(
        (7 + np.sqrt(45)) / 2
    )


def test_ratio_is_infinite_without_control():
    assert pl.controllability_ratio(np.diag([1.0, 2.0]), [[1], [0]]) == np.inf


def test_ratio_is_the_condition_number_of_ctrb(rig):
    plant = pl.linearize(rig)
    A, B = pl.in_units(plant, 0.1, 0.2, rig.u_max)
    assert pl.controllability_ratio(A, B) == pytest.approx(
        np.linalg.cond(control.ctrb(A, B)), rel=1e-4
    )


# --- distance ---


@pytest.mark.parametrize("b", [0.3, 1.0, 4.0])
def test_distance_of_one_state_is_its_gain(b):
    assert pl.distance_to_uncontrollability([[2.0]], [[b]]) == (pytest.approx(b), pytest.approx(2))


def test_distance_of_the_double_integrator_has_a_ring_of_minima():
    distance, s = pl.distance_to_uncontrollability([[0, 1], [0, 0]], [[0], [1]])
    assert distance == pytest.approx(np.sqrt(3) / 2, rel=1e-9)
    assert abs(s) == pytest.approx(0.5, abs=1e-4)


def test_distance_with_an_input_for_every_state_is_the_size_of_the_input():
    A, _ = random_pair(1)
    A = A + A.T
    assert pl.distance_to_uncontrollability(A, 3 * np.eye(4))[0] == pytest.approx(3)


def test_distance_of_a_rotation():
    # Skew A: at s = i w the left vector [1, i]/sqrt(2) has A's row zero and meets B with b/sqrt(2).
    distance, s = pl.distance_to_uncontrollability([[0, 50], [-50, 0]], [[0], [0.1]])
    assert distance == pytest.approx(0.1 / np.sqrt(2), rel=1e-4)
    assert s.imag == pytest.approx(50, rel=1e-4)


@pytest.mark.parametrize(
    ("A", "B"),
    [
        (np.eye(2), [[1], [2]]),
        (np.diag([1.0, 2.0]), [[1], [0]]),
        (np.zeros((3, 3)), np.ones((3, 1))),
        ([[1, 2], [0, 3]], [[1], [0]]),
    ],
)
def test_distance_is_zero_without_control(A, B):
    assert pl.distance_to_uncontrollability(A, B)[0] < 1e-8


def on_a_vertical_line(A, B, x):
    """min over y of sigma_min([A - (x + iy) I, B]) by bisection on a Hamiltonian matrix.

    The level d is met somewhere on the line exactly if [[A - xI, BB' - d^2 I], [I, -(A - xI)']] has
    an eigenvalue on the imaginary axis.
    """
    n, M = len(A), A - x * np.eye(len(A))
    low, high = 0.0, np.linalg.svd(np.hstack([M, B]), compute_uv=False)[-1]
    while high - low > 1e-7 * high:
        d = (low + high) / 2
        H = np.block([[M, B @ B.T - d**2 * np.eye(n)], [np.eye(n), -M.T]])
        met = np.any(np.abs(np.linalg.eigvals(H).real) < 1e-7)
        low, high = (low, d) if met else (d, high)
    return high


@pytest.mark.parametrize(
    ("seed", "n", "m"), [(0, 3, 1), (1, 4, 1), (2, 4, 2), (3, 5, 1), (4, 6, 2)]
)
def test_distance_agrees_with_hamiltonian_eigenvalues_on_vertical_lines(seed, n, m):
    A, B = random_pair(seed, n, m)
    distance, s = pl.distance_to_uncontrollability(A, B)
    assert on_a_vertical_line(A, B, s.real) == pytest.approx(distance, rel=1e-4)
    ends = np.linalg.eigvalsh((A + A.T) / 2)[[0, -1]]
    lines = np.array([on_a_vertical_line(A, B, x) for x in np.linspace(*ends, 60)])
    assert lines.min() >= distance * (1 - 1e-4)
    # Neighbouring lines are near enough that one of them comes down to the minimum.
    assert lines.min() <= distance + np.diff(ends)[0] / 60


def test_distance_is_that_of_a_change_that_takes_control_away(rig):
    A, B = pl.in_units(pl.linearize(rig), 0.1, 0.2, rig.u_max)
    distance, s = pl.distance_to_uncontrollability(A, B)
    U, sigma, Vh = np.linalg.svd(np.hstack([A - s * np.eye(len(A)), B]))
    change = -sigma[-1] * np.outer(U[:, -1], Vh[len(A) - 1])
    assert np.linalg.norm(change, 2) == pytest.approx(distance, rel=1e-6)
    broken = np.hstack([A, B]) + change
    pencil = broken - s * np.eye(*broken.shape)
    assert null_space(pencil.conj().T, rcond=1e-10).shape[1] == 1


@pytest.mark.parametrize("seed", range(4))
def test_distance_and_ratio_keep_under_rotation_and_distance_under_shift(seed):
    A, B = random_pair(seed, 4, 2)
    X, Y = orthogonal(seed, 4), orthogonal(seed, 2)
    distance, _ = pl.distance_to_uncontrollability(A, B)
    for other in ((X.T @ A @ X, X.T @ B @ Y), (A + 3 * np.eye(4), B), (-A, B)):
        assert pl.distance_to_uncontrollability(*other)[0] == pytest.approx(distance, rel=1e-5)
    assert pl.distance_to_uncontrollability(5 * A, 5 * B)[0] == pytest.approx(
        5 * distance, rel=1e-5
    )
    assert pl.controllability_ratio(X.T @ A @ X, X.T @ B @ Y) == pytest.approx(
        pl.controllability_ratio(A, B), rel=1e-6
    )


@pytest.mark.parametrize("seed", range(6))
def test_no_point_of_a_fine_grid_lies_below_the_distance(seed):
    A, B = random_pair(seed, 5, 1)
    distance, _ = pl.distance_to_uncontrollability(A, B)
    x, y = np.meshgrid(np.linspace(-5, 5, 101), np.linspace(0, 5, 51))
    s = (x + 1j * y).ravel()
    pencils = np.concatenate(
        [A - s[:, None, None] * np.eye(5), np.broadcast_to(B, (len(s), 5, 1))], axis=2
    )
    assert np.linalg.svd(pencils, compute_uv=False)[:, -1].min() >= distance * (1 - 1e-6)


@pytest.mark.parametrize("seed", range(12))
def test_the_least_ring_is_found_wherever_it_lies(seed):
    """A double integrator moved to c has its minimum k sqrt(3)/2 on a ring of radius k/2 round c.

    A mode of its own input, far away, has a little more than that at its eigenvalue, and less than
    the integrator has at c: what begins at the eigenvalues ends there unless every cell is searched.
    """
    rng = np.random.default_rng(seed)
    k, c, away = 10 ** rng.uniform(-2, -0.5), rng.uniform(-1, 1), rng.choice([-3.0, 3.0])
    A, B = np.diag([c, c, away]), np.zeros((3, 2))
    A[0, 1] = B[1, 0] = k
    B[2, 1] = 0.93 * k
    distance, s = pl.distance_to_uncontrollability(A, B, tolerance=0.01)
    assert distance == pytest.approx(k * np.sqrt(0.75), rel=1e-6)
    assert abs(s - c) == pytest.approx(k / 2, rel=1e-3)


@pytest.mark.parametrize("seed", range(8))
def test_cells_cover_the_numerical_range(seed):
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((5, 5)) * 10 ** rng.uniform(-2, 2)
    A += rng.choice([0.0, 30.0]) * (A - A.T)  # wide or high
    centres, half = _cover(A)
    x = rng.standard_normal((20000, 5)) + 1j * rng.standard_normal((20000, 5))
    # Eigenvectors of e^(-jt) A touch the border of the range.
    turns = np.exp(-1j * np.linspace(0, 2 * np.pi, 400))[:, None, None]
    x = np.concatenate(
        [x, np.linalg.eigh((turns * A + (turns * A).conj().swapaxes(1, 2)) / 2)[1][..., -1]]
    )
    values = np.einsum("ki,ij,kj->k", x.conj(), A, x) / (np.abs(x) ** 2).sum(axis=1)
    values = values[values.imag >= 0]
    off = values[:, None] - centres
    inside = np.maximum(np.abs(off.real), np.abs(off.imag)) <= half * (1 + 1e-9)
    assert inside.any(axis=1).all()


# --- units and bars ---


def test_units_change_numbers_and_not_the_system(rig):
    plant = pl.linearize(rig)
    A, B = pl.in_units(plant, angle=0.1, second=0.2, volts=rig.u_max)
    assert np.sort(np.linalg.eigvals(A)) == pytest.approx(0.2 * np.sort(np.linalg.eigvals(plant.A)))
    n = rig.n_links
    x, u = np.arange(1.0, 2 * n + 1), np.array(rig.u_max) / 2
    in_their_units = np.concatenate([x[:n] / 0.1, x[n:] * 0.2 / 0.1])
    slope = A @ in_their_units + B @ np.full(rig.n_motors, 0.5)
    truth = plant.A @ x + plant.B @ u
    assert slope[:n] == pytest.approx(truth[:n] * 0.2 / 0.1)
    assert slope[n:] == pytest.approx(truth[n:] * 0.2**2 / 0.1)


def test_units_of_one_leave_the_matrices():
    plant = pl.linearize(pl.load("double"))
    A, B = pl.in_units(plant)
    assert np.array_equal(A, plant.A) and np.array_equal(B, plant.B)


def test_bar_without_mass_adds_its_inertia_alone(double):
    barred = pl.with_bar(double, 2, 0.05)
    assert barred.links[0] == double.links[0]
    assert barred.links[1] == replace(double.links[1], inertia=double.links[1].inertia + 0.05)


def test_bar_with_mass_keeps_moments_about_the_hinge(triple):
    old, new = triple.links[1], pl.with_bar(triple, 2, 0.02, mass=0.3, height=0.05).links[1]
    assert new.mass == pytest.approx(old.mass + 0.3)
    assert new.mass * new.com == pytest.approx(old.mass * old.com + 0.3 * 0.05)
    about_hinge = lambda link: link.inertia + link.mass * link.com**2  # noqa: E731
    assert about_hinge(new) == pytest.approx(about_hinge(old) + 0.02 + 0.3 * 0.05**2)


def test_bars_add_up(double):
    both = pl.with_bar(pl.with_bar(double, 1, 0.01), 1, 0.02)
    assert both.links[0].inertia == pytest.approx(pl.with_bar(double, 1, 0.03).links[0].inertia)


def test_one_bar_makes_the_double_uncontrollable(double):
    critical = critical_bar(double)
    assert 0.05 < critical < 0.1
    plant = pl.linearize(pl.with_bar(double, 1, critical))
    distance, _ = pl.distance_to_uncontrollability(plant.A, plant.B)
    assert distance < 1e-9 * np.linalg.norm(plant.A)
    lean = [0.1, 0, 0, 0]
    assert pl.recoverable_tilt(pl.with_bar(double, 1, critical)) < 1e-6
    assert pl.least_effort(pl.with_bar(double, 1, critical), lean) > 1e10
    for factor in (0.9, 1.1):  # the neighbours on both sides are merely bad
        other = pl.with_bar(double, 1, factor * critical)
        assert 1e-3 < pl.recoverable_tilt(other) < 0.3 * pl.recoverable_tilt(double)


# --- effort and tilt ---


def test_least_effort_is_the_limit_of_the_regulator(rig):
    plant, n = pl.linearize(rig), rig.n_links
    x0 = 0.1 * np.eye(2 * n)[0]
    R = np.diag(1 / np.array(rig.u_max) ** 2)
    X = control.care(plant.A, plant.B, 1e-9 * np.eye(2 * n), R)[0]
    assert pl.least_effort(rig, x0) == pytest.approx(x0 @ X @ x0, rel=1e-4)
    assert pl.least_effort(rig, 3 * x0) == pytest.approx(9 * pl.least_effort(rig, x0))


def test_least_effort_ignores_what_settles_by_itself(double):
    s, V = np.linalg.eig(pl.linearize(double).A)
    brake, fall = V[:, s.real.argmin()].real, V[:, s.real.argmax()].real
    assert pl.least_effort(double, brake) < 1e-12
    assert pl.least_effort(double, brake + fall) == pytest.approx(pl.least_effort(double, fall))


def test_recoverable_tilt_lies_below_the_limit_of_every_single_mode(double):
    # The mode w'x is lost where s |w'x| exceeds |w'B| u_max; both at once is harder than each.
    plant = pl.linearize(double)
    s, V = np.linalg.eig(plant.A)
    bound = min(
        abs(w.real @ plant.B[:, 0]) * 9 / (value.real * abs(w[0].real))
        for value, w in zip(s, np.linalg.inv(V))
        if value.real > 0
    )
    assert 0.9 * bound < pl.recoverable_tilt(double) < bound


def test_recoverable_tilt_agrees_with_its_dual(rig):
    """min over p with p'z = 1 of the integral of sum |p' e^(-A_u t) B_u| u_max."""
    plant = pl.linearize(rig)
    s, V = np.linalg.eig(plant.A)
    up = np.flatnonzero(s.real > 0)
    W = np.linalg.inv(V).real[up]
    W = W / W[:, :1]  # so that z = [1, ..., 1] and the entries of p add up to 1
    B, s = W @ plant.B * np.array(rig.u_max), s.real[up]
    t = np.append(0, np.geomspace(1e-4, 10 / s.min(), 4000))
    fading = np.exp(-np.outer(s, t))

    def support(free):
        p = np.append(free, 1 - sum(free))
        return sum(np.trapezoid(np.abs((p * b) @ fading), t) for b in B.T)

    p = np.zeros(len(s) - 1)
    for _ in range(3):  # convex; restarts free the simplex where the function has an edge
        p = minimize(support, p, method="Nelder-Mead", options=dict(xatol=1e-9, fatol=1e-12)).x
    best = support(p)
    assert pl.recoverable_tilt(rig) == pytest.approx(best, rel=2e-3)


def test_recoverable_tilt_grows_with_the_limits(triple):
    twice = replace(triple, u_max=tuple(2 * u for u in triple.u_max))
    assert pl.recoverable_tilt(twice) == pytest.approx(2 * pl.recoverable_tilt(triple))
    weaker = replace(triple, u_max=(triple.u_max[0], 1e-3))
    assert pl.recoverable_tilt(weaker) < pl.recoverable_tilt(triple)


def test_effort_and_tilt_do_not_depend_on_the_units_of_the_state_but_the_distance_does(double):
    coarse, fine = (pl.controllability_measures(double, angle) for angle in (0.1, 0.05))
    assert coarse.tilt == fine.tilt
    assert coarse.effort == pytest.approx(4 * fine.effort)  # it leans half as far
    assert coarse.distance != pytest.approx(fine.distance, rel=1e-3)


def test_measures_agree_with_the_functions(rig):
    measures = pl.controllability_measures(rig)
    A, B = pl.in_units(pl.linearize(rig), 0.1, 0.2, rig.u_max)
    assert measures.ratio == pl.controllability_ratio(A, B)
    assert measures.distance == pl.distance_to_uncontrollability(A, B)[0]


# --- what the notebook states ---


@pytest.mark.parametrize("units", [(1.0, 1.0), (0.1, 0.2), (0.3, 1.0)])
def test_moderate_bar_helps_on_the_upper_link_and_harms_on_the_lowest_in_any_units(rig, units):
    def distance(link, inertia):
        plant = pl.linearize(pl.with_bar(rig, link, inertia))
        return pl.distance_to_uncontrollability(*pl.in_units(plant, *units, rig.u_max))[0]

    bare, n = distance(1, 0.0), rig.n_links
    barred = [distance(link, 0.03) for link in range(1, n + 1)]
    assert barred[-1] > 1.1 * bare
    assert barred[0] < 0.9 * bare
    assert max(barred[:-1]) < 1.05 * bare  # a middle link: next to nothing


def test_ratio_praises_the_middle_bar_that_catches_no_larger_tilt(triple):
    bare = pl.controllability_measures(triple)
    middle, upper = (pl.controllability_measures(pl.with_bar(triple, k, 0.03)) for k in (2, 3))
    assert middle.ratio < 0.5 * bare.ratio and middle.tilt < 1.05 * bare.tilt
    assert upper.ratio > 0.9 * bare.ratio and upper.tilt > 1.2 * bare.tilt


def test_balance_of_the_first_moments_vanishes_at_the_frictionless_critical_bar(double):
    smooth = replace(double, links=[replace(double.links[0], friction=0.0), double.links[1]])
    (low, up), bar = smooth.links, critical_bar(smooth)
    M1, M2 = low.mass * low.com + up.mass * low.length, up.mass * up.com
    J1 = low.inertia + bar + low.mass * low.com**2 + up.mass * low.length**2
    J2 = up.inertia + up.mass * up.com**2
    c = low.length * M2
    assert M1 * (J2 + c) == pytest.approx(M2 * (J1 + c))
    turns = lambda bar: M1 * (J2 + c) - M2 * (J1 + bar + c)  # noqa: E731
    assert brentq(turns, -0.1, 0.1) == pytest.approx(0, abs=1e-12)


# --- bad input ---


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: pl.controllability_ratio(np.ones((2, 3)), np.ones((2, 1))),
            "A: expected a square",
        ),
        (lambda: pl.controllability_ratio(np.eye(2), np.ones((3, 1))), "B: expected shape 2 x any"),
        (lambda: pl.distance_to_uncontrollability(np.eye(2) * np.nan, np.ones((2, 1))), "A: every"),
        (lambda: pl.distance_to_uncontrollability(np.eye(2), np.ones((2, 1)), 0), "tolerance"),
        (
            lambda: pl.with_bar(pl.load("double"), 3, 0.1),
            "link: expected a whole number from 1 to 2",
        ),
        (lambda: pl.with_bar(pl.load("double"), 1, -0.1), "inertia: expected a number of at least"),
        (lambda: pl.with_bar(pl.load("double"), 1, 0.1, mass=-1), "mass: expected"),
        (lambda: pl.least_effort(pl.load("double"), [0.1, 0]), "x0: expected shape 4"),
        (lambda: pl.least_effort(pl.load("double"), [1e200, 0, 0, 0]), "x0: expected .* 1e100"),
        (lambda: pl.in_units(pl.linearize(pl.load("double")), angle=0), "angle: expected"),
        (lambda: pl.in_units(pl.linearize(pl.load("double")), volts=(9, 9)), "volts: expected 1"),
        (
            lambda: pl.in_units(pl.sample(pl.linearize(pl.load("double")))),
            "plant: expected a contin",
        ),
        (
            lambda: pl.recoverable_tilt(replace(pl.load("double"), u_max=())),
            "u_max: expected a fin",
        ),
    ],
)
def test_bad_input_is_named(call, message):
    with pytest.raises(ValueError, match=message):
        call()


def test_wrong_kinds_are_named():
    with pytest.raises(TypeError, match="rig: expected"):
        pl.with_bar("double", 1, 0.1)
    with pytest.raises(TypeError, match="plant: expected"):
        pl.in_units(np.eye(4))
