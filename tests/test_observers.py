"""Reduced-order observers: the identities (5)-(7), the whole family, and what cannot work."""

import dataclasses

import control
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.linalg import block_diag, null_space
from strategies import between, dynamics, rigs

import pendlab as pl
from pendlab.observers import canonical_basis, kronecker_matrix


def sampled(rig):
    return pl.sample(pl.linearize(rig))


@st.composite
def families(draw):
    rig = draw(rigs())
    E = draw(dynamics(rig.n_links - 1))
    # E = e I gives all p rows of T the same q - m = n + 1 - m dimensions to lie in.
    assume(np.ndim(E) > 0 or rig.n_motors <= 2)
    return pl.observer_family(sampled(rig), E)


def rotation(size, seed):
    return np.linalg.qr(np.random.default_rng(seed).standard_normal((size, size)))[0]


def assert_observes(observer, model, H=None):
    """TA - ET = KC, H = TB and [L1 L2][C; T] = I, each against the size of its terms."""
    A, B, C = model.A, model.B, model.C
    E, T, K, L1, L2 = observer.E, observer.T, observer.K, observer.L1, observer.L2
    terms = np.abs(T) @ np.abs(A) + np.abs(E) @ np.abs(T) + np.abs(K) @ np.abs(C)
    assert np.abs(T @ A - E @ T - K @ C).max() < 1e-9 * terms.max()
    size = np.abs(T).max() * np.abs(B).max()
    np.testing.assert_allclose(observer.H, T @ B if H is None else H, atol=1e-9 * size)
    L, stacked = np.hstack([L1, L2]), np.vstack([C, T])
    allowed = 1e-11 * (np.abs(L) @ np.abs(stacked)).max()
    assert np.abs(L @ stacked - np.eye(len(A))).max() < allowed


@given(families(), st.integers(0, 2**32 - 1))
def test_every_member_is_an_observer_with_H_zero(family, seed):
    member = family.member(np.random.default_rng(seed).standard_normal(family.dimension))
    assert_observes(member, family.model, H=0)
    np.testing.assert_allclose(member.T @ family.model.B, 0, atol=1e-9 * np.abs(member.T).max())
    assert np.all(member.H == 0), "rounding of T B is not kept"
    assert max(member.residuals(family.model).values()) < 1e-5


@given(families())
def test_dimension_counts_the_free_entries(family):
    """p (n + q) unknowns, p n + p m independent equations: p (q - m) are free."""
    p, q, m = len(family.E), family.model.noutputs, family.model.ninputs
    assert family.dimension == p * (q - m) == len(null_space(family.S).T)
    np.testing.assert_allclose(family.basis @ family.basis.T, np.eye(family.dimension), atol=1e-12)
    np.testing.assert_allclose(family.S @ family.basis.T, 0, atol=1e-9 * np.abs(family.S).max())


def test_kronecker_matrix_is_the_two_equations():
    rng = np.random.default_rng(0)
    A, B, C = rng.standard_normal((5, 5)), rng.standard_normal((5, 2)), rng.standard_normal((3, 5))
    E, T, K = rng.standard_normal((2, 2)), rng.standard_normal((2, 5)), rng.standard_normal((2, 3))
    product = kronecker_matrix(A, B, C, E) @ np.concatenate([T.ravel(), K.ravel()])
    expected = np.concatenate([(T @ A - E @ T - K @ C).ravel(), (T @ B).ravel()])
    np.testing.assert_allclose(product, expected, atol=1e-13)


@given(st.integers(1, 6), st.integers(6, 12), st.integers(0, 2**32 - 1))
def test_canonical_basis_depends_on_the_span_alone(k, size, seed):
    rows = rotation(size, seed)[:k]
    basis = canonical_basis(rows)
    np.testing.assert_allclose(basis @ basis.T, np.eye(k), atol=1e-12)
    np.testing.assert_allclose(basis.T @ basis, rows.T @ rows, atol=1e-12)
    noise = 1e-15 * np.random.default_rng(seed).standard_normal(rows.shape)
    for other in (rotation(k, seed + 1) @ rows, rows[::-1], -rows, rows + noise):
        np.testing.assert_allclose(canonical_basis(other), basis, atol=1e-10)
    largest = basis[np.arange(k), np.abs(basis).argmax(axis=1)]
    assert np.all(largest > 0)


