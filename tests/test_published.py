"""The ledger of printed numbers: digits, errors, agreement with the rigs and with (1), (2)."""

from importlib import import_module

import numpy as np
import pytest
from scipy.linalg import expm

from pendlab.lagrange import derive
from pendlab.paper.ledger import Published, published
from pendlab.parameters import UNITS, Filters, Link, Motor, load

GOOD = '[[entry]]\nkey = "a"\nplace = "here"\nunit = "1"\nprinted = "1.0"\n'


def printed(text):
    return Published("key", "here", "1", text)


@pytest.fixture
def ledger(tmp_path, monkeypatch):
    """Write a ledger of one's own and read it with `published`."""
    monkeypatch.setattr(import_module("pendlab.paper.ledger"), "DATA", tmp_path)

    def write(text):
        (tmp_path / "published.toml").write_text(text, encoding="utf-8")

    return write


@pytest.mark.parametrize(
    "text, values, half",
    [
        ("3", 3.0, 0.5),
        ("-0.50", -0.5, 0.005),
        ("1.2353e-1", 0.12353, 5e-6),
        ("1e2", 100.0, 50.0),
        ("-1600 6.6684e-2 0", [-1600, 0.066684, 0], [0.5, 5e-7, 0.5]),
        ("1 0.20\n-3.0 4e-3", [[1, 0.2], [-3, 0.004]], [[0.5, 0.005], [0.05, 5e-4]]),
        ("0\n-24.8992", [[0], [-24.8992]], [[0.5], [5e-5]]),
    ],
)
def test_digits(text, values, half):
    entry = printed(text)
    assert entry.values.shape == entry.half_digit.shape == np.shape(values)
    np.testing.assert_array_equal(entry.values, values)
    np.testing.assert_allclose(entry.half_digit, half, rtol=1e-15)


def test_values_cannot_be_changed():
    with pytest.raises(ValueError, match="read-only"):
        published("eq1.A").values[0, 0] = 1


@pytest.mark.parametrize("text", ["", "1 2\n3", "one", "nan", "inf", "1\n\n2", "\u22121.5"])
def test_printed_must_be_numbers_in_equal_rows(text):
    with pytest.raises(ValueError, match="printed: expected"):
        printed(text)


def test_holds_to_half_a_digit_and_no_further():
    entry = printed("0.13 -2.0")
    assert entry.holds([0.125, -2.05]) and entry.holds([0.135, -1.95])
    assert not entry.holds([0.1351, -2.0]) and not entry.holds([0.13, -2.051])
    assert not entry.holds([np.nan, -2.0]) and not entry.holds([np.inf, -2.0])
    assert entry.worst([0.132, -2.01]) == pytest.approx(0.4)


def test_axes_of_length_one_do_not_matter_but_shape_does():
    row, column = printed("1.0 2.0"), printed("1.0\n2.0")
    assert row.holds([[1, 2]]) and column.holds([1, 2]) and printed("1.0").holds([[1]])
    with pytest.raises(ValueError, match=r"key is printed with shape \(2,\), found shape \(3,\)"):
        row.holds([1, 2, 3])
    with pytest.raises(ValueError, match="shape"):
        printed("1.0 2.0\n3.0 4.0").holds([1, 2, 3, 4])
    with pytest.raises(TypeError, match="complex"):
        row.holds(np.array([1, 2 + 0j]))


def test_all_entries_in_order():
    entries = published()
    assert isinstance(entries, tuple) and published() == entries
    assert entries[0].key == "sec2.tube_diameter"
    assert all(published(entry.key) is entry for entry in entries)


def test_unknown_key_names_near_ones():
    with pytest.raises(ValueError, match=r"eq23.f'; near it are .*eq23.F"):
        published("eq23.f")
    with pytest.raises(ValueError, match=r"published.. lists all"):
        published("####")
    with pytest.raises(ValueError, match=r"no published number \['eq1.A'\]"):
        published(["eq1.A"])


@pytest.mark.parametrize(
    "text, message",
    [
        ("[[entry]\n", "not readable as TOML"),
        ("", r"expected tables \[\[entry\]\]"),
        ('entry = "a"', r"expected tables \[\[entry\]\]"),
        ("entry = [1]", "entry 1 .without key.: expected a table"),
        (GOOD + GOOD, "entry 2 .a.: key: 'a' is there twice"),
        (GOOD.replace('unit = "1"\n', ""), "entry 1 .a.: 'unit' is missing"),
        (GOOD.replace('key = "a"\n', ""), "entry 1 .without key.: 'key' is missing"),
        (GOOD + "digits = 4\n", "entry 1 .a.: 'digits' is not a field"),
        (GOOD.replace('"1.0"', "1.0"), "entry 1 .a.: printed: expected text in quotes, found 1.0"),
        (GOOD.replace('"here"', '" "'), "entry 1 .a.: place: expected text"),
        (GOOD.replace("1.0", "1.0\\n1 2"), "entry 1 .a.: printed: expected rows of equal length"),
        (GOOD.replace("1.0", "1,0"), "entry 1 .a.: printed: expected finite numbers, found '1,0'"),
    ],
)
def test_damaged_ledger_names_file_and_entry(ledger, text, message):
    ledger(text)
    with pytest.raises(ValueError, match=f"published.toml: {message}"):
        published()


