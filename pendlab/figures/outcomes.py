"""Outcomes in words and tables, for the captions of widgets: margins, stability, gains, runs."""

import numpy as np

from .style import angle_name


def _readings(curve):
    """(state, gain down, gain up, phase, distance) of a `Nyquist` curve as text, "" for none."""
    if not curve.count.stable:
        return f"UNSTABLE, {curve.count.unstable_closed}", "", "", "", ""
    m, near = curve.margins, f"{curve.distance:.3g}"
    if m is None:
        return "stable", "", "", "", near
    up = f"{m.gain_up:.3g}" if np.isfinite(m.gain_up) else "∞"
    return "stable", f"×{m.gain_down:.2g}", up, f"{np.degrees(m.phase):.1f}°", near


def margins_in_words(curve):
    """Stability, margins and distance from the critical point of a `Nyquist` curve, in short."""
    state, down, up, phase, near = _readings(curve)
    if not near:
        several = "s" * (curve.count.unstable_closed != 1)
        return f"{state} eigenvalue{several} outside the unit circle"
    margins = f", gain {down}–{up}, phase {phase}" if phase else ""
    return f"{state}{margins}, distance {near}"


def loops_table(pairs):
    """Rows of a table of loops: name -> (`Nyquist` without filters, with filters); heads first."""
    rows = [["loop", "filters", "closed loop", "gain may go", "phase", "distance from −1"]]
    for name, curves in pairs.items():
        for filters, curve in zip(("without", "with"), curves, strict=True):
            state, down, up, phase, near = _readings(curve)
            gain, outside = f"{down} to ×{up}" if phase else "", " outside the circle"
            rows.append([name, filters, state if near else state + outside, gain, phase, near])
    return rows


def loops_verdict(curves):
    """(word, good) of one loop's `Nyquist` curves without and with filters."""
    unstable = [word for word, c in zip(("without", "with"), curves) if not c.count.stable]
    if not unstable:
        return "stable", True
    return "UNSTABLE" + (f" {unstable[0]} filters" if len(unstable) == 1 else ""), False


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


def _largest(run, start, rough=False):
    """Largest angles (rad) and voltages (V) of a run from `start` (s) on, as text."""

    def sizes(values, digits):
        for size in np.abs(values[run.t >= start]).max(axis=0, initial=0):
            yield f"{size:{'.1g' if size < 1 else '.0f'}}" if rough else f"{size:.{digits}f}"

    return [*sizes(run.angles, 3)], [*sizes(run.u, 2)]


def run_in_words(run, start=0.0):
    """Whether a run stays up, and its largest signals from `start` (s) on; of chaos one digit."""
    if run.fell:
        return f"The pendulum falls at {run.fell_at:.2f} s."
    chaotic = np.any(run.imperfections.gap) or np.any(run.imperfections.gear_friction)
    angles, volts = _largest(run, start, rough=chaotic)
    angles = ", ".join(f"{angle_in_words(i)} {size}" for i, size in enumerate(angles, 1))
    return (
        f"It stays up. Largest from {start:g} s to {run.t[-1]:g} s: {angles} rad; "
        f"voltage {', '.join(volts)} V.{limit_in_words(run)}"
    )


def limit_in_words(run):
    """How often the voltages were at their limit, if at all."""
    share = run.saturated.max()
    return f" At the voltage limit for {share:.1%} of the samples." if share else ""


def run_table(run, start=0.0):
    """Largest signals of a run from `start` (s) on, as rows of a table; heads first."""
    angles, volts = _largest(run, start)
    heads = [f"{angle_in_words(i)}, rad" for i in range(1, len(angles) + 1)]
    heads += [f"u{i}, V" for i in range(1, len(volts) + 1)]
    return [["largest", *heads], [f"from {start:g} s to {run.t[-1]:.4g} s", *angles, *volts]]


def short(value):
    """Three digits without a power of ten.

    >>> short(1234.5), short(0.03418)
    ('1230', '0.0342')
    """
    return np.format_float_positional(value, 3, unique=False, fractional=False, trim="-")


def angle_in_words(i):
    """θ1, θ2−θ1, ... for plain text."""
    return angle_name(i).replace("theta", "θ").replace("-", "−")