def test_canonical_basis_with_equal_columns():
    """Where two columns are equally large the earlier one leads, whatever the rounding."""
    rows = np.array([[1, -1, 0, 0], [0, 0, 1, 1]]) / np.sqrt(2)
    for seed in range(20):
        basis = canonical_basis(rotation(2, seed) @ rows)
        np.testing.assert_allclose(basis, rows, atol=1e-14)


@pytest.mark.parametrize("more, leads", [(1e-11, 0), (1e-8, 1)])
def test_columns_are_equal_within_nine_digits(more, leads):
    basis = canonical_basis(np.array([[1.0, -1.0 - more]]) / np.hypot(1.0, 1.0 + more))
    assert basis[0, leads] > 0 > basis[0, 1 - leads]


def test_family_does_not_depend_on_rounding(design):
    model, family = design.model, design.family
    noise = 1 + 1e-15 * np.random.default_rng(0).standard_normal(model.A.shape)
    other = control.ss(model.A * noise, model.B, model.C, 0, model.dt)
    again = pl.observer_family(other, design.E)
    np.testing.assert_allclose(again.basis, family.basis, atol=1e-11)


@given(families(), st.integers(0, 2**32 - 1))
def test_project_undoes_member(family, seed):
    coefficients = np.random.default_rng(seed).standard_normal(family.dimension)
    member = family.member(coefficients)
    np.testing.assert_allclose(family.project(member.T, member.K), coefficients, atol=1e-9)
    assert family.distance(member.T, member.K) < 1e-9


def test_distance_is_that_of_the_nearest_member(triple_design):
    family = triple_design.family
    rng = np.random.default_rng(4)
    T, K = rng.standard_normal((2, 6)), rng.standard_normal((2, 4))
    alpha = np.concatenate([T.ravel(), K.ravel()])
    nearest = family.project(T, K) @ family.basis
    distance = family.distance(T, K)
    assert distance == pytest.approx(np.linalg.norm(alpha - nearest) / np.linalg.norm(alpha))
    for _ in range(20):
        other = rng.standard_normal(family.dimension) @ family.basis
        assert np.linalg.norm(alpha - other) / np.linalg.norm(alpha) >= distance
    assert family.distance(10 * T, 10 * K) == pytest.approx(distance)


@given(rigs(n_links=st.integers(2, 3)), st.data())
def test_best_is_no_noisier_than_many_others(rig, data):
    family = pl.observer_family(sampled(rig), data.draw(dynamics(rig.n_links - 1)))
    best = family.best()
    rng = np.random.default_rng(5)
    others = rng.standard_normal((200, family.dimension)) * 10 ** rng.uniform(-2, 2, (200, 1))
    assert best.noise_gain() <= 1.001 * min(family.member(c).noise_gain() for c in others)
    assert_observes(best, family.model, H=0)


def test_noise_gain_is_the_norm_of_the_estimator_and_no_matter_of_units(triple_design):
    """Condition of [C; T] is: (7 T, 7 K) is the same observer, and so is any X T with X E = E X."""
    family, F = triple_design.family, triple_design.F[:, :6]
    one, other = family.member([0, 1, 1, -3]), family.member([7, 14, -7, 3.5])
    assert other.noise_gain() == pytest.approx(one.noise_gain(), rel=1e-7)
    estimator = control.ss(one.E, one.K, one.L2, one.L1, 0.01)
    assert one.noise_gain() == pytest.approx(np.sqrt(np.sum(pl.rms(estimator) ** 2)))
    voltage = control.ss(one.E, one.K, F @ one.L2, F @ one.L1, 0.01)
    assert one.noise_gain(F) == pytest.approx(pl.rms(voltage)[0])


