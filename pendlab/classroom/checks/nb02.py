"""Checks of notebook 02: the rotor, the fall, filters, sampling, power sources."""

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq

from ..._arguments import array
from ...models import linearize, nonlinear
from ...parameters import load
from ...sampled import sample
from .judging import all_right, asks, on
from .nb00 import growth

SAMPLES = 0.02  # s, two samples of 10 ms
LEANS = (0.01, 0.3)  # rad, from and to
CONTINUOUS = "{} belongs to the continuous model; the sampled one is asked for."
HALF = "{} is still that of one sample of 10 ms."


@on("double", own="'02.1', rotor, share, rig=own")
def exercise_1(rotor=None, share=None, rig=None):
    """Inertia of the bare rotor, kg m^2, and the reflected one over J2."""
    return all_right(_rotor(rotor, rig), _share(share, rig))


@asks("rotor")
def _rotor(rig):
    motor = rig.motors[0]
    yield motor.inertia / motor.ratio**2, None
    yield motor.inertia, "That is the reflected inertia; the bare rotor's is smaller."
    yield motor.inertia / motor.ratio, "Energy goes with the square of the rate, so not k."
    faster = "The rotor turns faster than the shaft: is it the reflected inertia that is larger?"
    yield motor.inertia * motor.ratio**2, faster


@asks("share")
def _share(rig):
    motor, (lower, upper) = rig.motors[0], rig.links
    hinge = upper.inertia + upper.mass * upper.com**2
    praise = "Small, but it spins fast: at the hinge it weighs like a good part of the link."
    yield motor.inertia / hinge, praise
    centre = "That is about link 2's centre of mass; J2 is about its hinge."
    yield motor.inertia / upper.inertia, centre
    term = "J2 has a second term, the link's own inertia."
    yield motor.inertia / (upper.mass * upper.com**2), term
    lower_hinge = lower.inertia + lower.mass * lower.com**2
    yield motor.inertia / lower_hinge, "That is link 1; link 2 is `links[1]`."
    bare = "That is the bare rotor; at the hinge its reflected inertia counts."
    yield motor.inertia / motor.ratio**2 / hinge, bare
    yield (
        motor.inertia / (motor.inertia + hinge),
        "That is the share of the sum; divide by J2 alone.",
    )


def exercise_2(t_double=None, t_triple=None, rig=None):
    """Time in which the fastest unstable mode grows from 0.01 to 0.3 rad, double and triple, s."""
    return all_right(_t_double(t_double), _t_triple(t_triple))


@asks("t_double", tolerance=1e-2)  # two digits
def _t_double(rig):
    return _fall(growth(load("double")), growth(load("triple")), None)


@asks("t_triple", tolerance=1e-2)
def _t_triple(rig):
    praise = "Less than a second: the whole time in which a controller can do something."
    return _fall(growth(load("triple")), growth(load("double")), praise)


def _fall(growth, other, praise):
    ratio, fast = LEANS[1] / LEANS[0], growth[0]
    yield np.log(ratio) / fast, praise
    yield np.log(ratio) / other[0], "That is the other pendulum; t_double first, then t_triple."
    for slower in growth[1:]:
        yield np.log(ratio) / slower, "That is a slower way to fall; take the largest eigenvalue."
    for logarithm in (np.log10, np.log2):
        base = "The exponential has base e: take the natural logarithm."
        yield logarithm(ratio) / fast, base
    yield 1 / fast, "That is the time for a factor e; here the factor is 0.3 / 0.01."
    yield np.log(2) / fast, "That is the time for a factor 2; here the factor is 0.3 / 0.01."
    yield np.log(LEANS[1]) / -fast, "Growth starts at 0.01 rad, not at 1 rad."
    yield np.log(ratio) * fast, "Solve 0.01 e^(s t) = 0.3 for t: divide by s."
    rest = "That is a start at rest. In the mode the rates belong to it."
    yield np.arccosh(ratio) / fast, rest


@on("double")
def exercise_3(bend_5, rig=None):
    """Bending angle at which the double's linear acceleration is 5 % wrong, rad."""
    return _bend_5(np.abs(array("bend_5", bend_5)), rig)  # bent either way, by symmetry