def test_missing_ledger_is_named(ledger):
    with pytest.raises(ValueError, match=r"published.toml: file not found"):
        published("eq1.A")


def test_good_ledger_of_ones_own(ledger):
    ledger(GOOD)
    assert published() == (Published("a", "here", "1", "1.0"),)


def columns(rig, parts, fields):
    return {f: [getattr(part, f) for part in getattr(rig, parts)] for f in fields}


@pytest.mark.parametrize("rig, table", [("double", "table4"), ("triple", "table2")])
def test_rigs_carry_the_tables(rig, table):
    pendulum = load(rig)
    for field, ours in columns(pendulum, "links", UNITS[Link]).items():
        entry = published(f"{table}.{field}")
        # No length is printed for the last link.
        np.testing.assert_array_equal(np.atleast_1d(entry.values), ours[: entry.values.size])
        assert entry.values.size == pendulum.n_links - (field == "length")
        assert entry.unit == UNITS[Link][field]
    for field, ours in columns(pendulum, "motors", UNITS[Motor]).items():
        entry = published(f"table3.{field}")
        np.testing.assert_array_equal(entry.values[: pendulum.n_motors], ours)
        assert entry.unit == UNITS[Motor][field]
    for field, unit in UNITS[Filters].items():
        entry = published(f"table5.{rig}.{field}")
        np.testing.assert_array_equal(np.atleast_1d(entry.values), getattr(pendulum.filters, field))
        assert entry.unit == unit
    assert pendulum.g == published("table1.gravity").values
    limit = published("eq1.input_limit" if rig == "double" else "eq2.input_limits")
    np.testing.assert_array_equal(np.atleast_1d(limit.values), pendulum.u_max)


def state_space(rig):
    """A and B of Appendix A, (ii) and (iii)."""
    n, m = rig.n_links, rig.n_motors
    equations = derive(n, m)
    W, M, N, P, H = (np.array(X, float) for X in equations.linear(*equations.values(rig)))
    relative = lambda X: -W @ np.linalg.solve(M, X)  # noqa: E731
    A = np.block([[np.zeros((n, n)), np.eye(n)], [relative(P), relative(N)]])
    A[n:] = A[n:] @ np.kron(np.eye(2), np.linalg.inv(W))
    return A, np.vstack([np.zeros((n, m)), relative(H)])


@pytest.mark.parametrize("rig, equation", [("double", "eq1"), ("triple", "eq2")])
def test_equations_1_and_2_hold_to_every_printed_digit(rig, equation):
    pendulum = load(rig)
    A, B = state_space(pendulum)
    assert published(f"{equation}.A").holds(A)
    assert published(f"{equation}.B").holds(B)
    n = pendulum.n_links
    np.testing.assert_array_equal(published(f"{equation}.C").values, np.eye(n + 1, 2 * n))
    np.testing.assert_array_equal(published(f"{equation}.A").values[:n], np.eye(n, 2 * n, k=n))
    eigenvalues = published(f"{equation}.eigenvalues")
    rank = np.argsort(np.argsort(eigenvalues.values))
    assert eigenvalues.holds(np.sort(np.linalg.eigvals(A).real)[rank])


@pytest.mark.parametrize("design, inverse", [("eq24", "eq27"), ("eq25", "eq28"), ("eq36", "eq37")])
def test_printed_observers_invert(design, inverse):
    """[L1 L2][C; T] = I (7) to what the printed digits of T and L allow."""
    T, L = published(f"{design}.T"), published(f"{inverse}.L")
    copied = published(f"{inverse}.L_copied").values
    np.testing.assert_array_equal(copied, np.eye(*copied.shape))
    values, half_L = np.atleast_2d(L.values), np.atleast_2d(L.half_digit)
    C_T = np.vstack([np.eye(len(copied), copied.shape[1]), T.values])
    half_T = np.vstack([np.zeros_like(copied), T.half_digit])
    residual = np.abs(values @ C_T - np.eye(len(C_T))[len(copied) :])
    allowed = half_L @ np.abs(C_T) + (np.abs(values) + half_L) @ half_T
    assert np.all(residual <= allowed)


def test_k_p_interval_is_known_to_differ_at_both_ends():
    A, B = state_space(load("triple"))
    interval = published("eq18.k_p_interval")
    row = published("eq18.C_p").values @ published("eq2.C").values
    hold = expm(0.01 * np.block([[A, B[:, 1:]], [np.zeros((1, len(A) + 1))]]))

    def unstable(k_p):
        closed = hold[:-1, :-1] - k_p * np.outer(hold[:-1, -1], row)
        return np.sum(np.abs(np.linalg.eigvals(closed)) > 1)

    low, high = interval.values + interval.half_digit
    assert unstable(10) == published("eq18.unstable").values
    assert unstable(low) == 3, "still outside above the printed lower end"
    assert unstable(high) == 2, "not yet outside above the printed upper end"
    assert interval.known


def test_integral_gain_repeats_the_design():
    assert published("sec5.integrator.feedback").values == published("eq32.F").values[-1]
    assert published("sec5.integrator.T_s").values == published("sec2.sampling_interval").values
