"""What a homework design is accepted by: measured properties, each with a hint at its shortfall.

A shortfall is a sentence or None; a `judged` check yields them, and the first is its hint.
"""

from dataclasses import astuple, replace

import numpy as np
from scipy.integrate import trapezoid

from ...design import Design
from ...loop import closed_loop_eigenvalues, frequency_grid, frequency_response, margins
from ...paper.designs import paper_design

NOISE = np.array([1e-3, 1e-3, 1e-3, 1e-2])  # standard deviations of the readings, rad and rad/s


def reference(rig, kp=None):
    """The paper's weights and observer dynamics on this rig, quietest observer."""
    paper = paper_design("triple")
    return Design(rig, paper.Q, paper.R, paper.E, paper.kp if kp is None else kp)


def wrong_design(design, rig, any_filters=False):
    """No Design, or one for another rig."""
    if not isinstance(design, Design):
        return (
            "Expected a design made with dataclasses.replace(reference, ...), found "
            f"{type(design).__name__}."
        )
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


def unstable(loop, where="with filters"):
    largest = np.abs(closed_loop_eigenvalues(loop)[0])
    if largest >= 1:
        return (
            f"{where.capitalize()} the closed loop is unstable: its largest eigenvalue has "
            f"magnitude {largest:.4f}. Margins mean nothing before that is mended."
        )
    return None


def modulus_margins(design, filters=True):
    return tuple(margins(design.loop(i, filters)).modulus for i in range(design.rig.n_motors))


def small_margins(design, least):
    """Modulus margins with filters below `least` (one per input), with the lag there."""
    for i, wanted in enumerate(least):
        found = margins(design.loop(i, filters=True))
        if found.modulus < wanted:
            hertz = found.modulus_omega / (2 * np.pi)
            filters = design.rig.filters
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


def noise_rms(P, G, sigma=NOISE):
    """Standard deviation of each voltage, u = -P (y + n), n white with deviations `sigma`.

    The variance is the mean of |(I + P G)^-1 P sigma|^2 over the unit circle (Parseval).
    """
    omega = frequency_grid(G.dt, 600, 1e-2)
    P, L = frequency_response(P, omega), frequency_response(G, omega)
    to_u = np.linalg.solve(np.eye(P.shape[1]) + P @ L, P) * sigma
    return np.sqrt(trapezoid((np.abs(to_u) ** 2).sum(axis=2), omega, axis=0) * G.dt / np.pi)


def design_noise(design, sigma=NOISE):
    return noise_rms(-design.controller.system, design.filtered, sigma)


def too_noisy(found, limit):
    if found > limit:
        return (
            f"Sensor noise moves motor 1 by {found:.2f} V (standard deviation), at most "
            f"{limit:.2f} V are allowed: something in your estimate differentiates too eagerly."
        )
    return None
