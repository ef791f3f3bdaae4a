"""Why the bench oscillates: describing functions of play and dry friction, and harmonic balance.

A nonlinear part that is fed a cosine answers mainly with a cosine of the same frequency; the ratio of
the two, its describing function, is a gain that depends on the amplitude. A cycle keeps itself up where
the loop round the part passes that ratio on with gain one. What the part answers at higher harmonics
is left out: good where the rest of the loop filters, bad where the part knocks.

References: Gelb and Vander Velde, Multiple-Input Describing Functions and Nonlinear System Design
(1968), chapters 2 and 3.
"""

from dataclasses import dataclass, replace
from itertools import product
from operator import attrgetter

import numpy as np
from scipy.optimize import root

from .._arguments import instance, number, numbers
from ..bench.imperfections import Imperfections
from ..design import Design
from ..loop import frequency_response
from ..models import linearize
from ..parameters import Pendulum


@dataclass(frozen=True)
class Cycle:
    """A predicted oscillation."""

    hertz: float
    joints: tuple  # amplitude of the relative angle of each driven hinge, rad
    twists: tuple  # amplitude of rotor minus joint of each gear, rad; 0 where it has no play


def play(amplitude, gap, stiffness):
    """Describing function of a spring behind play, N m/rad: torque per twist of this amplitude.

    N(a) = k (1 - (2/pi) (asin r + r sqrt(1 - r^2))), r = gap/2a; zero inside the gap.

    >>> float(play(0.01, gap=0.05, stiffness=200.0)), round(float(play(10.0, 0.05, 200.0)))
    (0.0, 199)
    """
    ratio = gap / 2 / np.maximum(np.abs(amplitude), max(gap / 2, 1e-300))
    part = np.arcsin(ratio) + ratio * np.sqrt(1 - ratio**2)
    return stiffness * (1 - 2 / np.pi * part)[()]


def at_the_gears(controller, rig, omega):
    """(joints, drives): what torques through the gears do at the frequencies `omega` (rad/s).

    A column for each gear that passes 1 N m to the links: the angles of the driven hinges (rad), and
    the torques on the rotors (N m): the gear's reaction, and what the controller answers
    through sensors, filters, hold and motor. What sampling folds back from beyond pi/T_s is left out.
    """
    omega = np.asarray(omega, dtype=float)
    free = tuple(replace(motor, damping=0.0, inertia=0.0, gain=1.0) for motor in rig.motors)
    links = frequency_response(linearize(replace(rig, motors=free)), omega)
    s = 1j * omega[:, None, None]
    gains = np.array([motor.gain for motor in rig.motors])[:, None]
    f_in = gains / (1 + s / (2 * np.pi * np.array(rig.filters.input_hz)[:, None]))
    f_out = 1 / (1 + s / (2 * np.pi * np.array(rig.filters.output_hz)))
    system = controller.system
    hold = (1 - np.exp(-s * system.dt)) / (s * system.dt)
    law = hold * f_in * frequency_response(system, omega) * f_out
    return links[:, 1 : rig.n_motors + 1], law @ links - np.eye(rig.n_motors)


def limit_cycles(design, imperfections, between=(0.2, 12.0), rig=None):
    """Every `Cycle` that harmonic balance predicts for the gears of a bench, the slowest first.

    Each gear passes a torque of amplitude |tau|. Its twist is tau/N(a), its rotor turns by
    phi = joint + tau/N(a), and the rotor's equation is to hold for each gear:

        (I s^2 + c s) phi + j (4 F/pi) phi/|phi| = drive,     s = jw

    where 4 F/(pi v) is the describing function of dry friction, a damping that fades with the rate.

    Parameters
    ----------
    design : Design, linear apart from the gears, on a rig with filters
    imperfections : `Imperfections`, of which gap, contact_stiffness and gear_friction are read
    between : frequencies that are searched, Hz
    rig : Pendulum under the design's controller, where it is not the design's own
    """
    instance("design", design, Design, 'pl.paper_design("triple")')
    instance("imperfections", imperfections, Imperfections)
    between = numbers("between", between, above=1e-6, count=2)
    number("between", between[1], above=between[0], most=1e6)
    rig = design.rig if rig is None else instance("rig", rig, Pendulum, 'pl.load("triple")')
    if rig.filters is None:
        raise ValueError("rig: its filters are None; give the rig pl.Filters.")
    gears = _Gears(design.controller, rig, imperfections, between)
    phases, cycles = (0.0, np.pi)[: gears.count], []
    for guess in product(np.geomspace(*between, 9), (0.2, 1.0), phases, gears.may_stick()):
        cycle = gears.cycle(*guess)
        if cycle and all(abs(np.log(cycle.hertz / c.hertz)) > 0.01 for c in cycles):
            cycles.append(cycle)
    return sorted(cycles, key=attrgetter("hertz"))


