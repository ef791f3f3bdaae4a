"""The sampled plant that the controller sees: zero-order hold, aligned upper link, integrator."""

import control
import numpy as np

from ._arguments import found, number, state_space
from .models import derived


def sample(plant, dt=0.01, delay=0.0):
    """Zero-order-hold model of `plant` at the sampling time `dt` (s), equations (13) and (14).

    x(n+1) = e^(A dt) x(n) + (integral of e^(A s) ds from 0 to dt) B u(n)

    With a computation delay the old voltage u(n-1) holds until `delay` after the sample; it joins
    the state, last.

    Parameters
    ----------
    plant : continuous control.StateSpace
    dt : sampling time, s, above 0
    delay : from reading to sending, s, at least 0 and at most dt

    Returns
    -------
    control.StateSpace with ``.dt`` = dt and the names of `plant`

    Raises
    ------
    ValueError : dt not above 0, delay outside 0 to dt, or a plant that is sampled already

    >>> sample(control.ss([[0, 1], [0, 0]], [[0], [1]], [[1, 0]], 0), 0.5).A
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
    n, m, name = plant.nstates, plant.ninputs, plant.name
    new = control.sample_system(plant, dt - delay, method="zoh") if delay < dt else None
    if delay == 0:
        return derived(plant, new.A, new.B, plant.C, plant.D, name=name, dt=dt)
    early = control.sample_system(plant, delay, method="zoh")
    # First `delay` under the old voltage, then the rest of the sample under the new one.
    late = (new.A, new.B) if new else (np.eye(n), np.zeros((n, m)))
    return derived(
        plant,
        np.block([[late[0] @ early.A, late[0] @ early.B], [np.zeros((m, n + m))]]),
        np.vstack([late[1], np.eye(m)]),
        np.hstack([plant.C, np.zeros((plant.noutputs, m))]),
        plant.D,
        name=name,
        dt=dt,
        more=[f"old {name}" for name in plant.input_labels],
    )


def align(model, kp):
    """`model` with its last motor holding the upper link in line, equations (18) and (19).

    u2 = -k_p (theta3 - theta2), so A becomes A - B2 k_p C_p C and the last input is gone. Motor i
    drives hinge i+1, so the angle of the last motor's hinge is output number m counted from 0.

    Parameters
    ----------
    model : control.StateSpace with at least two inputs, continuous or sampled
    kp : position gain k_p, V/rad

    Returns
    -------
    control.StateSpace with one input less

    >>> from pendlab import linearize, load
    >>> align(sample(linearize(load("triple"))), kp=10).input_labels
    ['u1']
    """
    state_space("model", model)
    kp = number("kp", kp)
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
    return derived(
        model,
        model.A - kp * np.outer(model.B[:, -1], model.C[model.ninputs]),
        model.B[:, :-1],
        model.C,
        model.D[:, :-1],
        name=f"{model.name} aligned",
        inputs=model.input_labels[:-1],
    )


def alignment_interval(model):
    """Gains k_p between which alignment leaves the fewest unstable eigenvalues: (lower, upper).

    The ends are where an eigenvalue of A - B2 k_p C_p C meets the unit circle (or the imaginary
    axis), found by counting over a grid of k_p from 1e-3 to 1e4 V/rad and bisection.

    Parameters
    ----------
    model : control.StateSpace with at least two inputs, as for `align`

    >>> from pendlab import linearize, load
    >>> [round(kp, 3) for kp in alignment_interval(sample(linearize(load("triple"))))]
    [0.785, 72.36]
    """

    def unstable(kp):
        values = np.linalg.eigvals(align(model, kp).A)
        return int(np.sum(np.abs(values) > 1 if model.dt else values.real > 0))

    def change(low, high):
        """The gain between `low` and `high` where the count leaves that of `low`."""
        count = unstable(low)
        while high - low > 1e-10 * high:
            middle = (low + high) / 2
            low, high = (middle, high) if unstable(middle) == count else (low, middle)
        return (low + high) / 2

    gains = np.geomspace(1e-3, 1e4, 141)
    counts = np.array([unstable(kp) for kp in gains])
    best = np.flatnonzero(counts == counts.min())
    first, last = best[0], best[0] + np.argmax(np.append(np.diff(best) > 1, True))
    lower = 0.0 if first == 0 else change(gains[first - 1], gains[first])
    upper = np.inf if last == len(gains) - 1 else change(gains[last], gains[last + 1])
    return float(lower), float(upper)


def add_integrator(model, output):
    """`model` with the integrated tracking error of `output` as the last state, equation (15).

    w(n+1) = w(n) + Ts (y_r(n) - y_2(n)), written here for y_r = 0.

    Parameters
    ----------
    model : sampled control.StateSpace
    output : index or name of the output that tracks a reference, or a list of them (one
        integrator each)

    Returns
    -------
    control.StateSpace with the integrators' states last, same inputs and outputs

    >>> from pendlab import linearize, load
    >>> add_integrator(sample(linearize(load("double"))), 1).state_labels[-1]
    'w'
    """
    state_space("model", model, sampled=True)
    tracked = output_indices(model, output)
    if len(set(tracked)) < len(tracked):
        raise ValueError(f"output: each output takes one integrator, {found(output)}.")
    n, count = model.nstates, len(tracked)
    return derived(
        model,
        np.block([[model.A, np.zeros((n, count))], [-model.dt * model.C[tracked], np.eye(count)]]),
        np.vstack([model.B, -model.dt * model.D[tracked]]),
        np.hstack([model.C, np.zeros((model.noutputs, count))]),
        model.D,
        name=f"{model.name} with integrator",
        more=["w"] if count == 1 else [f"w{i + 1}" for i in range(count)],
    )


def output_indices(model, output):
    """Indices of the outputs named by `output`: an index, a name, or a list of them."""
    wanted = output if isinstance(output, (list, tuple)) else [output]
    labels = model.output_labels
    indices = []
    for item in wanted:
        if isinstance(item, str) and item in labels:
            indices.append(labels.index(item))
        elif (
            isinstance(item, (int, np.integer))
            and not isinstance(item, bool)
            and 0 <= item < len(labels)
        ):
            indices.append(int(item))
        else:
            raise ValueError(
                f"output: expected an index from 0 to {len(labels) - 1} or one of "
                f"{', '.join(labels)}, {found(item)}."
            )
    return indices
