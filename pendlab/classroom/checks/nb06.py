"""Checks of notebook 06: slow modes, delay, statics, noise, units of the singular value."""

import numpy as np
from scipy.optimize import brentq

from ...loop import closed_loop_eigenvalues, frequency_grid, frequency_response, margins
from ...models import equations
from ...paper.designs import paper_design
from ...studies.structured import structured_margin
from ...studies.transmission import closed_loop, peak_gain, rms
from .judging import compare, on


def exercise_1(answer, rig=None):
    """Time constant (s) of the double's slowest closed-loop mode, with filters."""
    design = paper_design("double")
    constants = lambda loop: -design.dt / np.log(np.abs(closed_loop_eigenvalues(loop)))  # noqa: E731
    tau = constants(design.filtered_loop)
    triple = constants(paper_design("triple").filtered_loop)[0]
    return compare(
        "tau",
        answer,
        tau[0],
        mistakes=[
            (triple, "That is the triple; the double is asked for."),
            (tau[0] / design.dt, "That is in samples; how many seconds are they?"),
            (tau[0] * np.log(2), "That is the time to halve; tau is the time to fall to 1/e."),
            (tau[-1], "That is the fastest mode; the slowest is nearest to the circle."),
        ],
    )


def exercise_2(answer, rig=None):
    """Extra delay (s) at motor 2 that the paper's loop with filters bears."""
    design = paper_design("triple")

    def delay(index, filters):
        loop = design.loop(index, filters)
        crossover = np.array(margins(loop).crossover)
        L = frequency_response(loop, crossover)[:, 0, 0]
        return float((np.angle(-L) % (2 * np.pi) / crossover).min())  # a lag turns clockwise

    m = margins(design.loop(1, filters=True))
    return compare(
        "delay",
        answer,
        delay(1, True),
        mistakes=[
            (delay(1, False), "That is the loop without filters; the finished rig has them."),
            (delay(0, True), "That is input 1; the delay sits before motor 2."),
            (m.phase, "That is the phase margin in rad; at which frequency, and so what time?"),
            (
                np.degrees(m.phase) / m.phase_omega,
                "The phase margin must be in rad: tau = phi/omega.",
            ),
        ],
        tolerance=5e-3,
    )


@on("triple")
def exercise_3(answer, rig=None):
    """Lean of link 1 (rad) that balances relative angles of 0.3 rad at both upper hinges."""
    motion, values = equations(rig)
    P = np.asarray(motion.linear(*values)[3], dtype=float)
    moments = -np.diag(P) / rig.g
    steps = 0.3 * np.arange(rig.n_links)
    moment = lambda lean, at: moments @ np.sin(lean + at)  # noqa: E731
    truth = brentq(moment, -1.5, 1.5, args=(steps,))
    relative = np.minimum(steps, 0.3)  # 0.3 twice instead of 0.3 and 0.6
    small = -moments @ steps / moments.sum()
    no_lever = np.array([link.mass * link.com for link in rig.links])
    return compare(
        "lean",
        answer,
        truth,
        mistakes=[
            (small, "Nearly: the sines were replaced by their angles. Solve it without that."),
            (
                brentq(moment, -1.5, 1.5, args=(relative,)),
                "Link 3 stands at theta1 + 0.3 + 0.3 from upright: relative angles add up.",
            ),
            (
                brentq(lambda x: no_lever @ np.sin(x + steps), -1.5, 1.5),
                "The upper links hang on the lower ones: their masses times l1, l2 belong to M1, M2.",
            ),
        ],
    )


def exercise_4(answer, rig=None):
    """RMS voltage (V) of the paper's motor 2 from 1 mrad of noise on theta3 - theta2."""
    design, noise = paper_design("triple"), 1e-3
    loop = closed_loop(design)
    path = loop["u2", "noise theta3-theta2"]
    angles = loop.input_labels[:3]
    return compare(
        "u2_rms",
        answer,
        rms(path, noise)[0],
        mistakes=[
            (
                design.kp * noise,
                "That is what goes out at once. The pendulum answers, the sensor sees it, and the "
                "noise goes round the loop again: use the closed loop.",
            ),
            (rms(loop["u1", "noise theta3-theta2"], noise)[0], "That is motor 1."),
            (rms(loop["u2", angles], noise)[0], "Only one of the three potentiometers is noisy."),
            (
                rms(closed_loop(design, filters=False)["u2", "noise theta3-theta2"], noise)[0],
                "That is without filters.",
            ),
            (peak_gain(path)[0] * noise, "That is the worst sine; white noise asks for the RMS."),
        ],
        tolerance=5e-3,
    )


def exercise_5(answer, rig=None):
    """Smallest sigma_min of the paper's I + P G_f with the inputs in shares of their limits."""
    design = paper_design("triple")
    omega = frequency_grid(design.dt, 3000)
    D = np.diag(1 / np.array(design.rig.u_max))

    def least(left, loop):
        Rd = np.eye(2) + frequency_response(loop, omega)
        return np.linalg.svd(left @ Rd @ np.linalg.inv(left), compute_uv=False)[:, -1].min()

    return compare(
        "sigma_shares",
        answer,
        least(D, design.filtered_loop),
        mistakes=[
            (
                least(np.linalg.inv(D), design.filtered_loop),
                "D stands on the wrong side: write u = -L u with u = D^-1 times the new inputs.",
            ),
            (least(np.eye(2), design.filtered_loop), "That is still in volts."),
            (least(D, design.nominal_loop), "That is without filters."),
            (
                structured_margin(design.filtered_loop).value,
                "That is the structured margin, which does not depend on units; sigma_min does.",
            ),
        ],
        tolerance=5e-3,
    )
