"""What a homework design is accepted by: measured properties, each with a hint at its shortfall.

A shortfall is a sentence or None; a `judged` check yields them, and the first is its hint.
"""

from dataclasses import astuple, replace

import control
import numpy as np

from ..._arguments import found
from ...bench.imperfections import Imperfections
from ...bench.inputs import voltages
from ...design import Design
from ...loop import closed_loop_eigenvalues, margins
from ...paper.designs import paper_design
from ...studies.transmission import rms, time_constant

NOISE = np.array([1e-3, 1e-3, 1e-3, 1e-2])  # standard deviations of the readings, rad and rad/s
REAL = Imperfections(filters=True, saturation=True)


def reference(rig, kp=None):
    """The paper's weights and observer dynamics on this rig, quietest observer."""
    paper = paper_design("triple" if rig.n_motors > 1 else "double")
    return Design(rig, paper.Q, paper.R, paper.E, paper.kp if kp is None else kp)


def no_design(design):
    if not isinstance(design, Design):
        return f"Expected a pl.Design, as dataclasses.replace makes of another, {found(design)}."
    return None


def wrong_design(design, rig, any_filters=False):
    """No Design, or one for another rig."""
    if no_design(design):
        return no_design(design)
    theirs = design.rig
    if any_filters and theirs.n_motors == rig.n_motors:
        theirs = replace(theirs, filters=rig.filters)
    if not alike(theirs, rig):
        changed = "links, motors and limits" if any_filters else "links, motors, limits and filters"
        return f"This design belongs to another rig: {changed} must stay those of your own."
    return None


def alike(one, other):
    """Whether two rigs agree to rounding, whatever their names."""
    same_size = (one.n_links, one.n_motors) == (other.n_links, other.n_motors)
    return same_size and np.array_equal(*map(_digits, (one, other)))


def _digits(rig):
    filters = rig.filters and (rig.filters.input_hz, rig.filters.output_hz)
    parts = [astuple(part) for part in (*rig.links, *rig.motors)]
    numbers = np.hstack([*parts, *(filters or ()), rig.u_max, rig.g]).astype(float)
    return np.array([f"{value:.10g}" for value in numbers])


def before(what, task, verdict):
    """What is still wrong with the task that this one builds on."""
    return None if verdict else f"{what} first ({task}): {verdict.message}"


def unstable(loop, where="with filters"):
    largest = np.abs(closed_loop_eigenvalues(loop)[0])
    if largest >= 1:
        return (
            f"{where.capitalize()} the closed loop is unstable: its largest eigenvalue has "
            f"magnitude {largest:.6g}. Margins mean nothing before that is mended."
        )
    return None


def modulus_margins(design, filters=True):
    return tuple(margins(design.loop(i, filters)).modulus for i in range(design.rig.n_motors))


def small_margins(design, least, loops=None):
    """Modulus margins with filters below `least` (one per input), with the lag there.

    `loops`, broken at each input, are the design's own unless given.
    """
    filters = design.rig.filters
    for i, wanted in enumerate(least):
        found = margins(loops[i] if loops else design.loop(i, filters=True))
        if found.modulus < wanted:
            hertz = found.modulus_omega / (2 * np.pi)
            lag = np.degrees(
                np.arctan(hertz / filters.input_hz[i])
                + np.arctan(hertz / filters.output_hz[i + 1])
                + found.modulus_omega * design.dt / 2
            )
            return (
                f"With filters the modulus margin at input {i + 1} is {found.modulus:.3f}, "
                f"{wanted:.3f} is asked for. The curve is nearest to -1 at {hertz:.2f} Hz, where "
                f"motor filter, sensor filter and hold together take {lag:.0f} degrees."
            )
    return None


def noise_rms(P, G):
    """Standard deviation of each voltage, u = -P (y + n), n white with deviations `NOISE`."""
    return rms(control.feedback(P, G), NOISE)


def design_noise(design):
    return noise_rms(-design.controller.system, design.filtered)


def slow(loop, most):
    tau = time_constant(loop)
    if tau > most:
        return (
            f"With filters the slowest motion has a time constant of {tau:.3g} s, at most "
            f"{most:g} s is asked for."
        )
    return None


def too_noisy(found, limit):
    if found > limit:
        return (
            f"Sensor noise moves motor 1 by {found:.2f} V (standard deviation), at most "
            f"{limit:.2f} V are allowed: something in your estimate differentiates too eagerly."
        )
    return None


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
    if not np.array_equal(u, np.atleast_1d(controller.step(begin, y.copy(), 0.0)[0])):
        return (
            "Equal calls of step gave different voltages: keep what must be remembered in the "
            "state that step returns, not in self."
        )
    return None
