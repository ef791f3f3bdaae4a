"""Homework 3: a Kalman filter against the recovery with H = 0."""

from dataclasses import replace

import control
import numpy as np
from scipy.linalg import solve_discrete_are

from ..._arguments import found, number
from ...bench.simulation import simulate
from ...controllers import Controller
from ...gain import weights
from ...loop import broken_at, closed_loop_eigenvalues, margins, open_loop
from ...observers import Observer
from .acceptance import (
    NOISE,
    REAL,
    design_noise,
    fallen,
    first_state,
    modulus_margins,
    noise_rms,
    reference,
    remembers_in_self,
    small_margins,
    too_noisy,
    unstable,
)
from .judging import asks, on

KP = 5.0
BAD, BETTER, QUIETER = 0.1, 1.35, 0.15
SHAKES = 0.4  # of the reference's noise, simulated
LEAN, REST = 0.01, 0.005  # rad
V = np.diag(NOISE**2)


def kalman_gain(model, W, V=V):
    """M of xhat = x_predicted + M (y - C x_predicted)."""
    C = model.C
    X = solve_discrete_are(model.A.T, C.T, W, V)
    return X @ C.T @ np.linalg.inv(C @ X @ C.T + V)


def kalman_filter(model, W, V=V):
    """The filter as an observer of all states, which uses the reading of this sample."""
    A, B, M = model.A, model.B, kalman_gain(model, W, V)
    T = np.eye(len(A)) - M @ model.C
    return Observer(T @ A, T @ B, T, T @ A @ M, M, np.eye(len(A)))


def compensator(design, W):
    """P of u = -P y from the design's F and the Kalman filter for W."""
    return -Controller(design.controller.F, kalman_filter(design.model, W), design.dt).system


@on("triple", who="your name")
@asks("M", tolerance=2e-2, each=True)  # two digits, as four decimals show of the smallest
def exercise_1(rig):
    """Gain of the Kalman filter for W = B B'."""
    model = reference(rig, KP).model
    W = model.B @ model.B.T
    yield kalman_gain(model, W), None
    prediction = (
        "This is A M, the prediction's gain; the reading of this sample may be used already."
    )
    yield model.A @ kalman_gain(model, W), prediction
    squares = "V holds variances, the squares of the standard deviations."
    yield kalman_gain(model, W, np.diag(NOISE)), squares


@on("triple", who="your name")
def exercise_2(P, rig=None):
    """The compensator, with the eigenvalues that separation promises."""
    design = reference(rig, KP)
    yield wrong_compensator(P, design)
    yield turned(P, design)
    yield unstable(open_loop(-P, design.model), "without filters")
    A, B, C = design.model.A, design.model.B, design.model.C
    estimator = np.linalg.eigvals((np.eye(len(A)) - kalman_gain(design.model, B @ B.T) @ C) @ A)
    state = closed_loop_eigenvalues(design.state_feedback_loop)
    found = closed_loop_eigenvalues(open_loop(-P, design.model))
    for name, wanted in (("state feedback", state), ("the estimator", estimator)):
        missing = max(np.abs(found - value).min() for value in wanted)
        if missing > 1e-4:
            yield (
                f"The loop is stable, but an eigenvalue of {name} is missing among those of "
                f"the closed loop (nearest {missing:.2g} off): separation must hold. Which u "
                "moves your prediction?"
            )
    return "Now say which eigenvalue is which."


def turned(P, design):
    """Unstable as it is, stable with the other sign."""
    if unstable(open_loop(-P, design.model)) and not unstable(open_loop(P, design.model)):
        return "Stable with -P, not with P: the convention is u = -P y."
    return None


def wrong_compensator(P, design):
    if not isinstance(P, control.StateSpace):
        return f"Expected P as a control.StateSpace from y to u, {found(P)}."
    model = design.model
    if (P.noutputs, P.ninputs) != (model.ninputs, model.noutputs):
        return (
            f"P takes {model.noutputs} readings and gives {model.ninputs} voltages, yours takes "
            f"{P.ninputs} and gives {P.noutputs}."
        )
    if not np.isclose(P.dt, model.dt):
        return f"P should be sampled at {model.dt} s, yours has dt = {P.dt}."
    return None


def not_semidefinite(W):
    if np.linalg.eigvalsh(W)[0] < -1e-9 * np.abs(W).max():
        return "W is a covariance: it must have no negative eigenvalue."
    return None


