"""What `simulate` is given, checked and brought into rows."""

import numpy as np

from .._arguments import array, found, instances, number, whole
from .imperfections import Pulse

MOST_SAMPLES = 1_000_000
FASTEST = 1e6  # rad/s, of a start


def called(name, t, function, *arguments):
    """Call a function of the user; a failure is named with its time."""
    try:
        return function(*arguments)
    except Exception as problem:
        raise ValueError(
            f"{name} failed at t = {t:.4g} s ({type(problem).__name__}: {problem})."
        ) from problem


def sampling_time(controller, dt):
    """`dt`, the controller's own or 0.01 s."""
    own = getattr(controller, "dt", None)
    if own is not None:
        own = number("controller.dt", own, above=0)
    dt = number("dt", (0.01 if own is None else own) if dt is None else dt, above=0)
    if own is not None and abs(own - dt) > 1e-12:
        raise ValueError(f"dt: the controller is made for {own:g} s, {found(dt)}; leave dt out.")
    return dt


def sample_times(t_end, dt):
    """0, dt, 2 dt, ... up to t_end."""
    count = number("t_end", t_end, least=0) / dt + 1e-9
    if count >= MOST_SAMPLES:
        raise ValueError(
            f"t_end: expected less than {MOST_SAMPLES * dt:g} s, a million samples of {dt:g} s, "
            f"{found(t_end)}."
        )
    return dt * np.arange(int(count) + 1)


def initial_state(initial, n):
    """Relative angles and rates from either."""
    if initial is None:
        return np.zeros(2 * n)
    x0 = np.atleast_1d(array("initial", initial))
    if x0.shape not in ((n,), (2 * n,)):
        raise ValueError(
            f"initial: expected {n} relative angles, or {n} angles and {n} rates, "
            f"found shape {x0.shape}."
        )
    if np.abs(x0[:n]).max() > np.pi or np.abs(np.cumsum(x0[:n])).max() >= np.pi / 2:
        raise ValueError("initial: a link starts past the horizontal; angles are in radians.")
    if np.abs(x0[n:]).max(initial=0.0) > FASTEST:
        raise ValueError(f"initial: expected rates below {FASTEST:g} rad/s, {found(initial)}.")
    return np.concatenate([x0, np.zeros(2 * n - len(x0))])


def reference_rows(reference, t, columns):
    """y_r as rows (samples, tracked outputs); `columns` is None for a controller of one's own."""
    if callable(reference):
        value = _at_each(reference, "reference", t)
    else:
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
    return np.array(value, order="C")  # of its own, writable as the compiled loop expects


def _at_each(function, name, t):
    """Values of a function of time, a row per sample, all of the same length."""
    rows = []
    for time in t.tolist():
        value = called(f"{name}: the function", time, function, time)
        rows.append(np.atleast_1d(array(f"{name} at t = {time:.4g} s", value)))
        if rows[-1].shape != rows[0].shape:
            raise ValueError(
                f"{name} at t = {time:.4g} s: expected {rows[0].size} numbers as at t = 0, "
                f"found {rows[-1].size}."
            )
    return np.array(rows)


def disturbance_rows(disturbance, t, n):
    """(pulses as rows: link index, start, end, height; torques held over each sample)."""
    none, rest = np.zeros((0, 4)), np.zeros((1, n))
    if disturbance is None:
        return none, rest
    if callable(disturbance):
        held = _at_each(disturbance, "disturbance", t)
        if held.shape[1:] != (n,):
            raise ValueError(
                f"disturbance: expected a torque for each of the {n} links, "
                f"found {held[0].size} numbers."
            )
        return none, held
    pulses = instances("disturbance", disturbance, Pulse, " or a function of t")
    for pulse in pulses:
        if whole("Pulse link", pulse.link, least=1) > n:
            raise ValueError(f"disturbance: the rig has links 1 to {n}, found {pulse.link}.")
    rows = [(p.link - 1, p.start, p.start + p.length, p.height) for p in pulses]
    return np.array(rows, dtype=float).reshape(-1, 4), rest


def voltages(answer, m, t):
    """(voltages, next state) from what a controller's `step` returned."""
    when = f"controller: step at t = {t:.4g} s"
    if not isinstance(answer, tuple) or len(answer) != 2:
        raise ValueError(f"{when} must return the pair (u, next state), {found(answer)}.")
    try:
        u = array("u", answer[0], (m,), finite=False)
    except (TypeError, ValueError) as problem:
        raise ValueError(f"{when} must return {m} voltages, {found(answer[0])}.") from problem
    if not np.all(np.isfinite(u)):
        raise ValueError(f"{when} returned {u}; every voltage must be finite.")
    return u, answer[1]
