"""From sensor noise, torques on the links and references to angles and voltages, in closed loop.

`closed_loop` gives all paths as one control.StateSpace; `rms` and `peak_gain` are its H2 and
H-infinity measures. (``control.norm`` without slycot calls the paper's slow closed loop infinite
and takes neither poles at z = 0, which a deadbeat observer has, nor more inputs than outputs; where
it answers, it agrees.)
"""

import control
import numpy as np

from .._arguments import flag, instance, numbers, state_space
from ..design import Design
from ..loop import closed_loop_eigenvalues, frequency_grid, frequency_response, least
from ..models import angle_names, derived, matrices, with_filters
from ..parameters import Pendulum
from ..sampled import sample


def with_torques(plant, rig):
    """`plant` with a torque on each link as further inputs.

    From M theta'' + N theta' + P theta + H u = tau the relative accelerations gain W M^-1 tau, with
    tau in the direction of growing absolute angles. `plant` comes from `pl.linearize` or
    `pl.with_filters` of the `rig`; behind its inputs stand ``torque 1`` ... ``torque n`` (N m).

    >>> pl.with_torques(pl.linearize(pl.load("double")), pl.load("double")).input_labels
    ['u1', 'torque 1', 'torque 2']
    """
    n = instance("rig", rig, Pendulum, 'pl.load("triple")').n_links
    if state_space("plant", plant).dt != 0 or plant.state_labels[:n] != angle_names(n):
        raise ValueError(
            f"plant: expected the continuous model of a rig with {n} links, found states "
            f"{', '.join(plant.state_labels[:n])} and dt = {plant.dt}; use pl.linearize(rig)."
        )
    W, M, *_ = matrices(rig)
    torques = np.zeros((plant.nstates, n))
    torques[n : 2 * n] = W @ np.linalg.inv(M)
    B = np.hstack([plant.B, torques])
    D = np.hstack([plant.D, np.zeros((plant.noutputs, n))])
    inputs = plant.input_labels + [f"torque {i + 1}" for i in range(n)]
    return derived(plant, plant.A, B, plant.C, D, name=plant.name, inputs=inputs)


def closed_loop(design, filters=True):
    """The design's closed loop, from everything that drives it to angles and voltages.

    x(n+1) = A x + B u + B_tau tau,   y = C x + noise,   u = controller(y, y_r)

    With the rig's `filters` or without; noise enters behind them, at the A/D converter. A sampled
    control.StateSpace. Inputs: ``noise <output>`` of each reading (rad, rad/s), ``torque i`` on
    each link (N m, held over a sample), ``reference <output>`` of each tracked output (rad).
    Outputs: the n true relative angles (rad), then the m voltages (V).
    ``closed_loop(d)["u1", "torque 3"]`` picks one path.

    >>> pl.closed_loop(pl.paper_design("double")).output_labels
    ['theta1', 'theta2-theta1', 'u1']
    """
    instance("design", design, Design, 'pl.paper_design("triple")')
    flag("filters", filters)
    rig, K = design.rig, design.controller.system
    plant = with_filters(design.plant, rig.filters) if filters else design.plant
    G = sample(with_torques(plant, rig), design.dt)
    n, m, q, tracked = rig.n_links, rig.n_motors, G.noutputs, design.controller.tracked
    B, B_tau, C, r = G.B[:, :m], G.B[:, m:], G.C, len(tracked)
    B_ref = design.dt * np.eye(K.nstates, r, r - K.nstates)  # the integrators, last
    A_closed = np.block([[G.A + B @ K.D @ C, B @ K.C], [K.B @ C, K.A]])
    to_plant = np.hstack([B @ K.D, B_tau, np.zeros((G.nstates, r))])
    B_closed = np.vstack([to_plant, np.hstack([K.B, np.zeros((K.nstates, n)), B_ref])])
    angles = np.eye(n, G.nstates + K.nstates)
    C_closed = np.vstack([angles, np.hstack([K.D @ C, K.C])])
    D_closed = np.zeros((n + m, q + n + r))
    D_closed[n:, :q] = K.D
    noise = [f"noise {name}" for name in G.output_labels]
    references = [f"reference {G.output_labels[i]}" for i in tracked]
    labels = dict(
        inputs=noise + G.input_labels[m:] + references,
        outputs=angle_names(n) + plant.input_labels,
        name=f"{plant.name} in closed loop",
    )
    return control.ss(A_closed, B_closed, C_closed, D_closed, design.dt, **labels)


