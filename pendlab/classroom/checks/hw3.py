"""Homework 3: a Kalman filter against the recovery with H = 0."""

from dataclasses import replace

import control
import numpy as np
from scipy.linalg import solve_discrete_are

import pendlab as pl

from ..._arguments import found, number
from ...gain import weights
from . import acceptance
from .judging import asks

RIG = dict(base="triple", who="your name")
KP = 5.0
BAD, BETTER, QUIETER = 0.1, 1.35, 0.15
SHAKES = 0.4  # of the reference's noise, simulated
LEAN, REST = 0.01, 0.005  # rad
V = np.diag(acceptance.NOISE**2)


def kalman_gain(model, W, V=V):
    """M of xhat = x_predicted + M (y - C x_predicted)."""
    C = model.C
    X = solve_discrete_are(model.A.T, C.T, W, V)
    return X @ C.T @ np.linalg.inv(C @ X @ C.T + V)


def kalman_filter(model, W, V=V):
    """The filter as an observer of all states, which uses the reading of this sample."""
    A, B, M = model.A, model.B, kalman_gain(model, W, V)
    T = np.eye(len(A)) - M @ model.C
    return pl.Observer(T @ A, T @ B, T, T @ A @ M, M, np.eye(len(A)))


def compensator(design, W):
    """P of u = -P y from the design's F and the Kalman filter for W."""
    return -pl.Controller(design.controller.F, kalman_filter(design.model, W), design.dt).system


@asks("M", tolerance=2e-2, each=True)
def exercise_1(rig):
    """Gain of the Kalman filter for W = B B', to two digits, as four decimals show of the smallest."""
    model = acceptance.reference(rig, KP).model
    W = model.B @ model.B.T
    yield kalman_gain(model, W), None
    ahead = "This is A M, the prediction's gain; the reading of this sample may be used already."
    yield model.A @ kalman_gain(model, W), ahead
    squares = "V holds variances, the squares of the standard deviations."
    yield kalman_gain(model, W, np.diag(acceptance.NOISE)), squares


def exercise_2(P, rig):
    """The compensator, with the eigenvalues that separation promises."""
    design = acceptance.reference(rig, KP)
    model = design.model
    yield wrong_compensator(P, model)
    loop, turned, A = pl.open_loop(-P, model), pl.open_loop(P, model), model.A
    if acceptance.unstable(loop) and not acceptance.unstable(turned):
        yield "Stable with -P, not with P: the convention is u = -P y."
    yield acceptance.unstable(loop, "without filters")
    M = kalman_gain(model, model.B @ model.B.T)
    estimator = np.linalg.eigvals((np.eye(len(A)) - M @ model.C) @ A)
    state = pl.closed_loop_eigenvalues(design.state_feedback_loop)
    for name, wanted in (("state feedback", state), ("the estimator", estimator)):
        distances = np.abs(np.subtract.outer(wanted, pl.closed_loop_eigenvalues(loop)))
        missing = distances.min(axis=1).max()
        if missing > 1e-4:
            yield f"""The loop is stable, but an eigenvalue of {name} is missing among those of the
                closed loop (nearest {missing:.2g} off): separation must hold. Which u moves your
                prediction?"""
    return "Now say which eigenvalue is which."


def wrong_compensator(P, model):
    if not isinstance(P, control.StateSpace):
        return f"Expected P as a control.StateSpace from y to u, {found(P)}."
    if (P.noutputs, P.ninputs) != (model.ninputs, model.noutputs):
        return f"""P takes {model.noutputs} readings and gives {model.ninputs} voltages, yours takes
            {P.ninputs} and gives {P.noutputs}."""
    if not np.isclose(P.dt, model.dt):
        return f"P should be sampled at {model.dt} s, yours has dt = {P.dt}."
    return None


def not_semidefinite(W):
    negative = np.linalg.eigvalsh(W)[0] < -1e-9 * np.abs(W).max()
    return "W is a covariance: it must have no negative eigenvalue." if negative else None


def exercise_3(W, rig):
    """A process covariance whose filter leaves hardly any margin."""
    design = acceptance.reference(rig, KP)
    W = weights("W", W, design.model.nstates)
    yield not_semidefinite(W)
    loop = pl.open_loop(-compensator(design, W), design.model)
    yield acceptance.unstable(loop, "without filters")
    left = pl.margins(pl.broken_at(loop, 0)).modulus
    recovered, _ = acceptance.modulus_margins(design, filters=False)
    if left > BAD * recovered:
        yield f"""The modulus margin at input 1 is {left:.3f}, state feedback has {recovered:.3f};
            find a W for which less than {BAD:.0%} of it is left. Does your filter expect large
            disturbances exactly where the motors act?"""
    return "An optimal gain, an optimal filter, and hardly any margin left."


