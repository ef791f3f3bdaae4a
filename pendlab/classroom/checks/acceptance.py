"""What a homework design is accepted by: measured properties, each with a hint at its shortfall.

A shortfall is a sentence or None; a check yields them, and the first is its hint.
"""

from dataclasses import astuple, replace

import control
import numpy as np

import pendlab as pl

from ..._arguments import found
from ...bench.inputs import voltages
from .judging import verdict

NOISE = np.array([1e-3, 1e-3, 1e-3, 1e-2])  # standard deviations of the readings, rad and rad/s
REAL = pl.Imperfections(filters=True, saturation=True)


def reference(rig, kp=None):
    """The paper's weights and observer dynamics on this rig, quietest observer."""
    paper = pl.paper_design("triple" if rig.n_motors > 1 else "double")
    return pl.Design(rig, paper.Q, paper.R, paper.E, paper.kp if kp is None else kp)


def no_design(design):
    wanted = "a pl.Design, as dataclasses.replace makes of another"
    return None if isinstance(design, pl.Design) else f"Expected {wanted}, {found(design)}."


def wrong_design(design, rig, any_filters=False):
    """No Design, or one for another rig."""
    if no_design(design):
        return no_design(design)
    kept, rigs = "links, motors, limits and filters", (design.rig, rig)
    if any_filters:
        kept, rigs = "links, motors and limits", (replace(each, filters=None) for each in rigs)
    told = f"This design belongs to another rig: {kept} must stay those of your own."
    return None if alike(*rigs) else told


def alike(one, other):
    """Whether two rigs agree to rounding, whatever their names."""
    return _digits(one) == _digits(other)


def _digits(rig):
    parts = [astuple(part) for part in (*rig.links, *rig.motors)]
    filters = astuple(rig.filters) if rig.filters else ()
    return [f"{value:.10g}" for value in np.hstack([*parts, *filters, rig.u_max, rig.g])]


def before(what, task, steps):
    """What is still wrong with the task that this one builds on."""
    told = verdict(steps)
    return None if told else f"{what} first ({task}): {told.message}"


def unstable(loop, where="with filters"):
    largest = np.abs(pl.closed_loop_eigenvalues(loop)[0])
    told = f"""{where.capitalize()} the closed loop is unstable: its largest eigenvalue has magnitude
        {largest:.6g}. Margins mean nothing before that is mended."""
    return told if largest >= 1 else None


def modulus_margins(design, filters=True):
    return tuple(pl.margins(design.loop(i, filters)).modulus for i in range(design.rig.n_motors))


def small_margins(design, least, loops=None):
    """Modulus margins with filters below `least` (one per input), with the lag there.

    `loops`, broken at each input, are the design's own unless given.
    """
    filters = design.rig.filters
    for i, wanted in enumerate(least):
        found = pl.margins(loops[i] if loops else design.loop(i, filters=True))
        if found.modulus < wanted:
            hertz = found.modulus_omega / (2 * np.pi)
            cut_offs = filters.input_hz[i], filters.output_hz[i + 1]
            lags = [*np.arctan(np.divide(hertz, cut_offs)), found.modulus_omega * design.dt / 2]
            return f"""With filters the modulus margin at input {i + 1} is {found.modulus:.3f},
                {wanted:.3f} is asked for. The curve is nearest to -1 at {hertz:.2f} Hz, where motor
                filter, sensor filter and hold together take {np.degrees(sum(lags)):.0f} degrees."""
    return None


def noise_volts(P, G):
    """Standard deviation of motor 1's voltage, u = -P (y + n), n white with deviations `NOISE`."""
    return pl.rms(control.feedback(P, G), NOISE)[0]


def design_noise(design):
    return noise_volts(-design.controller.system, design.filtered)


def slow(loop, most):
    tau = pl.time_constant(loop)
    told = f"With filters the slowest motion has a time constant of {tau:.3g} s, at most {most:g} s"
    return f"{told} is asked for." if tau > most else None


def too_noisy(found, limit):
    told = f"""Sensor noise moves motor 1 by {found:.2f} V (standard deviation), at most {limit:.2f}
        V are allowed: something in your estimate differentiates too eagerly."""
    return told if found > limit else None


def fallen(run, when):
    return f"{when} it falls after {run.fell_at:.2f} s." if run.fell else None


def first_state(controller, x0):
    """The state before the first sample, as the simulator makes it."""
    start = getattr(controller, "start", None)
    return None if start is None else start(x0)


def remembers_in_self(controller, x0, y, motors):
    """Whether a call of step leaves its mark in the controller."""
    begin = first_state(controller, x0)
    u, state = voltages(controller.step(begin, y.copy(), 0.0), motors, 0.0)
    controller.step(state, -y, 0.0)
    told = """Equal calls of step gave different voltages: keep what must be remembered in the state
        that step returns, not in self."""
    again = np.atleast_1d(controller.step(begin, y.copy(), 0.0)[0])
    return None if np.array_equal(u, again) else told
