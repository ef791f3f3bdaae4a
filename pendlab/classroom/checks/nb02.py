"""Checks of notebook 02: the rotor, the fall, filters, sampling, power sources."""

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq

import pendlab as pl

from ..._arguments import array
from .judging import asks, on
from .nb00 import growth

SAMPLES = 0.02  # s, two samples of 10 ms
LEANS = (0.01, 0.3)  # rad, from and to
CONTINUOUS = "{} belongs to the continuous model; the sampled one is asked for."
HALF = "{} is still that of one sample of 10 ms."


@asks("rotor", "share", base="double", own="'02.1', rotor, share, rig=own")
def exercise_1(rig):
    """Inertia of the bare rotor, kg m^2, and the reflected one over J2."""
    motor, (lower, upper) = rig.motors[0], rig.links
    reflected, bare = motor.inertia, motor.inertia / motor.ratio**2
    hinge, lower_hinge = (link.inertia + link.mass * link.com**2 for link in (upper, lower))
    yield bare, None
    yield reflected, "That is the reflected inertia; the bare rotor's is smaller."
    yield reflected / motor.ratio, "Energy goes with the square of the rate, so not k."
    faster = "The rotor turns faster than the shaft: is it the reflected inertia that is larger?"
    yield reflected * motor.ratio**2, faster

    yield "share"
    praise = "Small, but it spins fast: at the hinge it weighs like a good part of the link."
    yield reflected / hinge, praise
    centre = "That is about link 2's centre of mass; J2 is about its hinge."
    yield reflected / upper.inertia, centre
    term = "J2 has a second term, the link's own inertia."
    yield reflected / (upper.mass * upper.com**2), term
    yield reflected / lower_hinge, "That is link 1; link 2 is `links[1]`."
    yield bare / hinge, "That is the bare rotor; at the hinge its reflected inertia counts."
    yield reflected / (reflected + hinge), "That is the share of the sum; divide by J2 alone."


@asks("t_double", "t_triple", tolerance=1e-2)  # two digits
def exercise_2(rig):
    """Time in which the fastest unstable mode grows from 0.01 to 0.3 rad, double and triple, s."""
    double, triple = (growth(pl.load(name)) for name in ("double", "triple"))
    yield from _fall(double, triple, None)
    yield "t_triple"
    praise = "Less than a second: the whole time in which a controller can do something."
    yield from _fall(triple, double, praise)


def _fall(growth, other, praise):
    ratio, fast = LEANS[1] / LEANS[0], growth[0]
    yield np.log(ratio) / fast, praise
    yield np.log(ratio) / other[0], "That is the other pendulum; t_double first, then t_triple."
    for slower in growth[1:]:
        yield np.log(ratio) / slower, "That is a slower way to fall; take the largest eigenvalue."
    for logarithm in (np.log10, np.log2):
        yield logarithm(ratio) / fast, "The exponential has base e: take the natural logarithm."
    yield 1 / fast, "That is the time for a factor e; here the factor is 0.3 / 0.01."
    yield np.log(2) / fast, "That is the time for a factor 2; here the factor is 0.3 / 0.01."
    yield np.log(LEANS[1]) / -fast, "Growth starts at 0.01 rad, not at 1 rad."
    yield np.log(ratio) * fast, "Solve 0.01 e^(s t) = 0.3 for t: divide by s."
    rest = "That is a start at rest. In the mode the rates belong to it."
    yield np.arccosh(ratio) / fast, rest


@on("double")
def exercise_3(bend_5, rig=None):
    """Bending angle at which the double's linear acceleration is 5 % wrong, rad."""
    return _bend_5(np.abs(array("bend_5", bend_5)), rig=rig)  # bent either way, by symmetry


@asks("bend_5", tolerance=2e-2)  # two digits
def _bend_5(rig):
    A, f = pl.linearize(rig).A, pl.nonlinear(rig)

    def where(share=0.05, shape=(0, 1), relative_to=1, entries=slice(None)):
        def error(angle):
            x = angle * np.array([*shape, 0.0, 0.0])
            rates = (A @ x)[entries], f(x, 0.0)[entries]
            return np.linalg.norm(rates[0] - rates[1]) / np.linalg.norm(rates[relative_to])

        return brentq(lambda angle: error(angle) - share, 1e-3, 1.5)

    yield where(), "Now hold it against the lean."
    for turned in ((1, 0), (1, -1)):
        yield where(shape=turned), "There theta1 differs from 0: it leans, or link 1 turns alone."
    near = """A little too large. The truth is the nonlinear model, and the error is that of both
        accelerations together, by their norm."""
    yield where(relative_to=0), near
    alone = "That is where the acceleration of link 1 alone is 5 % wrong; take the norm of both."
    yield where(entries=[2]), alone
    yield where(0.005), "That is 0.5 %."
    yield where(0.5), "That is 50 %."


@asks("f_in", base="double")
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


@asks("A_20", "B_20", base="double", tolerance=5e-4)  # four digits
def exercise_5(rig):
    """The double sampled every 20 ms."""
    plant = pl.linearize(rig)
    once, twice = pl.sample(plant, SAMPLES / 2), pl.sample(plant, SAMPLES)
    A, B = once.A, once.B
    yield twice.A, None
    yield A, HALF.format("A_20")
    yield 2 * A, "Two steps one after the other multiply; they do not add."
    yield A * A, "`*` multiplies entry by entry; matrices multiply with `@`."
    yield plant.A, CONTINUOUS.format("A_20")
    yield np.eye(4) + SAMPLES * plant.A, "That is Euler's step, true for short times only."
    yield expm(plant.A * 20), "20 ms are 0.020 s."

    yield "B_20"
    yield twice.B, "No exponential needed: the sampled model knows all about its own samples."
    yield B, HALF.format("B_20")
    yield 2 * B, "What the first sample did moves on during the second one: it is multiplied."
    yield A @ B, "That is the first sample's share; the second sample adds its own."
    yield A @ A @ B, "u acts from the first sample on; count the steps after it."
    yield plant.B, CONTINUOUS.format("B_20")
    late = "One step too many: u acts during the first and the second sample."
    yield A @ A @ B + A @ B, late


@asks("volts", base="triple", tolerance=1e-2)  # two digits
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
    yield limits.sum(), "Volts of different motors do not add up: they bend different hinges."


def _largest_lean(rig, motors):
    """Largest value of each angle alone, at rest, that the motors can still catch, rad."""
    plant, limits = pl.linearize(rig), np.array(rig.u_max)[motors]
    s, V = np.linalg.eig(plant.A)
    falling = s.real > 0
    left = np.linalg.inv(V).real[falling]
    reach = np.abs(left @ plant.B[:, motors]) @ limits / s.real[falling]
    return (reach[:, None] / np.abs(left[:, : rig.n_links])).min(axis=0)
