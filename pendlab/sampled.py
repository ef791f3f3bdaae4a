"""The sampled plant that the controller sees: zero-order hold, aligned last link, integrator."""

import numpy as np
from scipy.signal import cont2discrete

from ._arguments import found, number, state_space, whole
from .models import derived


def sample(plant, dt=0.01, delay=0.0):
    """Zero-order-hold model of `plant` at the sampling time `dt` (s), equations (13) and (14).

    x(n+1) = e^(A dt) x(n) + (integral of e^(A s) ds from 0 to dt) B u(n)

    `plant` is a continuous control.StateSpace, whose names are kept. With a `delay` (s, at most dt)
    from reading to sending the old voltage u(n-1) holds for so long; it joins the state, last.

    >>> from control import ss
    >>> pl.sample(ss([[0, 1], [0, 0]], [[0], [1]], [[1, 0]], 0), 0.5).A
    array([[1. , 0.5],
           [0. , 1. ]])
    """
    state_space("plant", plant, sampled=False)
    number("dt", dt, above=0)
    if number("delay", delay, least=0) > dt:
        raise ValueError(f"delay: expected at most the sampling time of {dt:g} s, {found(delay)}.")
    fastest = np.abs(np.linalg.eigvals(plant.A)).max() * dt
    if fastest > 700 or not np.linalg.norm(plant.A) * dt < 1e6:
        raise ValueError(
            f"dt: {dt:g} s is {fastest:.3g} times the fastest time constant of the plant, too long "
            "for a sampled model; sample faster."
        )
    # First `delay` under the old voltage, then the rest of the sample under the new one.
    system = plant.A, plant.B, plant.C, plant.D
    (A1, B1), (A2, B2) = (cont2discrete(system, part)[:2] for part in (delay, dt - delay))
    n, m = B1.shape
    old = m if delay else 0
    A = np.block([[A2 @ A1, A2 @ B1[:, :old]], [np.zeros((old, n + old))]])
    B = np.vstack([B2, np.eye(old, m)])
    C = np.hstack([plant.C, np.zeros((plant.noutputs, old))])
    more = [f"old {name}" for name in plant.input_labels[:old]]
    return derived(plant, A, B, C, plant.D, name=plant.name, dt=dt, more=more)


def align(model, kp):
    """`model` with its last motor holding the last link in line, equations (18) and (19).

    u2 = -k_p (theta3 - theta2), so A becomes A - B2 k_p C_p C and the last input is gone. Motor i
    drives hinge i+1, so the angle of the last motor's hinge is output number m counted from 0.
    `model` has at least two inputs and is continuous or sampled; `kp` is in V/rad.

    >>> pl.align(pl.sample(pl.linearize(pl.load("triple"))), kp=10).input_labels
    ['u1']
    """
    state_space("model", model)
    if model.ninputs < 2:
        raise ValueError(
            f"model: aligning takes the last of at least 2 inputs, found {model.ninputs}; "
            "a rig with one motor needs no alignment."
        )
    if model.noutputs <= model.ninputs:
        raise ValueError(
            f"model: expected the angle of every hinge among the outputs, found {model.noutputs} "
            f"outputs for {model.ninputs} inputs; use pl.linearize or pl.sample of it."
        )
    A = model.A - number("kp", kp) * np.outer(model.B[:, -1], model.C[model.ninputs])
    B, D, inputs = model.B[:, :-1], model.D[:, :-1], model.input_labels[:-1]
    return derived(model, A, B, model.C, D, name=f"{model.name} aligned", inputs=inputs)


def add_integrator(model, output):
    """`model` with the integrated tracking error of `output` as the last state, equation (15).

    w(n+1) = w(n) + Ts (y_r(n) - y_2(n)), written here for y_r = 0. `output` is the index or name of
    the output that tracks a reference, or a list of them, each with its integrator.

    >>> pl.add_integrator(pl.sample(pl.linearize(pl.load("double"))), 1).state_labels[-1]
    'w'
    """
    state_space("model", model, sampled=True)
    outputs = output if isinstance(output, (list, tuple)) else [output]
    tracked = [_index(model.output_labels, one) for one in outputs]
    if len(set(tracked)) < len(tracked):
        raise ValueError(f"output: each output takes one integrator, {found(output)}.")
    n, count, C, D = model.nstates, len(tracked), model.C, model.D
    A = np.block([[model.A, np.zeros((n, count))], [-model.dt * C[tracked], np.eye(count)]])
    B = np.vstack([model.B, -model.dt * D[tracked]])
    C = np.hstack([C, np.zeros((model.noutputs, count))])
    more = ["w"] if count == 1 else [f"w{i + 1}" for i in range(count)]
    return derived(model, A, B, C, D, name=f"{model.name} with integrator", more=more)


def _index(labels, output):
    """The index of an output that is given by its index or by its name."""
    if isinstance(output, str) and output in labels:
        return labels.index(output)
    try:
        return whole("output", output, most=len(labels) - 1)
    except ValueError:
        known = f"an index from 0 to {len(labels) - 1} or one of {', '.join(labels)}"
        raise ValueError(f"output: expected {known}, {found(output)}.") from None
