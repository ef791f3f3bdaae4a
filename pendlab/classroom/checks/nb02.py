"""Checks of notebook 02: the rotor, the fall, filters, sampling, power sources."""

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq

from ..._arguments import array
from ...models import linearize, nonlinear
from ...parameters import load
from ...sampled import sample
from .judging import all_right, compare, on

SAMPLES = 0.02  # s, two samples of 10 ms
LEANS = (0.01, 0.3)  # rad, from and to


@on("double", own="'02.1', rotor, share, rig=own")
def exercise_1(rotor=None, share=None, rig=None):
    """Inertia of the bare rotor, kg m^2, and the reflected one by the upper link's about its hinge."""
    motor, lower, upper = rig.motors[0], *rig.links
    about_hinge = upper.inertia + upper.mass * upper.com**2
    return all_right(
        compare(
            "rotor",
            rotor,
            motor.inertia / motor.ratio**2,
            [
                (motor.inertia, "That is the reflected inertia; the bare rotor's is smaller."),
                (motor.inertia / motor.ratio, "Energy goes with the square of the rate, so not k."),
                (
                    motor.inertia * motor.ratio**2,
                    "The rotor turns faster than the shaft: is it the reflected inertia that is larger, or the bare one?",
                ),
            ],
        ),
        compare(
            "share",
            share,
            motor.inertia / about_hinge,
            [
                (
                    motor.inertia / upper.inertia,
                    "That is about link 2's centre of mass; J2 is about its hinge.",
                ),
                (
                    motor.inertia / (upper.mass * upper.com**2),
                    "J2 has a second term, the link's own inertia.",
                ),
                (
                    motor.inertia / (lower.inertia + lower.mass * lower.com**2),
                    "That is link 1; the upper link is `links[1]`.",
                ),
                (
                    motor.inertia / motor.ratio**2 / about_hinge,
                    "That is the bare rotor; at the hinge its reflected inertia counts.",
                ),
                (
                    motor.inertia / (motor.inertia + about_hinge),
                    "That is the share of the sum; divide by J2 alone.",
                ),
            ],
            praise="Small, but it spins fast: at the hinge it weighs like a good part of the link.",
        ),
    )


def exercise_2(t_double=None, t_triple=None, rig=None):
    """Time in which the fastest unstable mode grows from 0.01 to 0.3 rad, double and triple, s."""
    double, triple = (_growth(load(name)) for name in ("double", "triple"))
    praise = "Less than a second: the whole time in which a controller can do something."
    return all_right(
        _fall("t_double", t_double, double, triple),
        _fall("t_triple", t_triple, triple, double, praise),
    )


@on("double")
def exercise_3(bend_5, rig=None):
    """Bending angle at which the double's linear acceleration is 5 % wrong, rad."""
    A, f = linearize(rig).A, nonlinear(rig)

    def where(share, shape, relative_to=1):
        def error(angle):
            x = angle * np.array([*shape, 0.0, 0.0])
            rates = A @ x, f(x, 0.0)
            return np.linalg.norm(rates[0] - rates[1]) / np.linalg.norm(rates[relative_to])

        return brentq(lambda angle: error(angle) - share, 1e-3, 1.5)

    truth = where(0.05, (0, 1))
    return compare(
        "bend_5",
        np.abs(array("bend_5", bend_5)),  # bent either way, by symmetry
        truth,
        [
            *(
                (
                    where(0.05, turned),
                    "There theta1 differs from 0: it leans, or link 1 turns alone.",
                )
                for turned in ((1, 0), (1, -1))
            ),
            (
                where(0.05, (0, 1), 0),
                "Your error is relative to the linear model; take the nonlinear one as the truth.",
            ),
            (where(0.005, (0, 1)), "That is 0.5 %."),
            (where(0.5, (0, 1)), "That is 50 %."),
        ],
        tolerance=2e-2,  # two digits
        praise="Bending is trusted less far than leaning.",
    )


@on("double")
def exercise_4(f_in, rig=None):
    """Cut-off of an input filter that makes both filters' delay two samples, Hz."""
    own, output = rig.filters.input_hz[0], rig.filters.output_hz[0]
    delay = 1 / (2 * np.pi * output)
    return compare(
        "f_in",
        f_in,
        1 / (2 * np.pi * (SAMPLES - delay)),
        [
            (
                1 / (2 * np.pi * SAMPLES),
                "That uses up both samples in the input filter; the output filter delays too.",
            ),
            (
                1 / (2 * np.pi * (SAMPLES / 2 - delay)),
                "That makes one sample in all; two are asked for.",
            ),
            (1 / (SAMPLES - delay), "That is in rad/s; cut-offs are in Hz."),
            (
                1 / (2 * np.pi * (SAMPLES + delay)),
                "That makes both delays together more than 20 ms.",
            ),
            (1 / SAMPLES - output, "Delays add, cut-offs do not."),
            (own, "That is the filter that the rig has."),
            (output, "That is the output filter."),
        ],
        tolerance=5e-3,
        praise="A faster filter gives back delay that no controller can.",
    )


