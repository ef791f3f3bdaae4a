"""Loop analysis of sampled systems: frequency responses, return differences, margins.

A loop is a square control.StateSpace L = P G with closed loop u = -L u: what comes back, with the
sign turned, when the loop is broken at the x. `open_loop` breaks it at every input, `broken_at`
at one with the others closed.

         u     +-------+     y     +------+
    --x------->| G(z)  |---------->| P(z) |---+      I + L: return difference
      |        +-------+           +------+   |
      +------------------ -1 <----------------+
"""

from dataclasses import dataclass
from typing import NamedTuple

import control
import numpy as np
from scipy.linalg import matrix_balance, schur
from scipy.optimize import brentq

from ._arguments import array, instance, number, state_space, whole
from .controllers import Controller

ON_CIRCLE = 1e-8  # an eigenvalue this close to the unit circle counts as on it (the integrator)


def frequency_response(system, omega):
    """C (zI - A)^-1 B + D at z = e^(j omega dt), or at s = j omega for a continuous system.

    A complex array (N, p, m) for N frequencies `omega` in rad/s, p outputs and m inputs; ValueError
    at a pole, as an integrator has at 0.

    >>> lag = control.ss([[-1.0]], [[1.0]], [[1.0]], 0)
    >>> pl.frequency_response(lag, 1.0).tolist()  # 1/(1 + j)
    [[[(0.5-0.5j)]]]
    """
    state_space("system", system)
    omega = array("omega", omega, (None,))
    with np.errstate(divide="ignore", invalid="ignore"):
        response = prepared(system)(np.exp(1j * omega * system.dt) if system.dt else 1j * omega)
    poles = omega[~np.isfinite(response).all(axis=(1, 2))]
    if len(poles):
        raise ValueError(f"omega: the system has a pole at {poles[0]:g} rad/s; leave it out.")
    return response


def prepared(system):
    """C (zI - A)^-1 B + D, shape (N, p, m), as a function of N complex numbers z.

    One complex Schur form for all of them, then back substitution for all z at once: safe for
    repeated eigenvalues, where an eigenvector basis does not exist.
    """
    # Balanced first, by powers of two: units of the states must not decide how much is rounded.
    A, (unit, _) = matrix_balance(system.A, permute=False, separate=True)
    triangle, Z = schur(A, output="complex")
    B, C = Z.conj().T @ (system.B / unit[:, None]), (system.C * unit) @ Z
    n, m = B.shape

    def at(z):
        z = np.asarray(z, dtype=complex)
        X = np.empty((n, m * len(z)), dtype=complex)
        difference = np.tile(z, m) - np.diag(triangle)[:, None]
        for i in reversed(range(n)):
            # Not @: BLAS would start its threads for a sum that takes microseconds, and on a busy
            # machine they wait for each other hundreds of times longer than that.
            right = np.repeat(B[i], len(z)) + np.einsum("j,jk", triangle[i, i + 1 :], X[i + 1 :])
            X[i] = right / difference[i]
        return np.moveaxis(np.einsum("ij,jk", C, X).reshape(len(C), m, len(z)), -1, 0) + system.D

    return at


def open_loop(controller, plant):
    """P(z) G(z), loops broken at all m plant inputs, as one m x m control.StateSpace.

    `controller` is a pl.Controller (u = -P y) or, for one of one's own, its control.StateSpace from
    the readings to the voltages; `plant` a sampled model with the same dt.

    >>> design = pl.paper_design("double")
    >>> pl.open_loop(design.controller, design.model).nstates  # plant 4, observer 1, integrator 1
    6
    """
    if isinstance(controller, control.StateSpace):
        system = state_space("controller", controller, sampled=True)
    else:
        system = instance("controller", controller, Controller).system
    if not np.isclose(state_space("plant", plant).dt, system.dt):
        raise ValueError(
            f"plant: expected one sampled at the controller's {system.dt} s, found dt = "
            f"{plant.dt}; use pl.sample(plant, {system.dt})."
        )
    if plant.noutputs != system.ninputs or plant.ninputs != system.noutputs:
        raise ValueError(
            f"plant: expected {system.noutputs} inputs and {system.ninputs} outputs to match the "
            f"controller, found {plant.ninputs} and {plant.noutputs}."
        )
    loop = -(system * plant)
    loop.update_names(name="P G")
    return loop


