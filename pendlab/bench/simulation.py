"""The rig in software: a continuous nonlinear pendulum under a sampled controller (section 5)."""

from dataclasses import dataclass

import numpy as np

from .._arguments import array, found, number, whole
from ..controllers import Controller
from ..parameters import Pendulum
from .generated import load_kernel
from .imperfections import Imperfections, Pulse
from .plant import inner_steps, pack, plant_numbers


@dataclass(frozen=True)
class Run:
    """What happened, one row per sample.

    Attributes
    ----------
    t : s
    angles, rates : true relative angles (rad) and rates (rad/s), n columns
    u : voltages sent to the motors, V, after limits and D/A resolution
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
    imperfections=None,
    disturbance=None,
    dt=None,
    inner_step=None,
):
    """Simulate `rig` under `controller` from 0 to `t_end`.

    At each sample, in the paper's order: read (filters, errors, A/D), estimate, control, limit,
    send (limits, D/A, delay), update. Between samples the nonlinear equations of motion are
    integrated by classical Runge-Kutta steps of fixed size. Equal calls give equal results.

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

    Returns
    -------
    Run : samples 0, dt, 2 dt, ... up to t_end, or up to a fall

    Raises
    ------
    ValueError : arguments that do not fit; an inner step that is too coarse; a controller that
        fails, named with the time
    """
    if not isinstance(rig, Pendulum):
        raise TypeError(f'rig: expected a pl.Pendulum such as pl.load("double"), {found(rig)}.')
    if not callable(getattr(controller, "step", None)):
        raise TypeError(
            f"controller: expected an object with step(state, y, y_ref), {found(controller)}; "
            "see pl.controller."
        )
    imperfections = Imperfections() if imperfections is None else imperfections
    if not isinstance(imperfections, Imperfections):
        raise TypeError(f"imperfections: expected pl.Imperfections, {found(imperfections)}.")
    n, m = rig.n_links, rig.n_motors
    dt = _sampling_time(controller, dt)
    if imperfections.delay > dt:
        raise ValueError(
            f"delay: expected at most the sampling time of {dt:g} s, {found(imperfections.delay)}."
        )
    if inner_step is not None:
        number("inner_step", inner_step, above=0)
    rows = int(number("t_end", t_end, least=0) / dt + 1e-9) + 1
    compiled = type(controller) is Controller
    if compiled:
        _fits(controller, n, m)
    t = dt * np.arange(rows)
    x0 = _initial(initial, n)
    y_ref = _reference(reference, t, len(controller.tracked) if compiled else None)
    pulses, held = _disturbance(disturbance, t, n)

    kernel = load_kernel(n, m)
    late, steps = inner_steps(rig, imperfections, dt, inner_step)
    plant = _Bench(kernel, rig, imperfections, x0, dt, late, steps, pulses, held, rows)
    if compiled:
        record = _run_compiled(plant, controller, y_ref, rows)
    else:
        record = _run_stepwise(plant, controller, y_ref, rows)
    done, fell, X, y, u, estimate = record
    return Run(
        t[:done], X[:done, :n], X[:done, n:], u[:done], y[:done],
        None if estimate is None else estimate[:done], y_ref[:done],
        fell if fell >= 0 else None, rig, imperfections, dt, dt / steps,
    )  # fmt: skip


class _Bench:
    """State and settings of one run in the form that the kernel takes."""

    def __init__(self, kernel, rig, imperfections, x0, dt, late, steps, pulses, held, rows):
        n, m = rig.n_links, rig.n_motors
        numbers = plant_numbers(rig, imperfections)
        self.kernel, self.n, self.m = kernel, n, m
        self.pack = lambda value: pack(kernel, value)
        self.x0 = x0
        joints = x0[1 : m + 1]
        rates = x0[n + 1 : n + m + 1]
        state = np.concatenate([np.cumsum(x0[:n]), np.cumsum(x0[n:]), joints, rates, x0[: n + 1]])
        anchor = np.concatenate([x0[:n], joints])  # dry contacts start without strain
        self.state = [self.pack(a) for a in (state, anchor, np.zeros(m), np.zeros(m))]
        noise = np.random.default_rng(imperfections.seed).standard_normal((rows, n + 1))
        error = imperfections.each("offset", n + 1) + imperfections.each("noise", n + 1) * noise
        limit = np.array(rig.u_max) if imperfections.saturation else np.full(m, np.inf)
        self.timing = (dt, imperfections.delay, steps, late)
        self.plant = [self.pack(value) for value in (*numbers, pulses)]
        self.held = self.pack(held)
        self.reading = [self.pack(a) for a in (error, imperfections.each("resolution", n + 1))]
        self.sending = [self.pack(a) for a in (limit, imperfections.each("voltage_resolution", m))]

    def work(self, least=0):
        return self.pack(np.zeros((13, max(3 * self.n + 2 * self.m + 1, least))))


def _run_compiled(bench, controller, y_ref, rows):
    """The whole loop inside the kernel, with the arithmetic of `Controller.step`."""
    n, m, kernel, pack_ = bench.n, bench.m, bench.kernel, bench.pack
    start = controller.start(_first_estimate(bench))
    o, unlimited = controller.observer, np.full(m, np.inf)
    u_max = unlimited if controller.u_max is None else np.array(controller.u_max)
    matrices = [np.ascontiguousarray(a) for a in (o.E, o.H, o.K, o.L1, o.L2, controller.F)]
    record = [pack_(np.zeros((rows, k))) for k in (2 * n, n + 1, m, 2 * n)]
    done, fell = kernel.run(
        *bench.state,
        pack_(start.v.copy()),
        pack_(start.w.copy()),
        *(pack_(a) for a in matrices),
        pack_(np.array(controller.tracked, dtype=np.int64)),
        pack_(u_max),
        pack_(y_ref),
        *bench.timing,
        *bench.plant,
        bench.held,
        *bench.reading,
        *bench.sending,
        bench.work(len(o.E)),
        *record,
    )
    X, y, u, estimate = (np.asarray(a) for a in record)
    return done, fell, X, y, u, estimate


def _run_stepwise(bench, controller, y_ref, rows):
    """Sample by sample, with any controller that has `step`."""
    n, m, kernel = bench.n, bench.m, bench.kernel
    X, y, u = np.zeros((rows, 2 * n)), np.zeros((rows, n + 1)), np.zeros((rows, m))
    estimate = [] if callable(getattr(controller, "estimate", None)) else None
    x, anchor, volts, before = bench.state
    error, ad = bench.reading
    limit, da = bench.sending
    w_out, work, buffer = bench.plant[5], bench.work(), bench.pack(np.zeros(n + 1))
    dt, delay, steps, late = bench.timing
    voltages = bench.pack(np.zeros(m))
    if callable(getattr(controller, "start", None)):
        state = _named(0.0, "start", controller.start, _first_estimate(bench))
    else:
        state = None
    for k in range(rows):
        t = k * dt
        X[k] = _relative(np.asarray(x[: 2 * n]), n)
        kernel.read(x, error[k], ad, w_out, buffer)
        y[k] = buffer
        if estimate is not None:
            estimate.append(_named(t, "estimate", controller.estimate, state, y[k].copy()))
        target = float(y_ref[k, 0]) if y_ref.shape[1] == 1 else y_ref[k].copy()
        answer = _named(t, "step", controller.step, state, y[k].copy(), target)
        voltages[:], state = _voltages(answer, m, t)
        kernel.send(voltages, limit, da)
        u[k] = voltages
        if k + 1 < rows:
            fell = kernel.hold(
                x,
                anchor,
                volts,
                before,
                voltages,
                t,
                dt,
                delay,
                steps,
                late,
                *bench.plant,
                bench.held[k % len(bench.held)],
                work,
            )
            if fell >= 0:
                break
    else:
        fell = -1.0
    return k + 1, fell, X, y, u, None if estimate is None else np.array(estimate)


def _relative(absolute, n):
    return np.concatenate([np.diff(absolute[:n], prepend=0.0), np.diff(absolute[n:], prepend=0.0)])


def _first_estimate(bench):
    """x(0) as the bench knows it: the angles that its sensors read, and the rates it starts with."""
    y = bench.pack(np.zeros(bench.n + 1))
    error, ad = bench.reading
    bench.kernel.read(bench.state[0], error[0], ad, bench.plant[5], y)
    return np.concatenate([np.asarray(y)[: bench.n], bench.x0[bench.n :]])


def _named(t, name, function, *arguments):
    """Call the controller; a failure is named with its time."""
    try:
        return function(*arguments)
    except Exception as problem:
        raise ValueError(
            f"controller: {name} failed at t = {t:.4g} s ({type(problem).__name__}: {problem})."
        ) from problem


def _voltages(answer, m, t):
    """(voltages, next state) from what `step` returned."""
    when = f"controller: step at t = {t:.4g} s"
    if not isinstance(answer, tuple) or len(answer) != 2:
        raise ValueError(f"{when} must return the pair (u, next state), {found(answer)}.")
    try:
        u = np.atleast_1d(np.asarray(answer[0], dtype=float))
    except (TypeError, ValueError) as problem:
        raise ValueError(f"{when} must return {m} voltages, {found(answer[0])}.") from problem
    if u.shape != (m,):
        raise ValueError(f"{when} must return {m} voltages, found shape {u.shape}.")
    if not np.all(np.isfinite(u)):
        raise ValueError(f"{when} returned {u}; every voltage must be finite.")
    return u, answer[1]


def _sampling_time(controller, dt):
    own = getattr(controller, "dt", None)
    if dt is None:
        dt = 0.01 if own is None else own
    number("dt", dt, above=0)
    if own is not None and abs(own - dt) > 1e-12:
        raise ValueError(f"dt: the controller is made for {own:g} s, {found(dt)}; leave dt out.")
    return float(dt)


def _fits(controller, n, m):
    o = controller.observer
    have = (o.L1.shape[0], o.K.shape[1], len(controller.F))
    if have != (2 * n, n + 1, m):
        raise ValueError(
            f"controller: the rig has {2 * n} states, {n + 1} outputs and {m} motors, found a "
            f"controller for {have[0]}, {have[1]} and {have[2]}; design it for this rig."
        )


def _initial(initial, n):
    """Relative angles and rates from either."""
    if initial is None:
        return np.zeros(2 * n)
    x0 = array("initial", np.atleast_1d(initial))
    if x0.shape not in ((n,), (2 * n,)):
        raise ValueError(
            f"initial: expected {n} relative angles, or {n} angles and {n} rates, "
            f"found shape {x0.shape}."
        )
    if np.abs(np.cumsum(x0[:n])).max() >= np.pi / 2:
        raise ValueError("initial: a link starts past the horizontal; angles are in radians.")
    return np.concatenate([x0, np.zeros(2 * n - len(x0))])


def _reference(reference, t, columns):
    """y_r as rows (samples, tracked outputs)."""
    if callable(reference):
        reference = np.array([np.atleast_1d(reference(float(time))) for time in t])
    value = array("reference", reference)
    if value.ndim == 1:
        value = value[:, None]
    if value.ndim == 0 or (value.ndim == 2 and value.shape[1] == 1):
        value = np.broadcast_to(value, (len(t) if value.size == 1 else len(value), columns or 1))
    if value.ndim != 2 or len(value) != len(t) or (columns and value.shape[1] != columns):
        raise ValueError(
            f"reference: expected a number, a function of t, or one row for each of the {len(t)} "
            f"samples{f' with {columns} columns' if columns else ''}, found shape {value.shape}."
        )
    return np.ascontiguousarray(value)


def _disturbance(disturbance, t, n):
    """(pulses as rows: link index, start, end, height; torques held over each sample)."""
    none, rest = np.zeros((0, 4)), np.zeros((1, n))
    if disturbance is None:
        return none, rest
    if callable(disturbance):
        held = [array("disturbance", disturbance(float(time)), (n,)) for time in t]
        return none, np.array(held)
    pulses = disturbance if isinstance(disturbance, (list, tuple)) else [disturbance]
    for pulse in pulses:
        if not isinstance(pulse, Pulse):
            raise TypeError(f"disturbance: expected pl.Pulse or a function of t, {found(pulse)}.")
        if whole("Pulse link", pulse.link, least=1) > n:
            raise ValueError(f"disturbance: the rig has links 1 to {n}, found {pulse.link}.")
    rows = [(p.link - 1, p.start, p.start + p.length, p.height) for p in pulses]
    return np.array(rows, dtype=float).reshape(-1, 4), rest
