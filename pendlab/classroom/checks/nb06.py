"""Checks of notebook 06: slow modes, delay, statics, noise, units of the singular value."""

import numpy as np
from scipy.optimize import brentq

import pendlab as pl

from ...models import matrices
from .judging import asks


@asks("tau")
def exercise_1(rig):
    """Time constant (s) of the double's slowest closed-loop mode, with filters."""
    double, triple = (pl.paper_design(name).filtered_loop for name in ("double", "triple"))
    tau = pl.time_constant(double)
    yield tau, None
    yield pl.time_constant(triple), "That is the triple; the double is asked for."
    yield tau / double.dt, "That is in samples; how many seconds are they?"
    yield tau * np.log(2), "That is the time to halve; tau is the time to fall to 1/e."
    fastest = -double.dt / np.log(np.abs(pl.closed_loop_eigenvalues(double)[-1]))
    yield fastest, "That is the fastest mode; the slowest is nearest to the circle."


@asks("delay")
def exercise_2(rig):
    """Extra delay (s) at motor 2 that the paper's loop with filters bears."""
    design = pl.paper_design("triple")

    def delay(index=1, filters=True):
        loop = design.loop(index, filters)
        crossover = np.array(pl.margins(loop).crossover)
        L = pl.frequency_response(loop, crossover)[:, 0, 0]
        return float((np.angle(-L) % (2 * np.pi) / crossover).min())  # a lag turns clockwise

    yield delay(), None
    yield delay(filters=False), "That is the loop without filters; the finished rig has them."
    yield delay(index=0), "That is input 1; the delay sits before motor 2."
    m = pl.margins(design.loop(1, filters=True))
    yield m.phase, "That is the phase margin in rad; at which frequency, and so what time?"
    yield np.degrees(m.phase) / m.phase_omega, "The phase margin must be in rad, to go with rad/s."


@asks("lean", base="triple")
def exercise_3(rig):
    """Lean of link 1 (rad) that balances relative angles of 0.3 rad at both upper hinges."""
    moments = -np.diag(matrices(rig)[3]) / rig.g
    steps = 0.3 * np.arange(rig.n_links)

    def lean(moments=moments, steps=steps):
        return brentq(lambda lean: moments @ np.sin(lean + steps), -1.5, 1.5)

    yield lean(), None
    small = "Nearly: the sines were replaced by their angles. Solve it without that."
    yield -moments @ steps / moments.sum(), small
    relative = "Link 3 stands at theta1 + 0.3 + 0.3 from upright: relative angles add up."
    yield lean(steps=np.minimum(steps, 0.3)), relative
    hang = "The upper links hang on the lower ones: their masses times l1, l2 belong to M1, M2."
    yield lean([link.mass * link.com for link in rig.links]), hang


@asks("u2_rms")
def exercise_4(rig):
    """RMS voltage (V) of the paper's motor 2 from 1 mrad of noise on theta3 - theta2."""
    design, noise, sensor = pl.paper_design("triple"), 1e-3, "noise theta3-theta2"
    loop, ideal = (pl.closed_loop(design, filters) for filters in (True, False))
    path = loop["u2", sensor]
    yield pl.rms(path, noise)[0], None
    at_once = "That goes out at once, whatever the pendulum does; use the closed loop."
    yield design.kp * noise, at_once
    yield pl.rms(loop["u1", sensor], noise)[0], "That is motor 1."
    every = "Only one of the three potentiometers is noisy."
    yield pl.rms(loop["u2", loop.input_labels[:3]], noise)[0], every
    yield pl.rms(ideal["u2", sensor], noise)[0], "That is without filters."
    yield pl.peak_gain(path)[0] * noise, "That is the worst sine; white noise asks for the RMS."


@asks("sigma_shares")
def exercise_5(rig):
    """Smallest sigma_min of the paper's I + P G with the inputs in shares of their limits."""
    design = pl.paper_design("triple")
    omega = pl.frequency_grid(design.dt, 3000)
    D = np.diag(1 / np.array(design.rig.u_max))

    def least(left=D, loop=design.nominal_loop):
        Rd = np.eye(2) + pl.frequency_response(loop, omega)
        return np.linalg.svd(left @ Rd @ np.linalg.inv(left), compute_uv=False)[:, -1].min()

    yield least(), None
    side = "D stands on the wrong side: write u = -L u with u = D^-1 times the new inputs."
    yield least(np.linalg.inv(D)), side
    yield least(np.eye(2)), "That is still in volts."
    yield least(loop=design.filtered_loop), "That is with filters."
    structured = "That is the structured margin, which does not depend on units; sigma_min does."
    yield pl.structured_margin(design.nominal_loop).value, structured