def state_feedback_loop(model, F):
    """F (zI - A)^-1 B, the loop gain of u = -F x, as a control.StateSpace.

    >>> design = pl.paper_design("double")
    >>> round(pl.margins(pl.state_feedback_loop(design.augmented, design.F)).modulus, 3)
    0.946
    """
    state_space("model", model)
    F = array("F", F, (model.ninputs, model.nstates))
    return control.ss(model.A, model.B, F, 0, model.dt, name="F (zI - A)^-1 B")


def broken_at(loop, index):
    """`loop` broken at one input with all the others closed: rd_index(z) - 1, (33) and (34).

    The other inputs are u_o = -C_o x, so A becomes A - B_o C_o.

    >>> pl.broken_at(pl.paper_design("triple").nominal_loop, 0).ninputs
    1
    """
    whole("index", index, most=check_loop(loop).ninputs - 1)
    others = [j for j in range(loop.ninputs) if j != index]
    A = loop.A - loop.B[:, others] @ loop.C[others]
    B, C = loop.B[:, [index]], loop.C[[index]]
    return control.ss(A, B, C, 0, loop.dt, name=f"broken at input {index + 1}")


def check_loop(loop):
    """Refuse what is no loop of this module: square, sampled, D = 0."""
    state_space("loop", loop, sampled=True)
    if loop.ninputs != loop.noutputs:
        raise ValueError(
            f"loop: expected as many inputs as outputs, found {loop.ninputs} and {loop.noutputs}; "
            "use pl.open_loop or pl.state_feedback_loop."
        )
    if np.any(loop.D):
        raise ValueError("loop: expected D = 0, as of any sampled plant, found another D.")
    return loop


def closed_loop_eigenvalues(loop):
    """Eigenvalues of A - B C, sorted by magnitude, the largest first.

    >>> pl.closed_loop_eigenvalues(control.ss([[1.2]], [[1]], [[0.7]], 0, 0.01)).round(3)
    array([0.5])
    """
    check_loop(loop)
    return sorted_eigenvalues(loop.A - loop.B @ loop.C)


def sorted_eigenvalues(A):
    """Eigenvalues by falling magnitude, then rising real part, the positive imaginary one first."""
    values = np.linalg.eigvals(A)
    if not np.any(values.imag):
        values = values.real  # NumPy from 2.5 on calls them complex
    order = np.lexsort((-values.imag.round(9), values.real.round(9), -np.abs(values).round(9)))
    return values[order] + 0.0


def loop_gain(controller, plant, omega):
    """P(z) G(z) on the unit circle at `omega` (rad/s), shape (len(omega), m, m).

    >>> design = pl.paper_design("double")
    >>> abs(pl.loop_gain(design.controller, design.model, 200.0)).round(3)
    array([[[0.064]]])
    """
    return frequency_response(open_loop(controller, plant), omega)


class ReturnDifferences(NamedTuple):
    """Equations (33)-(35) at N frequencies, each of shape (N,)."""

    rd1: np.ndarray
    rd2: np.ndarray
    det: np.ndarray
    sigma_min: np.ndarray