def exercise_4(W, rig):
    """A process covariance whose filter is quiet and keeps its distance."""
    design = acceptance.reference(rig, KP)
    W = weights("W", W, design.model.nstates)
    yield not_semidefinite(W)
    P = compensator(design, W)
    loop, least = pl.open_loop(-P, design.filtered), acceptance.modulus_margins(design)
    yield acceptance.unstable(loop)
    broken = [pl.broken_at(loop, i) for i in (0, 1)]
    yield acceptance.small_margins(design, (BETTER * least[0], least[1]), broken)
    mine, theirs = acceptance.noise_volts(P, design.filtered), acceptance.design_noise(design)
    yield acceptance.too_noisy(mine, QUIETER * theirs)
    first, second = (pl.margins(part).modulus for part in broken)
    return f"""Margins {first:.3f} and {second:.3f} at {mine:.2f} V of noise; H = 0 with
        E = diag(0.9, 0.9) has {least[0]:.3f} and {least[1]:.3f} at {theirs:.2f} V."""


def exercise_5(controller, rig):
    """A filter on the pendulum, with limits, integrator and memory where they belong."""
    design = acceptance.reference(rig, KP)
    if isinstance(controller, type) or not callable(getattr(controller, "step", None)):
        yield f"Expected an object with step(state, y, y_ref), {found(controller)}."
    y = np.array([1e-3, -2e-3, 1e-3, 0.0])
    yield acceptance.remembers_in_self(controller, np.zeros(6), y, 2)
    real, dt = acceptance.REAL, design.dt
    calm = pl.simulate(rig, controller, 6, [LEAN, 0, 0], imperfections=real, dt=dt)
    real = replace(real, noise=tuple(acceptance.NOISE))
    noisy = pl.simulate(rig, controller, 10, imperfections=real, dt=dt)
    yield acceptance.fallen(calm, f"From a lean of {LEAN} rad")
    yield acceptance.fallen(noisy, "With noise")
    yield _no_integrator(controller, design)
    late = np.abs(calm.angles[calm.t > 5]).max()
    if late > REST:
        yield f"After 5 s the angles still reach {late:.4f} rad, {REST} is asked for."
    shaking = number("voltage", noisy.u[100:, 0].std())
    yield acceptance.too_noisy(shaking, SHAKES * acceptance.design_noise(design))
    yield _unlimited(controller, rig)
    return f"It stands, and motor 1 shakes with {shaking:.2f} V."


def _after(controller, first, second, reference=0.0):
    """The voltages at a second sample."""
    begin = acceptance.first_state(controller, np.zeros(6))
    _, state = controller.step(begin, first, reference)
    return np.asarray(controller.step(state, second, 0.0)[0], dtype=float)


def _no_integrator(controller, design):
    """Whether a reference, after one sample, moves the voltages as -F_w T_s does."""
    y, wish = np.zeros(4), 0.01
    plain, moved = (_after(controller, y, y, reference) for reference in (0.0, wish))
    if np.allclose(moved - plain, -wish * design.dt * design.controller.F[:, -1], 1e-3, 1e-12):
        return None
    if np.allclose(moved, plain, rtol=0, atol=1e-12):
        return "No reference reaches your voltages: where is w, with w(n+1) = w + T_s (y_ref - y2)?"
    return "A reference moves the voltages, not by -F_w T_s y_ref a sample later: look at w again."


def _unlimited(controller, rig):
    """Whether the prediction is told more voltage than the motors get.

    Such a controller is linear behind its first sample, however far off that is: a second reading
    that undoes the first one for small angles then leaves no voltage at all.
    """
    zero, far, small, limits = np.zeros(4), np.array([0.5, 0, 0, 0]), 1e-6, np.array(rig.u_max)
    begin = acceptance.first_state(controller, np.zeros(6))
    if np.any(np.abs(controller.step(begin, far, 0.0)[0]) > limits + 1e-9):
        return "step returns voltages beyond the limits; clip them to rig.u_max first."
    memory = _after(controller, small * far, zero) / small
    reading = [_after(controller, zero, small * unit) / small for unit in np.eye(4)]
    undone = _after(controller, far, -np.linalg.lstsq(np.transpose(reading), memory, rcond=None)[0])
    if np.all(np.abs(undone) < 1e-3 * limits):
        return "The prediction is told the voltage that you wanted; which one did the motor get?"
    return None