@on("triple", who="your name")
def exercise_3(W, rig=None):
    """A process covariance whose filter leaves hardly any margin."""
    design = reference(rig, KP)
    W = weights("W", W, design.model.nstates)
    yield not_semidefinite(W)
    loop = open_loop(-compensator(design, W), design.model)
    yield unstable(loop, "without filters")
    left, recovered = margins(broken_at(loop, 0)).modulus, modulus_margins(design, filters=False)[0]
    if left > BAD * recovered:
        yield (
            f"The modulus margin at input 1 is {left:.3f}, state feedback has {recovered:.3f}; "
            f"find a W for which less than {BAD:.0%} of it is left. Does your filter expect large "
            "disturbances exactly where the motors act?"
        )
    return "An optimal gain, an optimal filter, and hardly any margin left."


@on("triple", who="your name")
def exercise_4(W, rig=None):
    """A process covariance whose filter is quiet and keeps its distance."""
    design = reference(rig, KP)
    W = weights("W", W, design.model.nstates)
    yield not_semidefinite(W)
    P = compensator(design, W)
    loop, least = open_loop(-P, design.filtered), modulus_margins(design)
    yield unstable(loop)
    broken = [broken_at(loop, i) for i in (0, 1)]
    yield small_margins(design, (BETTER * least[0], least[1]), broken)
    mine, theirs = noise_rms(P, design.filtered)[0], design_noise(design)[0]
    yield too_noisy(mine, QUIETER * theirs)
    first, second = (margins(part).modulus for part in broken)
    return (
        f"Margins {first:.3f} and {second:.3f} at {mine:.2f} V of noise; H = 0 with "
        f"E = diag(0.9, 0.9) has {least[0]:.3f} and {least[1]:.3f} at {theirs:.2f} V."
    )


@on("triple", who="your name")
def exercise_5(controller, rig=None):
    """A filter on the pendulum, with limits, integrator and memory where they belong."""
    design = reference(rig, KP)
    if isinstance(controller, type) or not callable(getattr(controller, "step", None)):
        yield f"Expected an object with step(state, y, y_ref), {found(controller)}."
    yield remembers_in_self(controller, np.zeros(6), np.array([1e-3, -2e-3, 1e-3, 0.0]), 2)
    calm = simulate(rig, controller, 6, [LEAN, 0, 0], imperfections=REAL, dt=design.dt)
    with_noise = replace(REAL, noise=tuple(NOISE))
    noisy = simulate(rig, controller, 10, imperfections=with_noise, dt=design.dt)
    yield fallen(calm, f"From a lean of {LEAN} rad")
    yield fallen(noisy, "With noise")
    yield _no_integrator(controller, design)
    late = np.abs(calm.angles[calm.t > 5]).max()
    if late > REST:
        yield f"After 5 s the angles still reach {late:.4f} rad, {REST} is asked for."
    shaking = number("voltage", noisy.u[100:, 0].std())
    yield too_noisy(shaking, SHAKES * design_noise(design)[0])
    yield _unlimited(controller, rig)
    return f"It stands, and motor 1 shakes with {shaking:.2f} V."


def _no_integrator(controller, design):
    """Whether a reference, after one sample, moves the voltages as -F_w T_s does."""
    y, wish, begin = np.zeros(4), 0.01, first_state(controller, np.zeros(6))
    states = [controller.step(begin, y, r)[1] for r in (0.0, wish)]
    plain, moved = (np.asarray(controller.step(state, y, 0.0)[0]) for state in states)
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
    zero, far, small = np.zeros(4), np.array([0.5, 0, 0, 0]), 1e-6
    begin = first_state(controller, np.zeros(6))

    def after(first, second):
        state = controller.step(begin, first, 0.0)[1]
        return np.asarray(controller.step(state, second, 0.0)[0], dtype=float)

    if np.any(np.abs(controller.step(begin, far, 0.0)[0]) > np.array(rig.u_max) + 1e-9):
        return "step returns voltages beyond the limits; clip them to rig.u_max first."
    memory = after(small * far, zero) / small
    reading = np.column_stack([after(zero, small * unit) / small for unit in np.eye(4)])
    undone = after(far, -np.linalg.lstsq(reading, memory, rcond=None)[0])
    if np.all(np.abs(undone) < 1e-3 * np.array(rig.u_max)):
        return "The prediction is told the voltage that you wanted; which one did the motor get?"
    return None
