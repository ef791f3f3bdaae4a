"""Homework 6: the limit cycle of a gearbox with backlash, predicted and simulated."""

from dataclasses import replace

import numpy as np

import pendlab as pl

from ..._arguments import array, number
from ...paper.changes import hertz
from ...studies.describing import at_the_gears, play
from .acceptance import fallen, reference, slow, small_margins, unstable, wrong_design
from .judging import FOUND_TOO, all_right, asks, choose, compare, not_callable

RIG = dict(base="double", who="your name")
STIFFNESS = 50.0  # N m/rad, of the gearbox of tasks 1 to 4
SECONDS, FROM = 30.0, 15.0
FUNCTION, CYCLE = 2e-3, 0.03  # tolerances of tasks 1 and 4
SMALLER, MARGIN, FURTHEST, SLOWEST = 0.2, 0.5, 0.05, 2.5  # share, from -1, rad, s


def gap(rig):
    return pl.bench_imperfections(rig).gap[0]


def at_the_gear(design, omega):
    """W of delta = -W tau, the twist over the gear's torque, and the joint's part of it."""
    tables = at_the_gears(design.controller, design.rig, omega)
    joint, drive = (table[:, 0, 0] for table in tables)
    return joint - drive * rotor(design.rig, omega), joint


def rotor(rig, omega):
    motor, s = rig.motors[0], 1j * omega
    return 1 / (motor.inertia * s**2 + motor.damping * s)


def measured(run):
    """Hertz and amplitude of theta2 - theta1 from `FROM` on."""
    return hertz(run, FROM), swing(run, FROM)


def swing(run, since=30.0):
    """Half the peak to peak of theta2 - theta1, by default in the last 10 of 40 s."""
    return float(np.ptp(run.angles[run.t >= since, 1]) / 2)


def run_with(design, bench, seconds=SECONDS, attitude=0.0):
    start = [0.01, -0.01]
    return pl.simulate(design.rig, design.controller, seconds, start, attitude, imperfections=bench)


def soft_gear(rig):
    contact = dict(contact_stiffness=STIFFNESS, contact_damping=0.0)
    return pl.Imperfections(filters=True, gap=gap(rig), **contact)


def exercise_1(function, rig):
    """The describing function of play."""
    yield not_callable(function, "your function N(a)")
    width = gap(rig)
    for times in (0.5, 1.0, 1.02, 1.3, 2.0, 5.0, 50.0):
        amplitude = times * width / 2
        found = number("N(a)", float(np.real(function(amplitude))))
        truth = play(amplitude, width, STIFFNESS)
        if truth == 0 and abs(found) > 1e-6 * STIFFNESS:
            yield "Inside the gap nothing touches: N is 0 there."
        if truth > 0:
            mistakes = _of_play(amplitude, width, truth)
            yield compare(f"N at {times:g} times half the gap", found, truth, mistakes, FUNCTION)
    return "Nothing inside the gap, and nearly the whole spring far outside."


def _of_play(amplitude, width, truth):
    yield STIFFNESS - truth, "That is what the dead zone takes; the spring keeps the rest."
    wide = "The play is the gap from side to side; contact begins at half of it."
    yield play(amplitude, 2 * width, STIFFNESS), wide
    half = "Half of it: the first harmonic is 2 times the mean of torque times cosine."
    yield truth / 2, half


def exercise_2(function, rig):
    """What the gear feels of the rest, W(omega)."""
    yield not_callable(function, "your function W(omega)")
    omega = np.array([2.0, 10.0, 30.0, 80.0])
    truth, G = at_the_gear(reference(rig), omega)
    alone = rotor(rig, omega) + G
    mistakes = [
        (truth - G, "The twist is rotor minus link: the link moves under the torque too."),
        (alone, "That is the gear without controller: u answers what y does."),
        (2 * alone - truth, "Sign of the controller: u = -P y."),
    ]
    yield compare("W", np.asarray(function(omega), dtype=complex), truth, mistakes)
    return FOUND_TOO


def exercise_3(found, stability, rig):
    """Frequency and amplitudes of the limit cycle, and whether motion returns to it."""
    stiff = """Answer the task's question first: a little too large an amplitude, and what is N
        then? Is the loop with such a gear damped or not?"""
    returns = choose("stability", stability, "stable", {"unstable": stiff})
    return all_right(_predicted(found, rig=rig), returns)


@asks("predicted", apart=True, each=True)  # hertz and radians
def _predicted(rig):
    (cycle,) = pl.limit_cycles(reference(rig), soft_gear(rig))
    truth = np.array([cycle.hertz, *cycle.twists, *cycle.joints])
    yield truth, None
    yield truth * [2 * np.pi, 1, 1], "The first number should be in hertz."
    third = """The third is the link's angle: its own transfer function times the torque N a, not
        the twist."""
    yield truth[[0, 1, 1]], third


def exercise_4(answer, rig):
    """Frequency and amplitude of the simulated cycle."""
    truth = np.array(measured(run_with(reference(rig), soft_gear(rig))))
    return _measured(array("measured", answer, (2,)) / truth)


@asks("measured (over what we measure)", tolerance=CYCLE, apart=True)
def _measured(rig):
    yield [1, 1], None
    yield [2 * np.pi, 1], "The first number should be in hertz."
    yield [2, 1], "Count full periods: upward crossings only."
    yield [1, 2], "Amplitude is half of peak to peak."
    yield [1, 1 / np.sqrt(2)], "Amplitude, not RMS."


def exercise_5(design, attitude, rig):
    """A design and an attitude at which the real gear comes to rest."""
    yield wrong_design(design, rig)
    if abs(number("attitude", attitude)) > FURTHEST:
        yield f"The attitude may be {FURTHEST:g} rad at most, yours is {attitude:g} rad."
    yield unstable(design.filtered_loop)
    yield small_margins(design, (MARGIN,))
    yield slow(design.filtered_loop, SLOWEST)
    run = run_with(design, hard_gear(rig), 40.0, attitude)
    yield fallen(run, "With the gap")
    share = swing(run) / swing(run_with(reference(rig), hard_gear(rig), 40.0))
    if share > SMALLER:
        yield f"""theta2 - theta1 still swings with {share:.0%} of the reference's amplitude,
            {SMALLER:.0%} is asked for. Do the teeth still leave each other? Compare the torque of
            gravity at the gear with what the controller adds."""
    return f"{share:.1%} of the reference's swing is left."


def hard_gear(rig):
    """The bench's filters, limits, delay and gap, without dry friction and sensor errors."""
    bench = pl.bench_imperfections(rig)
    return replace(bench, gear_friction=0.0, offset=0.0, resolution=0.0, voltage_resolution=0.0)
