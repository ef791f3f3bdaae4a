"""The rig in software: a continuous nonlinear pendulum under a sampled controller (section 5)."""

from dataclasses import dataclass

import numpy as np

from .._arguments import found, instance
from ..controllers import Controller
from ..parameters import Pendulum
from .imperfections import Imperfections
from .inputs import disturbance_rows, initial_state, reference_rows, sample_times, sampling_time
from .plant import bench_tuples, integration
from .stepping import any_loop, first_estimate, paper_loop


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
    loop = paper_loop if ours else any_loop
    done, fell, X, y, u, estimate = loop(bench, controller, y_ref, first_estimate(bench, x0))
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
