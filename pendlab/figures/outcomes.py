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


def loops_table(pairs):
    """Rows of a table of loops: name -> (`Nyquist` without filters, with filters); heads first."""
    rows = [["loop", "filters", "closed loop", "gain may go", "phase", "distance from −1"]]
    for name, curves in pairs.items():
        for filters, curve in zip(("without", "with"), curves, strict=True):
            m, near = curve.margins, f"{curve.distance:.3g}"
            if not curve.count.stable:
                out = curve.count.unstable_closed
                rows.append([name, filters, f"UNSTABLE, {out} outside the circle", "", "", ""])
            elif m is None:
                rows.append([name, filters, "stable", "", "", near])
            else:
                up = f"{m.gain_up:.3g}" if np.isfinite(m.gain_up) else "∞"
                gain, phase = f"×{m.gain_down:.2g} to ×{up}", f"{np.degrees(m.phase):.1f}°"
                rows.append([name, filters, "stable", gain, phase, near])
    return rows


def loops_verdict(curves):
    """(word, good) of one loop's `Nyquist` curves without and with filters."""
    without, with_ = (curve.count.stable for curve in curves)
    if without and with_:
        return "stable", True
    if without:
        return "UNSTABLE with filters", False
    return ("UNSTABLE without filters" if with_ else "UNSTABLE"), False


def run_verdict(run):
    """(word, good) of a run."""
    return (f"falls at {run.fell_at:.2f} s", False) if run.fell else ("stays up", True)


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
    """Whether a run stays up, and its largest signals from `start` (s) on; of chaos one digit."""
    if run.fell:
        return f"The pendulum falls at {run.fell_at:.2f} s."
    late = run.t >= start
    chaotic = np.any(run.imperfections.gap) or np.any(run.imperfections.gear_friction)

    def largest(values, digits):
        size = np.abs(values[late]).max()
        return f"{size:{'.1g' if size < 1 else '.0f'}}" if chaotic else f"{size:.{digits}f}"

    angles = ", ".join(
        f"{angle_in_words(i + 1)} {largest(column, 3)}" for i, column in enumerate(run.angles.T)
    )
    volts = ", ".join(largest(column, 2) for column in run.u.T)
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


def run_table(run, start=0.0):
    """Largest signals of a run from `start` (s) on, as rows of a table; heads first."""
    late = run.t >= start
    angles = [f"{angle_in_words(i + 1)}, rad" for i in range(run.rig.n_links)]
    volts = [f"u{i + 1}, V" for i in range(run.rig.n_motors)]
    sizes = [f"{np.abs(column[late]).max(initial=0):.3f}" for column in run.angles.T]
    sizes += [f"{np.abs(column[late]).max(initial=0):.2f}" for column in run.u.T]
    return [["largest", *angles, *volts], [f"from {start:g} s to {run.t[-1]:.4g} s", *sizes]]


def angle_in_words(i):
    """θ1, θ2−θ1, ... for plain text."""
    return angle_name(i).replace("theta", "θ").replace("-", "−")
