"""Loop analysis of sampled systems: frequency response, encirclements, margins.

A loop is a square control.StateSpace L with closed loop u = -L u: L = P G broken at every input
(`open_loop`), or broken at one input with the others closed (`broken_at`).
"""

from dataclasses import dataclass
from typing import NamedTuple

import control
import numpy as np
from scipy.linalg import schur
from scipy.optimize import brentq

from ._arguments import array, found, number, state_space, whole
from .controllers import Controller

ON_CIRCLE = 1e-8  # an eigenvalue this close to the unit circle counts as on it (the integrator)


def frequency_response(system, omega):
    """C (zI - A)^-1 B + D at z = e^(j omega dt), or at s = j omega for a continuous system.

    Parameters
    ----------
    system : control.StateSpace with p outputs and m inputs
    omega : N frequencies, rad/s; an integrator has no response at 0

    Returns
    -------
    complex array (N, p, m)
    """
    state_space("system", system)
    omega = array("omega", np.atleast_1d(omega), (None,))
    with np.errstate(divide="ignore", invalid="ignore"):
        response = transfer(system, np.exp(1j * omega * system.dt) if system.dt else 1j * omega)
    at_pole = ~np.isfinite(response).all(axis=(1, 2))
    if at_pole.any():
        raise ValueError(
            f"omega: the system has a pole at {omega[at_pole][0]:g} rad/s and no response there; "
            "leave this frequency out."
        )
    return response


def transfer(system, z):
    """C (zI - A)^-1 B + D at the N complex numbers z, shape (N, p, m).

    One complex Schur form, then back substitution for all z at once: safe for repeated
    eigenvalues, where an eigenvector basis does not exist.
    """
    return prepared(system)(z)


