"""The sampled plant that the controller sees: zero-order hold, aligned upper link, integrator."""

import control
import numpy as np

from ._arguments import found, number, state_space


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
    """
    state_space("plant", plant)
    number("dt", dt, above=0)
    if number("delay", delay, least=0) > dt:
        raise ValueError(f"delay: expected at most the sampling time of {dt:g} s, {found(delay)}.")
    if plant.dt != 0:
        raise ValueError(
            f"plant: expected a continuous model, found one already sampled at {plant.dt} s; "
            "sample once, from pl.linearize or pl.with_filters."
        )
    if delay == 0:
        return control.sample_system(plant, dt, method="zoh", copy_names=True, name=plant.name)
    early, late = (control.sample_system(plant, t, method="zoh") for t in (delay, dt - delay))
    n, m = plant.nstates, plant.ninputs
    # First `delay` under the old voltage, then the rest of the sample under the new one.
    old, new = late.A @ early.B, late.B
    return control.ss(
        np.block([[late.A @ early.A, old], [np.zeros((m, n + m))]]),
        np.vstack([new, np.eye(m)]),
        np.hstack([plant.C, np.zeros((plant.noutputs, m))]),
        plant.D,
        dt,
        states=plant.state_labels + [f"old {name}" for name in plant.input_labels],
        inputs=plant.input_labels,
        outputs=plant.output_labels,
        name=plant.name,
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
    upper = model.C[model.ninputs]
    return control.ss(
        model.A - kp * np.outer(model.B[:, -1], upper),
        model.B[:, :-1],
        model.C,
        model.D[:, :-1],
        model.dt,
        states=model.state_labels,
        inputs=model.input_labels[:-1],
        outputs=model.output_labels,
        name=f"{model.name} aligned",
    )


def alignment_interval(model):
    """Gains k_p between which alignment leaves the fewest unstable eigenvalues: (lower, upper).

    The ends are where an eigenvalue of A - B2 k_p C_p C meets the unit circle (or the imaginary
    axis), found by counting over a grid of k_p from 1e-3 to 1e4 V/rad and bisection.

    Parameters
    ----------
    model : control.StateSpace with at least two inputs, as for `align`
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
    """
    state_space("model", model)
    if not model.dt > 0:
        raise ValueError(
            "model: the integrator is a sampled one, found a continuous model; use pl.sample first."
        )
    tracked = output_indices(model, output)
    if len(set(tracked)) < len(tracked):
        raise ValueError(f"output: each output takes one integrator, {found(output)}.")
    n, count = model.nstates, len(tracked)
    names = ["w"] if count == 1 else [f"w{i + 1}" for i in range(count)]
    return control.ss(
        np.block([[model.A, np.zeros((n, count))], [-model.dt * model.C[tracked], np.eye(count)]]),
        np.vstack([model.B, -model.dt * model.D[tracked]]),
        np.hstack([model.C, np.zeros((model.noutputs, count))]),
        model.D,
        model.dt,
        states=model.state_labels + names,
        inputs=model.input_labels,
        outputs=model.output_labels,
        name=f"{model.name} with integrator",
    )


def output_indices(model, output):
    """Indices of the outputs named by `output`: an index, a name, or a list of them."""
    wanted = output if isinstance(output, (list, tuple)) else [output]
    labels = model.output_labels
    indices = []
    for item in wanted:
        if item in labels:
            indices.append(labels.index(item))
        elif isinstance(item, (int, np.integer)) and 0 <= item < len(labels):
            indices.append(int(item))
        else:
            raise ValueError(
                f"output: expected an index from 0 to {len(labels) - 1} or one of "
                f"{', '.join(labels)}, {found(item)}."
            )
    return indices
