"""Homework 6: the limit cycle of a gearbox with backlash, predicted and simulated."""

from dataclasses import replace

import numpy as np
from scipy.optimize import brentq

from ..._arguments import array, number
from ...bench.imperfections import Imperfections, bench_imperfections
from ...bench.simulation import simulate
from ...design import Design
from ...loop import frequency_response
from ...models import linearize
from ...paper.designs import paper_design
from .acceptance import small_margins, unstable, wrong_design
from .judging import Verdict, all_right, choose, compare, judged, not_callable, on

STIFFNESS = 50.0  # N m/rad, of the gearbox of tasks 1 to 4
SECONDS, FROM = 30.0, 15.0
SMALLER, MARGIN, FURTHEST = 0.2, 0.3, 0.06


def reference(rig):
    paper = paper_design("double")
    return Design(rig, paper.Q, paper.R, paper.E)


def gap(rig):
    return bench_imperfections(rig).gap[0]


def dead_zone(a, half, stiffness):
    """Describing function of a spring with play: first harmonic of the torque over amplitude a."""
    ratio = half / np.maximum(a, half)
    return stiffness * (1 - 2 / np.pi * (np.arcsin(ratio) + ratio * np.sqrt(1 - ratio**2)))


def links(rig, omega):
    """From a torque at hinge 2 to the outputs, the motor taken away."""
    free = replace(rig.motors[0], damping=0.0, inertia=0.0, gain=1.0)
    return frequency_response(linearize(replace(rig, motors=(free,))), omega)[:, :, 0]


def at_the_gear(design, omega):
    """W of delta = -W tau: twist of the gear over the torque that it passes on."""
    rig, motor = design.rig, design.rig.motors[0]
    s = 1j * np.atleast_1d(omega)
    hold = (1 - np.exp(-s * design.dt)) / (s * design.dt)
    f_in = 1 / (1 + s / (2 * np.pi * rig.filters.input_hz[0]))
    f_out = 1 / (1 + s[:, None] / (2 * np.pi * np.array(rig.filters.output_hz)))
    P = -frequency_response(design.controller.system, s.imag)[:, 0]
    G = links(rig, s.imag)
    to_torque = motor.gain * f_in * hold * (P * f_out * G).sum(axis=1)
    return (1 + to_torque) / (motor.inertia * s**2 + motor.damping * s) + G[:, 1]


def prediction(design, half, stiffness):
    """(Hz, amplitude of the twist, amplitude of theta2 - theta1) or None without a limit cycle."""
    omega = np.geomspace(3.0, 0.9 * np.pi / design.dt, 3000)
    imaginary = at_the_gear(design, omega).imag
    for i in np.flatnonzero(np.sign(imaginary[:-1]) != np.sign(imaginary[1:])):
        w = brentq(lambda w: at_the_gear(design, w).imag[0], omega[i], omega[i + 1])
        needed = -1 / at_the_gear(design, w).real[0]
        if 0 < needed < stiffness:
            a = brentq(lambda a, N: dead_zone(a, half, stiffness) - N, half, 1e4 * half, (needed,))
            return w / (2 * np.pi), a, abs(links(design.rig, w)[0, 1]) * needed * a
    return None


def measured(run):
    """(Hz, half the peak to peak) of theta2 - theta1 from `FROM` on."""
    late = run.t >= FROM
    x = run.angles[late, 1] - run.angles[late, 1].mean()
    up = np.flatnonzero((x[:-1] < 0) & (x[1:] >= 0))
    crossing = run.t[late][up] - run.dt * x[up] / (x[up + 1] - x[up])
    return 1 / np.diff(crossing).mean(), np.ptp(x) / 2


def run_with(design, imperfections):
    return simulate(
        design.rig, design.controller, SECONDS, [0.01, -0.01], imperfections=imperfections
    )


def soft_gear(rig):
    return Imperfections(
        filters=True, gap=gap(rig), contact_stiffness=STIFFNESS, contact_damping=0.0
    )


@on("double", who="your name")
@judged
def exercise_1(function, rig=None):
    yield not_callable(function, "your function N(a)")
    half = gap(rig) / 2
    for times in (0.5, 1.0, 1.02, 1.3, 2.0, 5.0, 50.0):
        found = number("N(a)", float(np.real(function(times * half))))
        truth = float(dead_zone(times * half, half, STIFFNESS))
        judged = compare(
            f"N at {times:g} times half the gap",
            found,
            truth,
            mistakes=[
                (STIFFNESS - truth, "That is what the dead zone takes away; the spring keeps the "
                 "rest."),
                (float(dead_zone(times * half, 2 * half, STIFFNESS)), "The play is the gap from "
                 "side to side; contact begins at half of it."),
                (truth / 2, "Half of it: the first harmonic is 2 times the mean of torque times "
                 "cosine."),
            ] if truth > 0 else [],
            tolerance=2e-3,
        )  # fmt: skip
        if truth == 0 and abs(found) > 1e-6 * STIFFNESS:
            yield "Inside the gap nothing touches: N is 0 there."
        if truth > 0 and not judged:
            yield judged
    return "Nothing inside the gap, and nearly the whole spring far outside."


