"""Continuous models of a rig: nonlinear, linear near upright, and linear with the filters.

The state is x = [relative angles, relative rates]: theta1, theta2 - theta1, ..., and their
derivatives; the outputs are the relative angles and the rate of the lowest link.
"""

import control
import numpy as np

from ._arguments import array, found, numbers, state_space
from .lagrange import derive
from .parameters import Filters, Pendulum


def equations(rig):
    """The `EquationsOfMotion` for `rig` and its parameter values."""
    if not isinstance(rig, Pendulum):
        raise TypeError(f'rig: expected a pl.Pendulum such as pl.load("double"), {found(rig)}.')
    motion = derive(rig.n_links, rig.n_motors)
    return motion, motion.values(rig)


def linearize(rig):
    """Linear model near upright, equation (1) or (2).

    dx/dt = [[0, I], [-W M^-1 P W^-1, -W M^-1 N W^-1]] x + [[0], [-W M^-1 H]] u

    Parameters
    ----------
    rig : Pendulum with n links and m motors

    Returns
    -------
    control.StateSpace : 2n states (rad, rad/s), m inputs (V), n + 1 outputs (rad, rad/s)

    References
    ----------
    Appendix A, equations (ii) and (iii).
    """
    motion, values = equations(rig)
    W, M, N, P, H = (np.asarray(matrix, dtype=float) for matrix in motion.linear(*values))
    n, m = rig.n_links, rig.n_motors
    W_inverse = np.linalg.inv(W)
    A21, A22, B2 = (-W @ np.linalg.solve(M, right) for right in (P @ W_inverse, N @ W_inverse, H))
    A = np.block([[np.zeros((n, n)), np.eye(n)], [A21, A22]]) + 0.0
    B = np.vstack([np.zeros((n, m)), B2])
    C = np.eye(n + 1, 2 * n)
    angles = angle_names(n)
    rates = [f"d{name}" for name in angles]
    return control.ss(
        A,
        B,
        C,
        np.zeros((n + 1, m)),
        states=angles + rates,
        inputs=[f"u{i + 1}" for i in range(m)],
        outputs=angles + rates[:1],
        name=rig.name,
    )


def angle_names(n):
    """Names of the relative angles: theta1, theta2-theta1, ..."""
    return ["theta1"] + [f"theta{i + 1}-theta{i}" for i in range(1, n)]


def nonlinear(rig):
    """Nonlinear model f(x, u) -> dx/dt, valid at any angle; gears rigid, no limits.

    M(theta) dv/dt + bias(theta, v) + H u = 0 in absolute angles theta = W^-1 [x1, ..., xn].

    Parameters
    ----------
    rig : Pendulum with n links and m motors

    Returns
    -------
    function of x, 2n entries (rad, rad/s), and u, m entries (V), that returns dx/dt
    """
    motion, values = equations(rig)
    n, m = rig.n_links, rig.n_motors
    W, *_, H = (np.asarray(matrix, dtype=float) for matrix in motion.linear(*values))
    evaluate = motion.nonlinear

    def f(x, u):
        x, u = array("x", x, (2 * n,)), array("u", np.atleast_1d(u), (m,))
        q, v = np.cumsum(x[:n]), np.cumsum(x[n:])  # absolute: running sums of relative
        mass_matrix, bias = evaluate(q, v, values)
        acceleration = np.linalg.solve(mass_matrix, -np.asarray(bias)[:, 0] - H @ u)
        return np.concatenate([x[n:], W @ acceleration])

    return f


def energy(rig, x):
    """Kinetic plus potential energy (J) of `rig` at the state x, zero at the lowest hinge."""
    motion, values = equations(rig)
    n = rig.n_links
    x = array("x", x, (2 * n,))
    return float(motion.total_energy(np.cumsum(x[:n]), np.cumsum(x[n:]), values))


def with_filters(plant, filters):
    """Plant with a first-order filter on every input and every measured output.

    dz/dt = w_c (r - z), w_c = 2 pi f_c, for each input r = u and each output r = y. The state is
    [x, filtered inputs, filtered outputs]; inputs and outputs keep their names.

    Parameters
    ----------
    plant : continuous control.StateSpace with m inputs and p outputs, D = 0
    filters : Filters with m input and p output cut-offs, Hz (Table 5)

    Returns
    -------
    control.StateSpace with m + p more states
    """
    if state_space("plant", plant).dt != 0:
        raise ValueError(
            f"plant: filters belong to the continuous model, found one sampled at {plant.dt} s; "
            "append the filters first, then sample."
        )
    if not isinstance(filters, Filters):
        raise TypeError(f"filters: expected pl.Filters such as rig.filters, {found(filters)}.")
    n, m, p = plant.nstates, plant.ninputs, plant.noutputs
    w_in = np.diag(2 * np.pi * np.array(numbers("filters.input_hz", filters.input_hz, count=m)))
    w_out = np.diag(2 * np.pi * np.array(numbers("filters.output_hz", filters.output_hz, count=p)))
    A = np.block(
        [
            [plant.A, plant.B, np.zeros((n, p))],
            [np.zeros((m, n)), -w_in, np.zeros((m, p))],
            [w_out @ plant.C, w_out @ plant.D, -w_out],
        ]
    )
    return control.ss(
        A,
        np.vstack([np.zeros((n, m)), w_in, np.zeros((p, m))]),
        np.hstack([np.zeros((p, n + m)), np.eye(p)]),
        np.zeros((p, m)),
        states=plant.state_labels
        + [f"filtered {name}" for name in plant.input_labels + plant.output_labels],
        inputs=plant.input_labels,
        outputs=plant.output_labels,
        name=f"{plant.name} with filters",
    )