@asks("bend_5", tolerance=2e-2)  # two digits
def _bend_5(rig):
    A, f = linearize(rig).A, nonlinear(rig)

    def where(share=0.05, shape=(0, 1), relative_to=1, entries=slice(None)):
        def error(angle):
            x = angle * np.array([*shape, 0.0, 0.0])
            rates = (A @ x)[entries], f(x, 0.0)[entries]
            return np.linalg.norm(rates[0] - rates[1]) / np.linalg.norm(rates[relative_to])

        return brentq(lambda angle: error(angle) - share, 1e-3, 1.5)

    yield where(), "Now hold it against the lean."
    for turned in ((1, 0), (1, -1)):
        yield where(shape=turned), "There theta1 differs from 0: it leans, or link 1 turns alone."
    near = "A little too large. The truth is the nonlinear model, and the error is that of both "
    yield where(relative_to=0), near + "accelerations together, by their norm."
    alone = "That is where the acceleration of link 1 alone is 5 % wrong; take the norm of both."
    yield where(entries=[2]), alone
    yield where(0.005), "That is 0.5 %."
    yield where(0.5), "That is 50 %."


@on("double")
@asks("f_in")
def exercise_4(rig):
    """Cut-off of an input filter that makes both filters' delay two samples, Hz."""
    own, output = rig.filters.input_hz[0], rig.filters.output_hz[0]

    def cut_off(delay):
        return 1 / (2 * np.pi * delay)

    delay = cut_off(output)  # the same formula gives the delay of a cut-off
    truth = cut_off(SAMPLES - delay)
    yield truth, "A faster filter gives back delay that no controller can."
    whole = "That uses up both samples in the input filter; the output filter delays too."
    yield cut_off(SAMPLES), whole
    yield cut_off(SAMPLES / 2 - delay), "That makes one sample in all; two are asked for."
    yield 2 * np.pi * truth, "That is in rad/s; cut-offs are in Hz."
    yield cut_off(SAMPLES + delay), "That makes both delays together more than 20 ms."
    yield 1 / SAMPLES - output, "Delays add, cut-offs do not."
    yield own, "That is the filter that the rig has."
    yield output, "That is the output filter."


@on("double")
def exercise_5(A_20=None, B_20=None, rig=None):
    """The double sampled every 20 ms."""
    return all_right(_A_20(A_20, rig), _B_20(B_20, rig))


@asks("A_20", tolerance=5e-4)  # four digits
def _A_20(rig):
    plant = linearize(rig)
    A = sample(plant, SAMPLES / 2).A
    yield sample(plant, SAMPLES).A, None
    yield A, HALF.format("A_20")
    yield 2 * A, "Two steps one after the other multiply; they do not add."
    yield A * A, "`*` multiplies entry by entry; matrices multiply with `@`."
    yield plant.A, CONTINUOUS.format("A_20")
    euler = np.eye(len(A)) + SAMPLES * plant.A
    yield euler, "That is Euler's step, true for short times only."
    yield expm(plant.A * 20), "20 ms are 0.020 s."


@asks("B_20", tolerance=5e-4)
def _B_20(rig):
    plant = linearize(rig)
    once = sample(plant, SAMPLES / 2)
    A, B = once.A, once.B
    praise = "No exponential needed: the sampled model knows all about its own samples."
    yield sample(plant, SAMPLES).B, praise
    yield B, HALF.format("B_20")
    moves = "What the first sample did moves on during the second one: it is multiplied."
    yield 2 * B, moves
    yield A @ B, "That is the first sample's share; the second sample adds its own."
    yield A @ A @ B, "u acts from the first sample on; count the steps after it."
    yield plant.B, CONTINUOUS.format("B_20")
    late = "One step too many: u acts during the first and the second sample."
    yield A @ A @ B + A @ B, late


@on("triple")
@asks("volts", tolerance=1e-2)  # two digits
def exercise_6(rig):
    """Limit at which motor 1 alone catches what both catch at their limits, V."""
    limits = np.array(rig.u_max)
    together, middle, upper = (_largest_lean(rig, motors) for motors in ([0, 1], [0], [1]))
    truth = limits[0] * together[0] / middle[0]
    yield truth, "The paper's larger power source."
    yield together[0] / middle[0], "That is the factor; of how many volts?"
    yield truth - limits[0], "That is how much has to be added; give the whole limit."
    yield limits[1] * together[0] / upper[0], "That is motor 2 alone."
    yield limits[0] * together[2] / middle[2], "That is for the last angle; take theta1."
    apart = "Volts of different motors do not add up: they bend different hinges."
    yield limits.sum(), apart


def _largest_lean(rig, motors):
    """Largest value of each angle alone, at rest, that the motors can still catch, rad."""
    plant, limits = linearize(rig), np.array(rig.u_max)[motors]
    s, V = np.linalg.eig(plant.A)
    falling = s.real > 0
    left = np.linalg.inv(V).real[falling]
    reach = np.abs(left @ plant.B[:, motors]) @ limits / s.real[falling]
    return (reach[:, None] / np.abs(left[:, : rig.n_links])).min(axis=0)