@on("double", who="your name")
def exercise_2(function, rig=None):
    if not callable(function):
        return Verdict(False, not_callable(function, "your function W(omega)"))
    design = reference(rig)
    omega = np.array([2.0, 10.0, 30.0, 80.0])
    found = np.asarray(function(omega), dtype=complex)
    truth = at_the_gear(design, omega)
    G, motor, s = links(design.rig, omega)[:, 1], design.rig.motors[0], 1j * omega
    rotor = 1 / (motor.inertia * s**2 + motor.damping * s)
    return compare(
        "W",
        found,
        truth,
        mistakes=[
            (truth - G, "The twist is rotor minus link: the link moves under the torque too."),
            (rotor + G, "That is the gear without controller: u answers what y does."),
            (2 * (rotor + G) - truth, "Sign of the controller: u = -P y."),
        ],
    )


@on("double", who="your name")
def exercise_3(found, stability, rig=None):
    design = reference(rig)
    truth = np.array(prediction(design, gap(rig) / 2, STIFFNESS))
    first = compare(
        "predicted",
        found,
        truth,
        mistakes=[
            (truth * [2 * np.pi, 1, 1], "The first number should be in hertz."),
            (truth * [1, 1, truth[1] / truth[2]], "The third is the link's angle: its own transfer "
             "function times the torque N a, not the twist."),
        ],
        apart=True,
        each=True,  # hertz and radians
    )  # fmt: skip
    return all_right(first, choose(
        "stability",
        stability,
        "stable",
        {"unstable": "Suppose the amplitude is a little too large: N is larger, so the gear is "
         "stiffer. Is the loop with a stiff gear stable or not?"},
    ))  # fmt: skip


@on("double", who="your name")
def exercise_4(answer, rig=None):
    design = reference(rig)
    truth = np.array(measured(run_with(design, soft_gear(rig))))
    pair = array("measured", answer, (2,))
    scaled = pair / truth
    return compare(
        "measured (over what we measure)",
        scaled,
        np.ones(2),
        mistakes=[
            ([2 * np.pi, 1], "The first number should be in hertz."),
            ([2, 1], "Count full periods: upward crossings only."),
            ([1, 2], "Amplitude is half of peak to peak."),
            ([1, 1 / np.sqrt(2)], "Amplitude, not RMS."),
        ],
        tolerance=0.03,
        apart=True,
    )


@on("double", who="your name")
@judged
def exercise_5(design, attitude, rig=None):
    """A design and an attitude at which the real gear comes to rest."""
    attitude = number("attitude", attitude)
    gear = hard_gear(rig)

    yield wrong_design(design, rig)
    if abs(attitude) > FURTHEST:
        yield f"The attitude may be {FURTHEST:g} rad at most, yours is {attitude:g} rad."
    yield unstable(design.filtered_loop)
    yield small_margins(design, (MARGIN,))
    after = swing(design, attitude, gear)
    if after is None:
        yield "With the gap the pendulum falls."
    before = swing(reference(rig), 0.0, gear)
    if after > SMALLER * before:
        yield (
            f"theta2 - theta1 still swings with {after / before:.0%} of the reference's "
            f"amplitude, {SMALLER:.0%} is asked for. Do the teeth still leave each other? "
            "Compare the torque of gravity at the gear with what the controller adds."
        )
    return "The teeth stay in touch, and the pendulum comes to rest."


def hard_gear(rig):
    """The bench's filters, limits, delay and gap, without dry friction and sensor errors."""
    bench = bench_imperfections(rig)
    return replace(bench, gear_friction=0.0, offset=0.0, resolution=0.0, voltage_resolution=0.0)


def swing(design, attitude, gear):
    """Half the peak to peak of theta2 - theta1 in the last 10 of 40 s, or None after a fall."""
    run = simulate(
        design.rig, design.controller, 40, [0.01, -0.01], reference=attitude, imperfections=gear
    )
    return None if run.fell else float(np.ptp(run.angles[run.t > 30, 1]) / 2)
