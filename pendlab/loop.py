"""Loop analysis of sampled systems: frequency response, encirclements, margins.

A loop is a square control.StateSpace L with closed loop u = -L u: L = P G broken at every input
(`open_loop`), or broken at one input with the others closed (`broken_at`).
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import control
import numpy as np
from scipy.linalg import schur
from scipy.optimize import brentq

from ._checks import array, found, number, state_space, whole
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
    _sampled_loop(loop)
    if whole("index", index) >= loop.ninputs:
        raise ValueError(f"index: expected 0 to {loop.ninputs - 1}, found {index}.")
    others = [j for j in range(loop.ninputs) if j != index]
    A = loop.A - loop.B[:, others] @ loop.C[others]
    return control.ss(
        A, loop.B[:, [index]], loop.C[[index]], 0, loop.dt, name=f"broken at input {index + 1}"
    )


def _sampled_loop(loop):
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


class Encirclements(NamedTuple):
    """Anticlockwise turns of det(I + L) about 0 (one input: of L about -1), and the poles."""

    turns: int
    unstable_open: int
    unstable_closed: int

    @property
    def stable(self):
        return self.unstable_closed == 0


def encirclements(loop):
    """Turns of det(I + L(z)) about 0 as z goes once round the unit circle, counted on the curve.

    The contour leaves the circle outward round poles on it (the integrator at z = 1), which so
    count as stable. By the argument principle turns = unstable open-loop poles - unstable
    closed-loop poles; the count is held against both sets of eigenvalues.

    Parameters
    ----------
    loop : sampled square control.StateSpace of `open_loop`, `broken_at` or `state_feedback_loop`

    Raises
    ------
    ValueError : a closed-loop eigenvalue on the unit circle (the curve meets the critical point)
    ArithmeticError : count and eigenvalues disagree
    """
    _sampled_loop(loop)
    opened = np.linalg.eigvals(loop.A)
    closed = np.linalg.eigvals(loop.A - loop.B @ loop.C)
    touching = np.abs(np.abs(closed) - 1).min()
    if touching < 1e-12:
        raise ValueError(
            "loop: a closed-loop eigenvalue lies on the unit circle, so the curve goes through "
            "the critical point and no count exists; change the gain a little."
        )
    det, segments = _determinant(loop), _segments(opened, closed)
    turns = 2 * sum(_phase_change(det, z_of) for z_of in segments) / (2 * np.pi)
    count = Encirclements(
        round(turns), int(np.sum(np.abs(opened) > 1 + ON_CIRCLE)), int(np.sum(np.abs(closed) > 1))
    )
    if abs(turns - count.turns) > 1e-3 or (
        count.turns != count.unstable_open - count.unstable_closed
    ):
        raise ArithmeticError(
            f"loop: counted {turns:.4f} turns, but {count.unstable_open} open-loop and "
            f"{count.unstable_closed} closed-loop poles lie outside the unit circle."
        )
    return count


def contour(loop, points=400):
    """Upper half of the Nyquist contour: z, and det(I + L(z)) - 1 (L itself for one input)."""
    opened = np.linalg.eigvals(loop.A)
    segments = _segments(opened, np.linalg.eigvals(loop.A - loop.B @ loop.C))
    z = np.concatenate([z_of(np.linspace(0, 1, points)) for z_of in segments])
    return z, _determinant(loop)(z) - 1


def _determinant(loop):
    """det(I + L(z)) as a function of z."""
    L = prepared(loop)
    if loop.ninputs == 1:
        return lambda z: 1 + L(z)[:, 0, 0]
    return lambda z: np.linalg.det(np.eye(loop.ninputs) + L(z))


def _segments(opened, closed):
    """Pieces z(t), 0 <= t <= 1, of the upper half contour from z = 1 to z = -1."""
    on = np.abs(np.abs(opened) - 1) <= ON_CIRCLE
    stops = _distinct(np.abs(np.angle(opened[on])))
    poles = np.exp(1j * np.array(stops))
    off = np.concatenate([opened[~on], closed])
    others = np.concatenate([off, poles, poles.conj()])
    # The curve turns fast where an eigenvalue is near; arcs begin there, as they are dense at ends.
    near = _distinct(np.abs(np.angle(off[np.abs(np.abs(off) - 1) < 0.3])))
    pieces, here = [], 0.0
    for stop in stops:
        pole = np.exp(1j * stop)
        distances = np.abs(others - pole)
        radius = 0.1 * min(1e-4, distances[distances > 1e-12].min())
        half = 2 * np.arcsin(radius / 2)  # the circle is met at the angles stop -+ half
        first, last = max(stop - half, 0.0), min(stop + half, np.pi)
        if first > here:
            pieces += _arcs(here, first, near)
        pieces.append(_indentation(pole, radius, first, last, stop))
        here = last
    if here < np.pi:
        pieces += _arcs(here, np.pi, near)
    return pieces


def _arcs(start, stop, near):
    """Arcs of the circle from start to stop, parted at the angles `near`."""
    inside = [angle for angle in near if start + 1e-6 < angle < stop - 1e-6]
    corners = [start, *inside, stop]
    return [_arc_of_circle(a, b) for a, b in pairwise(corners)]


def _arc_of_circle(start, stop):
    """Angles from start to stop, dense towards both ends."""

    def z_of(t):
        t = np.asarray(t)
        width, least = stop - start, 1e-7
        near = np.where(t < 0.5, t, 1 - t)
        offset = least * ((width / (2 * least)) ** (2 * near) - 1) * width / (width - 2 * least)
        return np.exp(1j * np.where(t < 0.5, start + offset, stop - offset))

    return z_of


def _indentation(pole, radius, first, last, stop):
    """Outward arc round a pole on the unit circle, from e^(j first) to e^(j last)."""
    begin = pole * radius if first == stop else np.exp(1j * first) - pole
    end = pole * radius if last == stop else np.exp(1j * last) - pole
    turn = np.angle(end / begin) % (2 * np.pi)  # anticlockwise about the pole: outside the circle

    def z_of(t):
        return pole + begin * np.exp(1j * turn * np.asarray(t))

    return z_of


def _distinct(angles):
    kept = []
    for angle in sorted(map(float, angles)):
        if not kept or angle - kept[-1] > 1e-6:
            kept.append(angle)
    return kept


def _phase_change(det, z_of, largest=0.3):
    """Change of arg det(I + L) along one piece, refined until no step exceeds `largest` rad."""
    t = np.linspace(0, 1, 201)
    values = det(z_of(t))
    for _ in range(40):
        steps = np.angle(values[1:] / values[:-1])
        wide = np.flatnonzero(np.abs(steps) > largest)
        if not len(wide):
            break
        middle = (t[wide] + t[wide + 1]) / 2
        t = np.insert(t, wide + 1, middle)
        values = np.insert(values, wide + 1, det(z_of(middle)))
    return float(np.sum(np.angle(values[1:] / values[:-1])))


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
    _sampled_loop(loop)
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