@on("double")
def exercise_5(A_20=None, B_20=None, rig=None):
    """The double sampled every 20 ms."""
    plant = linearize(rig)
    once, twice = sample(plant, SAMPLES / 2), sample(plant, SAMPLES)
    A, B = once.A, once.B
    continuous = "belongs to the continuous model; the sampled one is asked for."
    half = "is still that of one sample of 10 ms."
    return all_right(
        compare(
            "A_20",
            A_20,
            twice.A,
            [
                (A, f"A_20 {half}"),
                (2 * A, "Two steps one after the other multiply; they do not add."),
                (A * A, "`*` multiplies entry by entry; matrices multiply with `@`."),
                (plant.A, f"A_20 {continuous}"),
                (
                    np.eye(len(A)) + SAMPLES * plant.A,
                    "That is Euler's step, true for short times only.",
                ),
                (expm(plant.A * 20), "20 ms are 0.020 s."),
            ],
            tolerance=5e-4,  # four digits
        ),
        compare(
            "B_20",
            B_20,
            twice.B,
            [
                (B, f"B_20 {half}"),
                (
                    2 * B,
                    "What the first sample did moves on during the second one: it is multiplied.",
                ),
                (A @ B, "That is the first sample's share; the second sample adds its own."),
                (A @ A @ B, "u acts from the first sample on; count the steps after it."),
                (plant.B, f"B_20 {continuous}"),
                (
                    A @ A @ B + A @ B,
                    "One step too many: u acts during the first and the second sample.",
                ),
            ],
            tolerance=5e-4,  # four digits
            praise="No exponential needed: the sampled model knows all about its own samples.",
        ),
    )


@on("triple")
def exercise_6(volts, rig=None):
    """Limit at which the middle motor alone catches what both catch at their limits, V."""
    limits = np.array(rig.u_max)
    together, middle, upper = (_largest_lean(rig, motors) for motors in ([0, 1], [0], [1]))
    truth = limits[0] * together[0] / middle[0]
    return compare(
        "volts",
        volts,
        truth,
        [
            (together[0] / middle[0], "That is the factor; of how many volts?"),
            (truth - limits[0], "That is how much has to be added; give the whole limit."),
            (limits[1] * together[0] / upper[0], "That is the upper motor alone."),
            (limits[0] * together[2] / middle[2], "That is for the last angle; take theta1."),
            (limits.sum(), "Volts of different motors do not add up: they bend different hinges."),
        ],
        tolerance=1e-2,  # two digits
        praise="The paper's larger power source.",
    )


def _growth(rig):
    """The unstable eigenvalues of a rig, the fastest first, 1/s."""
    values = linearize(rig).poles().real
    return np.sort(values[values > 0])[::-1]


def _fall(name, answer, growth, other, praise="That is what we find too."):
    ratio, fast = LEANS[1] / LEANS[0], growth[0]
    slow = "That is a slower way to fall; take the largest eigenvalue."
    return compare(
        name,
        answer,
        np.log(ratio) / fast,
        [
            (
                np.log(ratio) / other[0],
                "That is the other pendulum; t_double first, then t_triple.",
            ),
            *((np.log(ratio) / value, slow) for value in growth[1:]),
            (np.log10(ratio) / fast, "The exponential has base e: take the natural logarithm."),
            (np.log2(ratio) / fast, "The exponential has base e: take the natural logarithm."),
            (1 / fast, "That is the time for a factor e; here the factor is 0.3 / 0.01."),
            (np.log(2) / fast, "That is the time for a factor 2; here the factor is 0.3 / 0.01."),
            (np.log(LEANS[1]) / -fast, "Growth starts at 0.01 rad, not at 1 rad."),
            (np.log(ratio) * fast, "Solve 0.01 e^(s t) = 0.3 for t: divide by s."),
            (
                np.arccosh(ratio) / fast,
                "That is a start at rest. In the mode the rates belong to it.",
            ),
        ],
        tolerance=1e-2,  # two digits
        praise=praise,
    )


def _largest_lean(rig, motors):
    """Largest value of each angle alone, at rest, that the motors can still catch, rad."""
    plant, limits = linearize(rig), np.array(rig.u_max)[motors]
    s, V = np.linalg.eig(plant.A)
    falling = s.real > 0
    left = np.linalg.inv(V).real[falling]
    reach = np.abs(left @ plant.B[:, motors]) @ limits / s.real[falling]
    return (reach[:, None] / np.abs(left[:, : rig.n_links])).min(axis=0)