@pytest.mark.parametrize("name, number", [("double", 1), ("double", 2), ("triple", 1)])
def test_the_papers_observers_are_members(name, number):
    design = pl.paper_design(name, number)
    assert_observes(design.observer, design.model, H=0)
    assert design.family.distance(design.observer.T, design.observer.K) < 1e-12


@given(rigs(), st.data())
def test_luenberger_observer_of_any_K(rig, data):
    model = sampled(rig)
    p, q = rig.n_links - 1, rig.n_links + 1
    E = data.draw(dynamics(p))
    K = np.random.default_rng(data.draw(st.integers(0, 2**32 - 1))).standard_normal((p, q))
    observer = pl.luenberger(model, E, K)
    assert_observes(observer, model)
    np.testing.assert_array_equal(observer.K, K)
    assert np.abs(observer.H).max() > 1e-6, "H = 0 asks for a special K"


@given(families())
def test_luenberger_of_a_members_K_is_the_member(family):
    member = family.member(np.random.default_rng(9).standard_normal(family.dimension))
    again = pl.luenberger(family.model, family.E, member.K)
    np.testing.assert_allclose(again.T, member.T, atol=1e-6 * np.abs(member.T).max())


@pytest.mark.parametrize("scale", [1e-14, 1e14])
def test_scale_of_T_is_free(triple_design, scale):
    """(sT, sK) is the same observer in other units: L1 stays and L2 is divided by s."""
    one = triple_design.observer
    rows = np.array([[scale], [1.0]])  # one row only; E is diagonal, so the rows are independent
    two = pl.observer(triple_design.model, one.E, rows * one.T, rows * one.K)
    np.testing.assert_allclose(two.L1, one.L1, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(two.L2 * rows.T, one.L2, rtol=1e-6, atol=1e-9 * np.abs(one.L2).max())
    mixed = pl.luenberger(triple_design.model, [0.5, 0.6], rows * np.ones((2, 4)) * [1, 2, 3, 4])
    assert np.all(mixed.H != 0)
    np.testing.assert_allclose(mixed.H, mixed.T @ triple_design.model.B, rtol=1e-12)


@given(families(), st.integers(0, 2**32 - 1))
def test_error_decays_with_E(family, seed):
    """v - T x obeys e(n+1) = E e(n) whatever the inputs, and the estimate becomes the state."""
    rng = np.random.default_rng(seed)
    model, observer = family.model, family.best()
    x, v = 0.1 * rng.standard_normal(model.nstates), rng.standard_normal(len(family.E))
    error = v - observer.T @ x
    for _ in range(30):
        u, y = 0.1 * rng.standard_normal(model.ninputs), model.C @ x
        np.testing.assert_allclose(
            observer.L1 @ y + observer.L2 @ v - x,
            observer.L2 @ error,
            atol=1e-8 * (1 + np.abs(observer.L2).max() * np.abs(v).max() + np.abs(x).max()),
        )
        v = observer.E @ v + observer.H @ u + observer.K @ y
        x = model.A @ x + model.B @ u
        error = observer.E @ error
        np.testing.assert_allclose(v - observer.T @ x, error, atol=1e-9 * (1 + np.abs(v).max()))


@pytest.mark.parametrize(
    "E", [0.9, [0.9, 0.9], [0.9, 0.8], [[0.9, 1.0], [0, 0.9]], [[0.6, -0.5], [0.5, 0.6]], 0, -0.5]
)
def test_any_dynamics(triple_design, E):
    """Scalar, repeated, distinct, one Jordan block, a complex pair, dead beat, negative."""
    family = pl.observer_family(triple_design.model, E)
    assert family.dimension == 4 and family.E.shape == (2, 2)
    best = family.best()
    assert_observes(best, triple_design.model, H=0)
    np.testing.assert_allclose(
        np.sort_complex(np.linalg.eigvals(best.E)), np.sort_complex(np.linalg.eigvals(family.E))
    )


@given(rigs(n_links=st.just(4), least_motors=3), between(0.3, 0.9))
def test_three_equal_rows_of_dynamics_leave_no_regular_member(rig, e):
    """n = 4, m = 3: with E = e I each row of T lies in the same two-dimensional space."""
    model = sampled(rig)
    with pytest.raises(ValueError, match=r"E: every T with H = TB = 0 leaves \[C; T\] singular"):
        pl.observer_family(model, e)
    assert pl.observer_family(model, [e, e - 0.1, e - 0.2]).dimension == 6


def test_zeros_that_E_does_not_hold_leave_no_observer_with_H_zero():
    rng = np.random.default_rng(7)
    A, B = rng.standard_normal((4, 4)), rng.standard_normal((4, 2))
    model = control.ss(A, B, np.eye(2, 4), 0, 0.01)
    with pytest.raises(
        ValueError, match=r"E: no observer with H = TB = 0 exists .* pl\.luenberger"
    ):
        pl.observer_family(model, [0.5, 0.6])
    observer = pl.luenberger(model, [0.5, 0.6], rng.standard_normal((2, 2)))
    assert_observes(observer, model)
    assert np.linalg.matrix_rank(observer.H) == 2


def test_singular_members_are_refused(triple_design):
    family = triple_design.family
    with pytest.raises(ValueError, match=r"coefficients: .* \[C; T\] is singular"):
        family.member(np.zeros(4))
    # With E = 0.9 I equal rows are allowed by TA - ET = KC and by TB = 0, but not by (7).
    T, K = family.split(np.ones(4) @ family.basis)
    equal = family.project(T[[0, 0]], K[[0, 0]])
    assert family.distance(T[[0, 0]], K[[0, 0]]) < 1e-12
    with pytest.raises(ValueError, match=r"T: \[C; T\] is singular"):
        family.member(equal)


@pytest.mark.parametrize("part, law", [("K", "TA"), ("H", "H"), ("L1", "L1")])
def test_residuals_tell_how_far_an_observer_is_off(triple_design, part, law):
    off = getattr(triple_design.observer, part).copy()
    off[0, 0] += 0.125
    spoiled = dataclasses.replace(triple_design.observer, **{part: off})
    for name, value in spoiled.residuals(triple_design.model).items():
        assert value == pytest.approx(0.125 * name.startswith(law), abs=1e-9), name


@pytest.mark.parametrize("size", [1e-6, 1.0, 1e6])
def test_a_gap_in_the_equations_beyond_rounding_is_refused(double_design, size):
    model, chosen = double_design.model, double_design.observer
    T, K = size * chosen.T, size * chosen.K
    assert pl.observer(model, 0.9, T * (1 + 1e-7 * np.eye(1, 4)), K).T.shape == (1, 4)
    with pytest.raises(ValueError, match="T, K: TA - ET = KC must hold"):
        pl.observer(model, 0.9, T * (1 + 1e-4 * np.eye(1, 4)), K)


@pytest.mark.parametrize("lean, regular", [(1e-8, True), (1e-12, False)])
def test_rows_that_nearly_agree_are_singular_beyond_rounding_only(lean, regular):
    model = control.ss(np.diag([0.5, 0.2, 0.2]), np.ones((3, 1)), [[1.0, 0.0, 0.0]], 0, 0.01)
    T = np.array([[0.0, 1.0, 1.0], [0.0, 1.0, 1.0 + lean]])  # TA = 0.2 T
    if regular:
        L2 = pl.observer(model, [0.2, 0.2], T, np.zeros((2, 1))).L2
        np.testing.assert_allclose(L2 @ T[:, 1:], np.eye(3)[:, 1:], atol=1e-6)
    else:
        with pytest.raises(ValueError, match=r"\[C; T\] is singular"):
            pl.observer(model, [0.2, 0.2], T, np.zeros((2, 1)))


@pytest.mark.parametrize("size, kept", [(1e-12, True), (1e-16, False)])
def test_only_rounding_is_cleaned_away(size, kept):
    """[C; T] = [[1, s], [0, 1]] has the inverse [[1, -s], [0, 1]], and TB is 100 s."""
    model = control.ss(np.diag([0.5, 0.1 + 0.2]), [[1.0], [100 * size]], [[1.0, size]], 0, 0.01)
    found = pl.observer(model, 0.3, [[0, 1]], [[0]])
    np.testing.assert_allclose(found.L2, [[-size * kept], [1]], rtol=1e-9)
    np.testing.assert_allclose(found.H, [[100 * size * kept]], rtol=1e-9)


@pytest.mark.parametrize("gap, works", [(1e-10, False), (1e-7, True)])
def test_eigenvalues_of_E_and_A_are_apart_beyond_rounding(gap, works):
    model = control.ss(np.diag([0.3, 0.5]), [[1.0], [1.0]], [[1.0, 1.0]], 0, 0.01)
    if works:  # T = K C / (A - E)
        T = pl.luenberger(model, 0.5 + gap, 1).T
        np.testing.assert_allclose(T, [[-1 / (0.2 + gap), -1 / gap]], rtol=1e-6)
    else:
        with pytest.raises(ValueError, match=r"E: shares the eigenvalue 0\.5 with A"):
            pl.luenberger(model, 0.5 + gap, 1)


@pytest.mark.parametrize("lean, dimension", [(1e-7, 1), (1e-13, 2)])
def test_an_eigenvalue_on_an_invariant_zero_frees_one_more_entry(lean, dimension):
    """C shows x1 and x2; u = x3 keeps both at rest while x3 goes with the zero at 0.6."""
    A = np.array([[0.2, 0.1, -1.0], [0.3, -0.4, -2.0], [0.5, 0.7, 0.3]])
    model = control.ss(A, [[1.0], [2.0], [0.3]], np.eye(2, 3), 0, 0.01)
    assert pl.observer_family(model, 0.6 + lean).dimension == dimension


@pytest.mark.parametrize(
    "E, error, message",
    [
        ([0.9, 1.0], ValueError, "E: .* inside the unit circle, found one of magnitude 1;"),
        ([[0.9, 0.9], [-0.9, 0.9]], ValueError, "E: .* found one of magnitude 1.273"),
        ([0.9], ValueError, "E: 6 states and 4 outputs leave 2 .* found 1 x 1"),
        (np.diag([0.9] * 3), ValueError, "E: .* must be 2 x 2, found 3 x 3"),
        ([[0.9, 0]], ValueError, r"E: expected shape 1 x 1, found shape \(1, 2\)"),
        ([], ValueError, "E: expected the dynamics of at least one observer state"),
        ([0.9, np.nan], ValueError, "E: every entry must be finite"),
        ([0.9 + 0.1j, 0.9 - 0.1j], TypeError, "E: expected an array of real numbers"),
        ("fast", TypeError, "E: expected an array of real numbers, found 'fast'"),
        (None, (TypeError, ValueError), "E: "),
    ],
)
def test_bad_dynamics(triple_design, E, error, message):
    with pytest.raises(error, match=message):
        pl.observer_family(triple_design.model, E)
    with pytest.raises(error, match=r"E: |K: expected shape"):
        pl.luenberger(triple_design.model, E, np.ones((2, 4)))


def test_shared_eigenvalue_is_named(triple_design):
    shared = np.sort(np.abs(np.linalg.eigvals(triple_design.model.A)))[1]
    with pytest.raises(ValueError, match=f"E: shares the eigenvalue {shared:.6g} with A"):
        pl.observer_family(triple_design.model, [shared, 0.5])
    X = np.array([[1.0, 2.0], [0.5, -1.0]])
    with pytest.raises(ValueError, match="E: shares the eigenvalue"):
        pl.luenberger(
            triple_design.model, X @ np.diag([shared, 0.5]) @ np.linalg.inv(X), np.ones((2, 4))
        )


@pytest.mark.parametrize(
    "call, error, message",
    [
        (
            lambda d: pl.observer_family(d.model.A, 0.9),
            TypeError,
            "model: expected a control.State",
        ),
        (lambda d: pl.luenberger(None, 0.9, 1), TypeError, "model: expected a control.StateSpace"),
        (lambda d: pl.observer(1, 0.9, 1, 1), TypeError, "model: expected a control.StateSpace"),
        (
            lambda d: pl.luenberger(d.model, 0.9, np.ones((2, 3))),
            ValueError,
            "K: expected shape 2 x",
        ),
        (lambda d: d.family.member([1, 2, 3]), ValueError, "coefficients: expected shape 4"),
        (lambda d: d.family.member([1, 2, 3, np.nan]), ValueError, "coefficients: every entry"),
        (
            lambda d: d.family.project(np.ones((2, 5)), np.ones((2, 4))),
            ValueError,
            "T: expected shape",
        ),
        (
            lambda d: d.family.distance(np.ones((2, 6)), np.ones((1, 4))),
            ValueError,
            "K: expected shape",
        ),
        (
            lambda d: pl.observer(d.model, d.E, 1.01 * d.observer.T, d.observer.K),
            ValueError,
            "T, K: TA - ET = KC must hold, found a gap of",
        ),
        (
            lambda d: pl.observer(d.model, d.E[:1], d.observer.T[:1], d.observer.K[:1]),
            ValueError,
            "E: 6 states and 4 outputs leave 2 to estimate, so E must be 2 x 2, found 1 x 1",
        ),
    ],
)
def test_bad_input(triple_design, call, error, message):
    with pytest.raises(error, match=message):
        call(triple_design)


PARTS = dict(
    E=np.diag([0.5, 0.6]), H=np.zeros((2, 1)), T=np.ones((2, 5)), K=np.ones((2, 3)),
    L1=np.ones((5, 3)), L2=np.ones((5, 2)),
)  # fmt: skip


@pytest.mark.parametrize(
    "name, bad, message",
    [
        ("E", np.diag([0.5, 1.6]), "E: the observer's eigenvalues must lie inside"),
        ("H", np.zeros((3, 1)), "H: expected shape 2 x any"),
        ("T", np.ones((3, 5)), "T: expected shape 2 x any"),
        ("K", np.ones((1, 3)), "K: expected shape 2 x any"),
        ("L1", np.ones((5, 4)), "L1: expected shape 5 x 3"),
        ("L2", np.ones((4, 2)), "L2: expected shape 5 x 2"),
        ("T", np.full((2, 5), np.inf), "T: every entry must be finite"),
    ],
)
def test_observer_is_checked_on_construction(name, bad, message):
    assert pl.Observer(**PARTS).K.shape == (2, 3)
    one = {part: PARTS[part][:1] for part in "HTK"}
    assert pl.Observer(E=0.5, L1=PARTS["L1"], L2=np.ones((5, 1)), **one).E == [[0.5]]
    with pytest.raises(ValueError, match=message):
        pl.Observer(**PARTS | {name: bad})


def test_observers_may_be_compared_and_kept_in_sets(triple_design):
    one, two = pl.Observer(**PARTS), pl.Observer(**PARTS)
    assert one == one and len({one, two, triple_design.observer}) == 3


def test_block_diagonal_plants_give_block_diagonal_families():
    """Two plants side by side: members of each, side by side, are members of both together."""
    rng = np.random.default_rng(8)
    parts = [[rng.standard_normal(s) for s in ((3, 3), (3, 1), (2, 3))] for _ in range(2)]
    models = [control.ss(*p, 0, 0.01) for p in parts]
    both = control.ss(*(block_diag(*x) for x in zip(*parts, strict=True)), 0, 0.01)
    members = [
        pl.observer_family(m, e).member([1.0]) for m, e in zip(models, (0.5, 0.6), strict=True)
    ]
    family = pl.observer_family(both, [0.5, 0.6])
    T, K = (block_diag(*(getattr(m, x) for m in members)) for x in "TK")
    assert family.distance(T, K) < 1e-12