class _Gears:
    """Harmonic balance of all gears of one rig; unknowns log w, log |tau1|, and tau2 ... as complex."""

    def __init__(self, controller, rig, imperfections, between):
        m = self.count = rig.n_motors
        names = ("gap", "contact_stiffness", "gear_friction")
        self.gap, self.stiffness, self.dry = (imperfections.each(name, m) for name in names)
        self.motors, self.between = rig.motors, between
        self.omega = 2 * np.pi * np.geomspace(*between, 3000)
        self.tables = at_the_gears(controller, rig, self.omega)

    def may_stick(self):
        """Sets of gears whose rotors dry friction may hold, at least one moving."""
        all_sets = product(*((False, True) if dry else (False,) for dry in self.dry))
        return [np.array(stuck) for stuck in all_sets if not all(stuck)]

    def at(self, omega):
        place = np.interp(np.log(omega), np.log(self.omega), np.arange(len(self.omega)))
        k = min(int(place), len(self.omega) - 2)
        return [(1 - place + k) * table[k] + (place - k) * table[k + 1] for table in self.tables]

    def balance(self, x):
        """(joints, twists, rotor angles, torques that are missing at the rotors), as phasors."""
        omega, rest = np.exp(np.clip(np.nan_to_num(x[0]), -9, 9)), x[2:]
        tau = np.exp(np.clip(x[1], -20, 20)) * np.concatenate([[1.0], rest[0::2] + 1j * rest[1::2]])
        joints, drives = (matrix @ tau for matrix in self.at(omega))
        gears = zip(tau, self.gap, self.stiffness)
        twists = [t / abs(t) * _twist(abs(t), gap, k) if gap else 0.0 for t, gap, k in gears]
        rotors, s = joints + twists, 1j * omega
        inertia, damping = np.array([(m.inertia, m.damping) for m in self.motors]).T
        missing = drives - (inertia * s**2 + damping * s) * rotors
        return joints, twists, rotors, missing

    def residual(self, x, stuck):
        """Torques that dry friction does not take up; for a gear that it holds, the rotor's angle."""
        _, _, rotors, missing = self.balance(x)
        slipping = missing - 4j / np.pi * self.dry * rotors / np.maximum(np.abs(rotors), 1e-12)
        error = np.where(stuck, self.stiffness * rotors, slipping) / np.exp(np.clip(x[1], -20, 20))
        return np.concatenate([error.real, error.imag])

    def cycle(self, hertz, size, phase, stuck):
        others = np.ravel([(0.2 * np.cos(phase), 0.2 * np.sin(phase))] * (self.count - 1))
        start = np.concatenate([[np.log(2 * np.pi * hertz), np.log(size)], others])
        solution = root(self.residual, start, args=(stuck,))
        omega = np.exp(np.clip(solution.x[0], -9, 9))
        low, high = self.between
        if np.abs(solution.fun).max() > 1e-7 or not low < omega / (2 * np.pi) < high:
            return None
        joints, twists, _, missing = self.balance(solution.x)
        if np.any(np.abs(missing[stuck]) > 4 / np.pi * self.dry[stuck]):
            return None
        joints, twists = (tuple(np.abs(a).tolist()) for a in (joints, twists))
        return Cycle(float(omega / (2 * np.pi)), joints, twists)


def _twist(torque, gap, stiffness):
    """Amplitude of the twist whose play passes this amplitude of torque: a N(a) inverted."""
    return gap / 2 * np.interp(torque / (stiffness * gap / 2), *_PASSED)


_RATIOS = 1 + np.geomspace(1e-6, 1e6, 5000)  # twist over half the gap
_PASSED = (_RATIOS * play(_RATIOS, 2.0, 1.0), _RATIOS)