def prepared(system):
    """`transfer` of one system as a function of z: the Schur form is made once."""
    triangle, Z = schur(system.A, output="complex")
    B, C = Z.conj().T @ system.B, system.C @ Z
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

    `controller` is a pl.Controller (u = -P y) and `plant` a sampled model with the same dt.
    """
    if not isinstance(controller, Controller):
        raise TypeError(f"controller: expected a pl.Controller, {found(controller)}.")
    system = controller.system
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
    A = np.block(
        [
            [plant.A, np.zeros((plant.nstates, system.nstates))],
            [system.B @ plant.C, system.A],
        ]
    )
    B = np.vstack([plant.B, np.zeros((system.nstates, plant.ninputs))])
    C = -np.hstack([system.D @ plant.C, system.C])
    return control.ss(A, B, C, 0, plant.dt, name="P G")


def state_feedback_loop(model, F):
    """F (zI - A)^-1 B, the loop gain of u = -F x, as a control.StateSpace."""
    F = array("F", np.atleast_2d(F), (model.ninputs, model.nstates))
    return control.ss(model.A, model.B, F, 0, model.dt, name="F (zI - A)^-1 B")


def broken_at(loop, index):
    """`loop` broken at one input with all the others closed: rd_index(z) - 1, (33) and (34).

    The other inputs are u_o = -C_o x, so A becomes A - B_o C_o.
    """
    check_loop(loop)
    if whole("index", index) >= loop.ninputs:
        raise ValueError(f"index: expected 0 to {loop.ninputs - 1}, found {index}.")
    others = [j for j in range(loop.ninputs) if j != index]
    A = loop.A - loop.B[:, others] @ loop.C[others]
    return control.ss(
        A, loop.B[:, [index]], loop.C[[index]], 0, loop.dt, name=f"broken at input {index + 1}"
    )


def check_loop(loop):
    """Refuse what is no loop of this module: square, sampled, D = 0."""
    state_space("loop", loop)
    if loop.ninputs != loop.noutputs:
        raise ValueError(
            f"loop: expected as many inputs as outputs, found {loop.ninputs} and {loop.noutputs}; "
            "use pl.open_loop or pl.state_feedback_loop."
        )
    if not loop.dt:
        raise ValueError("loop: expected a sampled loop, found a continuous one; use pl.sample.")
    if np.any(loop.D):
        raise ValueError("loop: expected D = 0, as of any sampled plant, found another D.")


def closed_loop_eigenvalues(loop):
    """Eigenvalues of A - B C, sorted by magnitude, the largest first."""
    return sorted_eigenvalues(loop.A - loop.B @ loop.C)


def sorted_eigenvalues(A):
    """Eigenvalues by falling magnitude, then rising real part, the positive imaginary one first."""
    values = np.linalg.eigvals(A)
    order = np.lexsort((-values.imag.round(9), values.real.round(9), -np.abs(values).round(9)))
    return values[order] + 0.0


def loop_gain(controller, plant, omega):
    """P(z) G(z) on the unit circle at `omega` (rad/s), shape (len(omega), m, m)."""
    return frequency_response(open_loop(controller, plant), omega)


class ReturnDifferences(NamedTuple):
    """Equations (33)-(35) at N frequencies; each of shape (N,)."""

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
    stable : whether the closed loop is stable; if not, the numbers are distances to a crossing
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
    both ends count as crossings of the real axis.
    """
    check_loop(loop)
    if loop.ninputs != 1:
        raise ValueError(
            f"loop: margins belong to one input and one output, found {loop.ninputs} x "
            f"{loop.noutputs}; use pl.broken_at(loop, 0)."
        )
    response = prepared(loop)
    L_at = lambda omega: response(np.exp(1j * np.atleast_1d(omega) * loop.dt))[:, 0, 0]  # noqa: E731
    A, B, C, one = loop.A, loop.B, loop.C, np.eye(loop.nstates)
    # One frequency at a time, for the root finder: a solve is cheaper than the prepared form.
    at = lambda w: (C @ np.linalg.solve(np.exp(1j * w * loop.dt) * one - A, B)).item()  # noqa: E731
    # The slowest eigenvalue, opened or closed, says where the lowest crossing may be.
    opened, closed = np.linalg.eigvals(loop.A), closed_loop_eigenvalues(loop)
    slow = np.abs(np.concatenate([opened, closed]) - 1)
    lowest = min(1e-3, 0.01 * slow.min(initial=1, where=slow > ON_CIRCLE) / loop.dt)
    omega = frequency_grid(loop.dt, points, lowest)
    L = L_at(omega)
    # At pi/dt the imaginary part is zero up to rounding: no sign to compare, a crossing by itself.
    real_axis = _roots(omega[:-1], L.imag[:-1], lambda w: at(w).imag) + [omega[-1]]
    if np.abs(opened - 1).min() > ON_CIRCLE:
        real_axis.insert(0, 0.0)
    crossings = [(at(w).real, w) for w in real_axis]
    up = min(((-1 / x, w) for x, w in crossings if -1 < x < 0), default=(np.inf, np.nan))
    down = max(((-1 / x, w) for x, w in crossings if x < -1), default=(0.0, np.nan))
    crossover = _roots(omega, np.abs(L) - 1, lambda w: abs(at(w)) - 1)
    phase = min(((abs(np.angle(-at(w))), w) for w in crossover), default=(np.inf, np.nan))
    k = int(np.argmin(np.abs(1 + L)))
    near = np.linspace(omega[max(k - 1, 0)], omega[min(k + 1, len(omega) - 1)], 201)
    distance = np.abs(1 + L_at(near))
    return Margins(
        gain_up=up[0],
        gain_down=down[0],
        gain_up_omega=float(up[1]),
        gain_down_omega=float(down[1]),
        phase=float(phase[0]),
        phase_omega=phase[1],
        modulus=float(distance.min()),
        modulus_omega=float(near[distance.argmin()]),
        crossover=tuple(crossover),
        stable=bool(np.abs(closed[0]) < 1),
    )


def frequency_grid(dt, points=1500, lowest=1e-3):
    """Frequencies from `lowest` rad/s to pi/dt: logarithmic below, linear in the top decade."""
    top = np.pi / number("dt", dt, above=0)
    return np.unique(
        np.concatenate(
            [
                np.geomspace(lowest, top, points - points // 4),
                np.linspace(top / 20, top, points // 4),
            ]
        )
    )


def _roots(omega, values, function):
    """Sign changes of `values` over `omega`, each refined on `function`."""
    at = np.flatnonzero(np.sign(values[:-1]) * np.sign(values[1:]) < 0)
    return [brentq(function, omega[i], omega[i + 1], xtol=1e-14) for i in at]
