"""The rig in software: a continuous nonlinear pendulum under a sampled controller (section 5)."""

from dataclasses import dataclass

import numpy as np

from .._arguments import array, found, instance
from ..controllers import Controller
from ..parameters import Pendulum
from .imperfections import Imperfections
from .inputs import (
    called,
    disturbance_rows,
    initial_state,
    reference_rows,
    sample_times,
    sampling_time,
    voltages,
)
from .plant import bench_tuples, integration, pack
from .tuples import Law, Memory, Rows

PATIENCE = 200_000  # integration steps, some 0.1 s: an interrupt is heard after as many


@dataclass(frozen=True)
class Run:
    """What happened, one row per sample.

    Attributes
    ----------
    t : s
    angles, rates : true relative angles (rad) and rates (rad/s), n columns
    u : voltages sent to the motors, V: after the program's limits, D/A resolution and the amplifiers'
        limits (what each amplifier gives once its filter has settled)
    y : the controller's readings: n relative angles and the lowest link's rate
    estimate : the controller's xhat, 2n columns, or None for a controller without `estimate`
    y_ref : reference, one column per tracked output
    fell_at : time at which a link passed the horizontal, s, or None; the run ends there
    rig, imperfections, dt : what was simulated, sampling time in s
    inner_step : of the integration, s
    """

    t: np.ndarray
    angles: np.ndarray
    rates: np.ndarray
    u: np.ndarray
    y: np.ndarray
    estimate: np.ndarray | None
    y_ref: np.ndarray
    fell_at: float | None
    rig: Pendulum
    imperfections: Imperfections
    dt: float
    inner_step: float

    @property
    def fell(self):
        return self.fell_at is not None

    @property
    def theta(self):
        """Absolute angles of the links from upright, rad."""
        return np.cumsum(self.angles, axis=1)

    @property
    def saturated(self):
        """For each motor, the fraction of samples with its voltage at ``rig.u_max``."""
        return (np.abs(self.u) >= np.array(self.rig.u_max) * (1 - 1e-9)).mean(axis=0)


def simulate(
    rig,
    controller,
    t_end,
    initial=None,
    reference=0.0,
    *,
    imperfections=None,
    disturbance=None,
    dt=None,
    inner_step=None,
):
    """Simulate `rig` under `controller` from 0 to `t_end`.

    At each sample, in the paper's order: read (filters, errors, A/D), estimate, control, limit (the
    program's own ``controller.u_max``), send (D/A, delay), update. Between samples the D/A's voltage
    passes the motor filter, then the amplifier with its limits (Fig 4), and the nonlinear equations
    of motion are integrated by classical Runge-Kutta steps of fixed size. Equal calls give equal results.

    Parameters
    ----------
    rig : Pendulum with n links and m motors
    controller : `Controller`, or any object with ``step(state, y, y_ref) -> (u, next state)`` and,
        if it has a state to begin with, ``start(x0)``; ``estimate(state, y)`` is recorded if there.
        x0 is read at the first sample: measured angles, and the initial rates
    t_end : s
    initial : n relative angles (rad, at rest) or those and n relative rates (rad/s); default upright
    reference : y_r, rad: a number, one value (or row) per sample, or a function of t
    imperfections : `Imperfections`; default none
    disturbance : `Pulse`, a list of them, or a function of t that gives the torques on the n links,
        N m, held over each sample
    dt : sampling time, s; default ``controller.dt``, else 0.01
    inner_step : largest integration step, s; default from the fastest motion of the plant

    The `Run` holds samples 0, dt, 2 dt, ... up to t_end, or up to a fall. ValueError for arguments
    that do not fit, for an inner step that is too coarse, or so fine that the run would not end, and,
    named with the time, for a controller or function that fails.

    The paper's double is led to a relative angle of 0.05 rad; its integrator takes 10 s.

    >>> design = pl.paper_design("double")
    >>> run = pl.simulate(design.rig, design.controller, 60.0, reference=0.05)
    >>> print(run.fell, run.angles[-1, 1].round(3))
    False 0.05
    """
    imperfections = Imperfections() if imperfections is None else imperfections
    _kinds(rig, controller, imperfections)
    n, ours = rig.n_links, type(controller) is Controller
    dt = sampling_time(controller, dt)
    t = sample_times(t_end, dt)
    if ours:
        _fits(controller, rig)
    x0 = initial_state(initial, n)
    y_ref = reference_rows(reference, t, len(controller.tracked) if ours else None)
    loads = disturbance_rows(disturbance, t, n)
    clock = integration(rig, imperfections, dt, len(t), inner_step)
    bench = bench_tuples(rig, imperfections, x0, loads, clock, len(t))
    run = _run_ours if ours else _run_any
    first = _first_estimate(bench, x0)
    done, fell, X, y, u, estimate = run(bench, controller, y_ref, first)
    if not (np.isfinite(y[:done]).all() and np.isfinite(u[:done]).all()):
        raise ValueError(
            "simulate: readings or voltages grew beyond all numbers; look for a huge value in "
            "initial, reference, imperfections or the controller."
        )
    return Run(
        t[:done], X[:done, :n], X[:done, n:], u[:done], y[:done],
        None if estimate is None else estimate[:done], y_ref[:done],
        fell if fell >= 0 else None, rig, imperfections, dt, dt / clock.steps,
    )  # fmt: skip


