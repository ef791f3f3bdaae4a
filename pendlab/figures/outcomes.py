"""Outcomes in words, for the captions of widgets: margins, stability, gains, runs."""

import numpy as np

from .style import angle_name


def margins_in_words(curve):
    """Stability, margins and distance from the critical point of a `Nyquist` curve, in short."""
    if not curve.count.stable:
        count = curve.count.unstable_closed
        return f"UNSTABLE, {count} eigenvalue{'s' * (count != 1)} outside the unit circle"
    near = f"distance {curve.distance:.3g}"
    if curve.margins is None:
        return f"stable, {near}"
    m = curve.margins
    up = f"{m.gain_up:.3g}" if np.isfinite(m.gain_up) else "∞"
    return f"stable, gain ×{m.gain_down:.2g}–{up}, phase {np.degrees(m.phase):.1f}°, {near}"


def loops_in_words(name, curves):
    """Both `Nyquist` curves of one loop, without and with filters."""
    without, with_ = map(margins_in_words, curves)
    return f"{name} without filters: {without}; with: {with_}."


def gain_in_words(F):
    """The gain F."""
    return f"F = {rows_in_words(F)}."


def rows_in_words(matrix):
    """A matrix to four digits, rows parted by semicolons, without the minus of zero."""
    rows = [", ".join(f"{value:.4g}" for value in row + 0.0) for row in np.atleast_2d(matrix)]
    return "[" + "; ".join(rows) + "]"


def run_in_words(run, start=0.0):
    """Whether a run stays up, and its largest signals from `start` (s) on."""
    if run.fell:
        return f"The pendulum falls at {run.fell_at:.2f} s."
    late = run.t >= start
    angles = ", ".join(
        f"{angle_in_words(i + 1)} {np.abs(column[late]).max():.3f}"
        for i, column in enumerate(run.angles.T)
    )
    volts = ", ".join(f"{np.abs(column[late]).max():.2f}" for column in run.u.T)
    at_limit = run.saturated.max()
    limit = f" At the voltage limit for {at_limit:.1%} of the samples." if at_limit else ""
    return (
        f"It stays up. Largest from {start:g} s to {run.t[-1]:g} s: {angles} rad; voltage {volts} V."
        f"{limit}"
    )


def short(value):
    """Three digits without a power of ten.

    >>> short(1234.5), short(0.03418)
    ('1230', '0.0342')
    """
    return np.format_float_positional(value, 3, unique=False, fractional=False, trim="-")


def angle_in_words(i):
    """θ1, θ2−θ1, ... for plain text."""
    return angle_name(i).replace("theta", "θ").replace("-", "−")