def return_differences(controller, plant, omega):
    """rd1, rd2, det(I + P G) and the smallest singular value of I + P G for two inputs.

    rd1 = det(I + P G) / (1 + p2 g2) is (33) with the loop broken at input 1 and loop 2 closed;
    rd2 = det(I + P G) / (1 + p1 g1) is (34).
    """
    L = loop_gain(controller, plant, omega)
    if L.shape[1:] != (2, 2):
        raise ValueError(
            f"controller: return_differences takes two inputs, found {L.shape[1]}; "
            "use pl.loop_gain for one."
        )
    Rd = np.eye(2) + L
    det = Rd[:, 0, 0] * Rd[:, 1, 1] - Rd[:, 0, 1] * Rd[:, 1, 0]
    sigma_min = np.linalg.svd(Rd, compute_uv=False)[:, -1]
    return ReturnDifferences(det / Rd[:, 1, 1], det / Rd[:, 0, 0], det, sigma_min)


@dataclass(frozen=True)
class Margins:
    """Stability margins of a single loop; frequencies in rad/s, phase in rad.

    Attributes
    ----------
    gain_up, gain_down : factors by which the gain may rise and fall until an eigenvalue meets the
        unit circle (inf and 0 where it never does)
    gain_up_omega, gain_down_omega : where (pi/dt: an eigenvalue leaves at z = -1)
    phase, phase_omega : smallest phase change, either way, that meets the circle, and where
    modulus, modulus_omega : smallest distance of the curve from -1, and where
    crossover : frequencies of unit gain
    stable : whether the closed loop is; if not, the numbers are distances to a crossing
    """

    gain_up: float
    gain_down: float
    gain_up_omega: float
    gain_down_omega: float
    phase: float
    phase_omega: float
    modulus: float
    modulus_omega: float
    crossover: tuple
    stable: bool


def margins(loop, points=2000):
    """`Margins` of a sampled loop with one input, all crossings on (0, pi/dt] counted.

    L(e^(j omega dt)) is real at omega = pi/dt always, and at omega = 0 where no integrator is;
    both ends count as crossings of the real axis. Frequencies: `loop_frequencies`.

    >>> round(pl.margins(pl.paper_design("double").loop(filters=True)).modulus, 3)  # Fig 8
    0.65
    """
    check_loop(loop)
    if loop.ninputs != 1:
        raise ValueError(
            f"loop: margins belong to one input and one output, found {loop.ninputs} x "
            f"{loop.noutputs}; use pl.broken_at(loop, 0)."
        )
    response, A, B, C, one = prepared(loop), loop.A, loop.B, loop.C, np.eye(loop.nstates)

    def L_at(omega):
        return response(np.exp(1j * omega * loop.dt))[:, 0, 0]

    def at(w):  # one frequency at a time, for the root finder: a solve is cheaper
        return (C @ np.linalg.solve(np.exp(1j * w * loop.dt) * one - A, B)).item()

    omega = loop_frequencies(loop, points)
    L = L_at(omega)
    # At both ends the imaginary part is zero up to rounding: no sign to compare, crossings anyway.
    rest = int(omega[0] == 0)
    inside = crossings(omega[rest:-1], L.imag[rest:-1], lambda w: at(w).imag)
    real = [(at(w).real, w) for w in (*omega[:rest], *inside, omega[-1])]
    up = min(((-1 / x, w) for x, w in real if -1 <= x < 0), default=(np.inf, np.nan))
    down = max(((-1 / x, w) for x, w in real if x <= -1), default=(0.0, np.nan))
    crossover = crossings(omega, np.abs(L) - 1, lambda w: abs(at(w)) - 1)
    phase = min(((abs(np.angle(-at(w))), w) for w in crossover), default=(np.inf, np.nan))
    modulus = least(lambda w: np.abs(1 + L_at(w)), omega)
    sizes = (up[0], down[0], up[1], down[1], *phase, *modulus)
    stable = bool(np.abs(closed_loop_eigenvalues(loop)[0]) < 1)
    return Margins(*map(float, sizes), tuple(crossover), stable)