def time_constant(loop):
    """Time constant (s) of the slowest closed-loop motion, -dt/ln|z|; inf where it does not decay.

    >>> round(pl.time_constant(control.ss([[1.0]], [[1.0]], [[1 - np.exp(-0.01)]], 0, 0.01)), 6)
    1.0
    """
    largest = np.abs(closed_loop_eigenvalues(loop)[0])
    return float(-loop.dt / np.log(largest)) if 0 < largest < 1 else float(largest and np.inf)


def rms(system, deviations=1.0):
    """RMS value of each output under independent white noise at the inputs: weighted H2 norms.

    P = A P A' + B S B' gives the states' covariance, C P C' + D S D' that of the outputs, with
    S = diag(deviations^2). With deviations 1 the root of the squares' sum is the H2 norm. `system`
    is sampled and stable; `deviations` of every sample are one number per input or one for all.

    >>> lag = control.ss([[0.6]], [[1.0]], [[1.0]], 0, 0.01)  # variance 1/(1 - 0.6^2) = 1.25^2
    >>> pl.rms(lag).round(6).tolist()
    [1.25]
    """
    _stable(system)
    scale = np.array(numbers("deviations", deviations, least=0))
    if len(scale) not in (1, system.ninputs):
        raise ValueError(
            f"deviations: expected one number or {system.ninputs}, one per input, found {len(scale)}."
        )
    largest = scale.max(initial=0) or 1.0
    B, D = system.B * (scale / largest), system.D * (scale / largest)
    P = _covariance(system.A, B @ B.T)
    return largest * np.sqrt(np.diag(system.C @ P @ system.C.T + D @ D.T))


def _covariance(A, Q):
    """P = A P A' + Q as Q + A Q A' + ..., twice as many terms at each step (Smith 1968).

    A sum of positive terms: it never comes out negative, and units of the states do not matter.
    (A solution by a bilinear transform loses all digits where they differ by a million.)
    """
    P = Q
    for _ in range(64):  # 2^64 samples are as good as infinitely many
        more = A @ P @ A.T
        P, A = P + more, A @ A
        if np.all(np.diag(more) <= 1e-17 * np.diag(P)):
            break
    return P


def peak_gain(system, points=3000):
    """H-infinity norm: the largest singular value at any frequency, and that frequency.

    (value, rad/s) of a sampled stable `system`, looked for on a grid through every eigenvalue's own
    frequency, then refined.

    >>> lag = control.ss([[0.6]], [[1.0]], [[1.0]], 0, 0.01)  # 1/(1 - 0.6) at rest
    >>> value, omega = pl.peak_gain(lag)
    >>> round(value, 6), omega
    (2.5, 0.0)
    """
    _stable(system)

    def negative_gain(omega):
        return -np.linalg.norm(frequency_response(system, omega), 2, axis=(1, 2))

    omega = frequency_grid(system.dt, points, eigenvalues=np.linalg.eigvals(system.A))
    value, where = least(negative_gain, np.append(0.0, omega))
    return -value, where


def _stable(system):
    state_space("system", system, sampled=True)
    largest = np.abs(np.linalg.eigvals(system.A)).max()
    if largest >= 1:
        raise ValueError(
            f"system: no lasting RMS value or gain exists, found an eigenvalue of magnitude "
            f"{largest:.6f}; the closed loop must be stable."
        )
