"""A resonance narrower than any grid: peak gain, margins and structured margin still find it."""

import control
import numpy as np
import pytest
from scipy.linalg import block_diag

import pendlab as pl
from pendlab.loop import least

DT, OMEGA = 0.01, 20.0
DAMPING = [1e-3, 1e-5, 1e-6, 1e-7]


def mode(damping, omega=OMEGA):
    """Rotation block with the eigenvalues exp((-damping +- j sqrt(1 - damping^2)) omega DT)."""
    z = np.exp((-damping + 1j * np.sqrt(1 - damping**2)) * omega * DT)
    return np.array([[z.real, z.imag], [-z.imag, z.real]])


def around(damping, omega=OMEGA, widths=40, points=100_001):
    """Frequencies within some widths of the peak: dense where a general grid has no point."""
    return omega * (1 + damping * np.linspace(-widths, widths, points))


@pytest.mark.parametrize("damping", DAMPING)
@pytest.mark.parametrize("inputs", [1, 2])
def test_peak_gain_of_one_mode(damping, inputs):
    rng = np.random.default_rng(inputs)
    B, C = rng.standard_normal((2, inputs)), damping * rng.standard_normal((inputs, 2))
    system = control.ss(mode(damping), B, C, 0, DT)
    dense = np.linalg.norm(pl.frequency_response(system, around(damping)), 2, axis=(1, 2))
    value, omega = pl.peak_gain(system)
    assert value == pytest.approx(dense.max(), rel=1e-6)
    assert omega == pytest.approx(around(damping)[dense.argmax()], rel=damping)


@pytest.mark.parametrize("damping", DAMPING)
def test_peak_gain_of_two_modes_that_lie_in_one_another(damping):
    """The peak of the sum lies beside both eigenfrequencies."""
    A = block_diag(mode(damping), mode(damping, OMEGA * (1 + damping)))
    C = damping * np.array([[1.0, 0.5, 0.7, -0.4]])
    system = control.ss(A, [[1.0], [0.2], [0.8], [1.0]], C, 0, DT)
    dense = np.abs(pl.frequency_response(system, around(damping))[:, 0, 0])
    assert pl.peak_gain(system)[0] == pytest.approx(dense.max(), rel=1e-6)


@pytest.mark.parametrize("damping", DAMPING)
def test_margins_see_a_lightly_damped_closed_loop(damping):
    """|1 + L| = |closed|/|opened| dips where the closed loop rings, whatever the grid.

    The closed loop is given, the open one follows by feedback of one entry.
    """
    C = np.array([[0.0, 0.3]])
    loop = control.ss(mode(damping) + np.array([[1.0], [0.0]]) @ C, [[1.0], [0.0]], C, 0, DT)
    found = pl.margins(loop)
    dense = np.abs(1 + pl.frequency_response(loop, around(damping))[:, 0, 0])
    assert found.modulus == pytest.approx(dense.min(), rel=1e-5) and found.stable
    assert found.modulus_omega == pytest.approx(OMEGA, rel=10 * damping)
    for factor in (found.gain_up, found.gain_down):
        if 0 < factor < np.inf:
            crossing = np.linalg.eigvals(loop.A - factor * loop.B @ loop.C)
            assert np.abs(np.abs(crossing) - 1).min() < 1e-9


@pytest.mark.parametrize("damping", DAMPING)
def test_crossovers_of_a_resonance_come_in_pairs(damping):
    """A peak above 1 on a response that is small elsewhere: unit gain on both of its sides."""
    loop = control.ss(mode(damping), [[1.0], [0.0]], [[damping, 0.0]], 0, DT)
    found = pl.margins(loop)
    assert len(found.crossover) == 2
    assert found.crossover[0] < OMEGA < found.crossover[1]
    for omega in found.crossover:
        assert abs(pl.frequency_response(loop, omega).item()) == pytest.approx(1, rel=1e-5)


@pytest.mark.parametrize("damping", DAMPING)
def test_structured_margin_sees_a_lightly_damped_closed_loop(damping):
    """Two inputs without coupling: the smaller of the two modulus margins."""
    C = np.array([[0.0, 0.3]])
    ringing = mode(damping) + np.array([[1.0], [0.0]]) @ C
    A = block_diag(ringing, [[0.5]])
    loop = control.ss(A, block_diag([[1.0], [0.0]], [[1.0]]), block_diag(C, [[0.1]]), 0, DT)
    alone = pl.margins(control.ss(ringing, [[1.0], [0.0]], C, 0, DT))
    found = pl.structured_margin(loop)
    assert found.value == pytest.approx(alone.modulus, rel=1e-6)
    assert found.omega == pytest.approx(alone.modulus_omega, rel=damping)


def test_every_grid_begins_below_the_slowest_eigenvalue():
    slow = np.exp(-1e-5 * DT)
    assert pl.frequency_grid(DT, eigenvalues=[slow, 1.0, 0.5]).min() == pytest.approx(
        1e-7, rel=1e-2
    )


def test_least_refines_the_dip_that_wins():
    """The deepest dip of the grid need not be the deepest one."""

    def function(x):
        return np.minimum(1 + 1e4 * (x - 0.333) ** 2, 0.9 + 1e4 * (x - 0.6505) ** 2)

    grid = np.linspace(0, 1, 101)
    value, at = least(function, grid)
    assert value == pytest.approx(0.9, abs=1e-6) and at == pytest.approx(0.6505, abs=1e-4)
