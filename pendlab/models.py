"""Continuous models of a rig: nonlinear, linear near upright, and linear with the filters.

The state is x = [relative angles, relative rates]: theta1, theta2 - theta1, ..., and their
derivatives; the outputs are the relative angles and the rate of the lowest link.
"""

import control
import numpy as np

from ._arguments import array, instance, numbers, state_space
from .lagrange import derive
from .parameters import Filters, Pendulum


def equations(rig):
    """The `EquationsOfMotion` for `rig` and its parameter values."""
    instance("rig", rig, Pendulum, 'pl.load("double")')
    motion = derive(rig.n_links, rig.n_motors)
    return motion, motion.values(rig)


def matrices(rig):
    """W, M, N, P, H of the linear equations (ii) and (iii) for `rig`, as arrays."""
    motion, values = equations(rig)
    return [np.asarray(matrix, dtype=float) for matrix in motion.linear(*values)]


def linearize(rig):
    """Linear model near upright, equation (1) or (2).

    dx/dt = [[0, I], [-W M^-1 P W^-1, -W M^-1 N W^-1]] x + [[0], [-W M^-1 H]] u

    A control.StateSpace with 2n states (rad, rad/s), m inputs (V) and n + 1 outputs (rad, rad/s)
    for a `Pendulum` with n links and m motors. Source: Appendix A, equations (ii) and (iii).

    >>> np.sort(np.linalg.eigvals(pl.linearize(pl.load("double")).A).real).round(2).tolist()
    [-165.34, -4.94, 0.09, 4.74]
    """
    W, M, N, P, H = matrices(rig)
    n, m = rig.n_links, rig.n_motors
    if not np.linalg.cond(M) < 1e15:
        raise ValueError(
            "rig: its mass matrix is singular to working precision; bring masses, lengths and "
            "inertias (in kg, m and kg m^2) closer together."
        )
    W_inverse = np.linalg.inv(W)
    A21, A22, B2 = (-W @ np.linalg.solve(M, right) for right in (P @ W_inverse, N @ W_inverse, H))
    A = np.block([[np.zeros((n, n)), np.eye(n)], [A21, A22]]) + 0.0
    B = np.vstack([np.zeros((n, m)), B2])
    states = angle_names(n) + [f"d{name}" for name in angle_names(n)]
    labels = dict(states=states, inputs=[f"u{i + 1}" for i in range(m)], outputs=states[: n + 1])
    name = rig.name.replace(".", "_")  # python-control takes no dots
    return control.ss(A, B, np.eye(n + 1, 2 * n), 0, name=name, **labels)


def derived(model, A, B, C, D, *, name, dt=None, more=(), inputs=None):
    """A model built on `model`: its names kept, those of `more` states made unique."""
    if not all(np.isfinite(part).all() for part in (A, B, C)):
        raise ValueError(f"model: the result {name!r} is not finite; use smaller numbers.")
    states = list(model.state_labels)
    for label in more:
        count = sum(known == label or known.startswith(f"{label} ") for known in states)
        states.append(f"{label} {count + 1}" if count else label)
    labels = dict(inputs=inputs or model.input_labels, outputs=model.output_labels, states=states)
    return control.ss(A, B, C, D, model.dt if dt is None else dt, name=name, **labels)


def angle_names(n):
    """Names of the relative angles: theta1, theta2-theta1, ..."""
    return ["theta1"] + [f"theta{i + 1}-theta{i}" for i in range(1, n)]


def nonlinear(rig):
    """Nonlinear model f(x, u) -> dx/dt, valid at any angle; gears rigid, no limits.

    M(theta) dv/dt + bias(theta, v) + H u = 0 in absolute angles theta = W^-1 [x1, ..., xn], with
    the 2n states x of `linearize` (rad, rad/s) and the m voltages u (V).

    >>> pl.nonlinear(pl.load("double"))([0, 0, 0, 0], [0])  # upright is an equilibrium
    array([0., 0., 0., 0.])
    """
    motion, values = equations(rig)
    n, m = rig.n_links, rig.n_motors
    W, *_, H = matrices(rig)

    def f(x, u):
        x, u = array("x", x, (2 * n,)), array("u", u, (m,))
        q, v = np.cumsum(x[:n]), np.cumsum(x[n:])  # absolute: running sums of relative
        mass_matrix, bias = motion.nonlinear(q, v, values)
        acceleration = np.linalg.solve(mass_matrix, -np.asarray(bias)[:, 0] - H @ u)
        return np.concatenate([x[n:], W @ acceleration]) + 0.0

    return f


def energy(rig, x):
    """Kinetic plus potential energy (J) of `rig` at the state x, zero at the lowest hinge.

    >>> round(pl.energy(pl.load("double"), [0, 0, 0, 0]), 3)  # upright
    2.943
    """
    motion, values = equations(rig)
    q, v = np.split(array("x", x, (2 * rig.n_links,)), 2)
    return float(motion.total_energy(np.cumsum(q), np.cumsum(v), values))


def with_filters(plant, filters):
    """Plant with a first-order filter on every input and every measured output.

    dz/dt = w_c (r - z), w_c = 2 pi f_c, for each input r = u and each output r = y. The m + p more
    states follow x: [x, filtered inputs, filtered outputs]; inputs and outputs keep their names.
    `plant` is continuous with m inputs and p outputs; `filters` has their cut-offs f_c (Table 5).

    >>> rig = pl.load("double")
    >>> pl.with_filters(pl.linearize(rig), rig.filters).nstates
    8
    """
    state_space("plant", plant, sampled=False)
    instance("filters", filters, Filters, "rig.filters")
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
    B = np.vstack([np.zeros((n, m)), w_in, np.zeros((p, m))])
    C = np.eye(p, n + m + p, k=n + m)
    more = [f"filtered {name}" for name in plant.input_labels + plant.output_labels]
    return derived(plant, A, B, C, np.zeros((p, m)), name=f"{plant.name} with filters", more=more)