def _run_ours(bench, controller, y_ref, first):
    """The whole loop inside the kernel, with the arithmetic of `Controller.step`."""
    kernel, clock, held, ports = bench.kernel, bench.clock, bench.held, bench.ports
    start, o = controller.start(first), controller.observer
    m, n, count = kernel.M, kernel.N, len(y_ref)
    u_max = np.full(m, np.inf) if controller.u_max is None else np.array(controller.u_max)
    matrices = [np.ascontiguousarray(a) for a in (o.E, o.H, o.K, o.L1, o.L2, controller.F)]
    law = pack(kernel, Law(*matrices, np.array(controller.tracked, dtype=np.int64), u_max))
    memory = pack(kernel, Memory(start.v.copy(), start.w.copy(), np.zeros(len(o.E))))
    rows = pack(kernel, Rows(*(np.zeros((count, k)) for k in (2 * n, n + 1, m, 2 * n))))
    y_ref, fell, done = pack(kernel, y_ref), -1.0, 0
    stretch = max(1, PATIENCE // clock.steps)
    while done < count and fell < 0:
        if done > 0:  # from the last sample of the stretch before
            t, loads = (done - 1) * clock.dt, held[(done - 1) % len(held)]
            fell = kernel.hold(bench.state, t, clock, bench.plant, loads, bench.work)
            if fell >= 0:
                break
        part = slice(done, done + stretch)
        more, fell = kernel.run(
            bench.state,
            memory,
            law,
            y_ref[part],
            clock._replace(first=done),
            bench.plant,
            held[part] if len(held) > 1 else held,
            ports._replace(error=ports.error[part]),
            bench.work,
            Rows(*(record[part] for record in rows)),
        )
        done += more
    return done, fell, *(np.asarray(record) for record in rows)


def _run_any(bench, controller, y_ref, first):
    """Sample by sample, with any controller that has `step`."""
    kernel, clock, ports, count = bench.kernel, bench.clock, bench.ports, len(y_ref)
    n, m, x = kernel.N, kernel.M, bench.state.x
    X, y, u = (np.zeros((count, k)) for k in (2 * n, n + 1, m))
    estimate = [] if callable(getattr(controller, "estimate", None)) else None
    reading, volts = (pack(kernel, np.zeros(k)) for k in (n + 1, m))
    state, fell = None, -1.0
    if callable(getattr(controller, "start", None)):
        state = called("controller: start", 0.0, controller.start, first)
    for k in range(count):
        t = k * clock.dt
        X[k] = _relative(np.asarray(x[: 2 * n]), n)
        kernel.read(x, ports.error[k], ports.ad, bench.plant.w_out, reading)
        y[k] = reading
        if estimate is not None:
            estimate.append(_estimate(controller, state, y[k].copy(), t))
        target = float(y_ref[k, 0]) if y_ref.shape[1] == 1 else y_ref[k].copy()
        answer = called("controller: step", t, controller.step, state, y[k].copy(), target)
        volts[:], state = voltages(answer, m, t)
        kernel.send(volts, bench.state.sent, ports.da, bench.plant.limit)
        u[k] = volts
        if k + 1 < count:
            loads = bench.held[k % len(bench.held)]
            fell = kernel.hold(bench.state, t, clock, bench.plant, loads, bench.work)
            if fell >= 0:
                break
    return k + 1, fell, X, y, u, None if estimate is None else np.array(estimate)


def _estimate(controller, state, y, t):
    value = called("controller: estimate", t, controller.estimate, state, y)
    return array(f"controller: estimate at t = {t:.4g} s", value, (2 * (len(y) - 1),))


def _relative(absolute, n):
    return np.concatenate([np.diff(absolute[:n], prepend=0.0), np.diff(absolute[n:], prepend=0.0)])


def _first_estimate(bench, x0):
    """x(0) as the bench knows it: the angles that its sensors read, and the rates it starts with."""
    n, ports = bench.kernel.N, bench.ports
    y = pack(bench.kernel, np.zeros(n + 1))
    bench.kernel.read(bench.state.x, ports.error[0], ports.ad, bench.plant.w_out, y)
    return np.concatenate([np.asarray(y)[:n], x0[n:]])


def _kinds(rig, controller, imperfections):
    instance("rig", rig, Pendulum, 'pl.load("double")')
    instance("imperfections", imperfections, Imperfections)
    if isinstance(controller, type):
        raise TypeError(
            f"controller: expected an object, found the class {controller.__name__}; "
            f"make one first: {controller.__name__}(...)."
        )
    if not callable(getattr(controller, "step", None)):
        raise TypeError(
            f"controller: expected an object with step(state, y, y_ref), {found(controller)}; "
            "see pl.controller."
        )


def _fits(controller, rig):
    o, n, m = controller.observer, rig.n_links, rig.n_motors
    have = (o.L1.shape[0], o.K.shape[1], len(controller.F))
    if have != (2 * n, n + 1, m):
        raise ValueError(
            f"controller: the rig has {2 * n} states, {n + 1} outputs and {m} motors, found a "
            f"controller for {have[0]}, {have[1]} and {have[2]}; design it for this rig."
        )