def frequency_grid(dt, points=1500, lowest=1e-3, eigenvalues=()):
    """Frequencies from `lowest` rad/s to pi/dt: logarithmic below, linear in the top decade.

    Narrow resonances fall between the points of any grid, so give the `eigenvalues` of A, opened
    and closed: from their own frequencies points spread as wide as each peak until the grid takes
    over, and the grid begins well below the slowest.

    >>> pl.frequency_grid(0.01, 6, 1.0).round(1)
    array([  1. ,   4.2,  15.7,  17.7,  74.6, 314.2])
    """
    top = np.pi / number("dt", dt, above=0)
    whole("points", points, least=4, most=1_000_000)
    number("lowest", lowest, above=0, most=top)
    z = np.asarray(eigenvalues, dtype=complex)
    distance = np.abs(z - 1)
    away = (distance > ON_CIRCLE) & (np.abs(z) > 1e-300)
    lowest = min(lowest, 0.01 * distance.min(initial=np.inf, where=away) / dt)
    linear = points // 4
    pieces = [np.geomspace(lowest, top, points - linear), np.linspace(top / 20, top, linear)]
    for s in np.log(z[away]) / dt:
        width, own = max(abs(s.real), 1e-9 / dt), abs(s.imag)
        reach = 40 * max(own, lowest) / points  # two or three points of the grid
        if width < reach:
            spread = np.geomspace(width / 4, reach, 4 + int(4 * np.log10(reach / width)))
            pieces.append(own + np.concatenate([-spread, [0.0] * int(width > 1e-9 / dt), spread]))
    omega = np.unique(np.concatenate(pieces))
    return omega[(omega >= lowest) & (omega <= top)]


def loop_frequencies(loop, points=2000):
    """`frequency_grid` for a loop, of its eigenvalues opened and closed; from 0 if no pole is there."""
    opened, closed = on_circle(loop.A), np.linalg.eigvals(loop.A - loop.B @ loop.C)
    omega = frequency_grid(loop.dt, points, eigenvalues=np.concatenate([opened, closed]))
    return omega if np.abs(opened - 1).min() <= ON_CIRCLE else np.append(0.0, omega)


def least(function, omega):
    """Least value of `function` (of an array) over the grid `omega`, refined, and where it is.

    A grid alone never decides: the three lowest dips are each cut finer between their neighbours.
    """
    values = function(omega)
    around = np.concatenate([[np.inf], values, [np.inf]])
    dips = np.flatnonzero((values <= around[:-2]) & (values <= around[2:]))
    found = []
    for k in dips[np.argsort(values[dips])][:3]:
        grid, at, best = omega, k, (values[k], omega[k])
        for _ in range(2):
            grid = np.linspace(grid[max(at - 1, 0)], grid[min(at + 1, len(grid) - 1)], 101)
            fine = function(grid)
            at = int(np.argmin(fine))
            if fine[at] < best[0] - 1e-13 * abs(best[0]):  # rounding is no improvement
                best = fine[at], grid[at]
        found.append(best)
    value, where = min(found)
    return float(value), float(where)


def crossings(omega, values, function):
    """Sign changes of `values` over `omega`, each refined on `function`."""
    at = np.flatnonzero(np.sign(values[:-1]) * np.sign(values[1:]) < 0)
    return [float(brentq(function, omega[i], omega[i + 1], xtol=1e-14)) for i in at]


def on_circle(A):
    """Eigenvalues of A, those on the unit circle put back where rounding has moved them off it.

    k equal eigenvalues come out apart by about the k-th root of rounding, their mean does not.
    """
    values = np.linalg.eigvals(A).astype(complex)
    rounding = 1e-13 * max(1.0, np.linalg.norm(matrix_balance(A, permute=False)[0], 2))
    for value in values[np.abs(np.abs(values) - 1) < 1e-2]:
        near = np.argsort(np.abs(values - value))
        for k in range(np.sum(np.abs(values - value) < 1e-2), 0, -1):
            mean = values[near[:k]].mean()
            spread = np.abs(values[near[:k]] - mean).max()
            if abs(abs(mean) - 1) <= ON_CIRCLE and spread**k <= rounding:
                values[near[:k]] = mean / abs(mean)
                break
    return values
