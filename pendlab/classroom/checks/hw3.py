"""Homework 3: a Kalman filter against the recovery with H = 0."""

from dataclasses import replace

import control
import numpy as np
from scipy.linalg import solve_discrete_are

from ..._arguments import found, number
from ...bench.imperfections import Imperfections
from ...bench.simulation import simulate
from ...gain import weights
from ...loop import broken_at, closed_loop_eigenvalues, margins
from .acceptance import (
    NOISE,
    design_noise,
    modulus_margins,
    noise_rms,
    reference,
    too_noisy,
    unstable,
)
from .judging import compare, judged, on

KP = 5.0
BAD, BETTER, QUIETER = 0.1, 1.35, 0.15
SHAKES = 0.4  # of the reference's noise, simulated
LEAN, REST = 0.01, 0.005  # rad
V = np.diag(NOISE**2)


def kalman_gain(model, W, V=V):
    """M of xhat = x_predicted + M (y - C x_predicted)."""
    A, C = model.A, model.C
    X = solve_discrete_are(A.T, C.T, W, V)
    return X @ C.T @ np.linalg.inv(C @ X @ C.T + V)


def compensator(design, W):
    """P of u = -P y from the design's F and the Kalman filter for W."""
    model = design.model
    A, B, C, M = model.A, model.B, model.C, kalman_gain(model, W)
    F = design.controller.F
    n, q = len(A), len(C)
    Fx, Fw = F[:, :n], F[:, n:]
    keep = np.eye(n) - M @ C
    out, direct = np.hstack([Fx @ keep, Fw]), Fx @ M
    inputs = np.vstack([B, np.zeros((1, B.shape[1]))])
    own = np.block([[A @ keep, np.zeros((n, 1))], [np.zeros((1, n)), np.ones((1, 1))]])
    into = np.vstack([A @ M, -design.dt * np.eye(q)[[1]]])
    return control.ss(own - inputs @ out, into - inputs @ direct, out, direct, design.dt)


def loop_of(P, model):
    loop = control.series(model, P)
    return control.ss(loop.A, loop.B, loop.C, 0, model.dt)


@on("triple", who="your name")
def exercise_1(M, rig=None):
    model = reference(rig, KP).model
    W = model.B @ model.B.T
    truth = kalman_gain(model, W)
    unsquared = kalman_gain(model, W, np.diag(NOISE))
    return compare(
        "M",
        M,
        truth,
        mistakes=[
            (model.A @ truth, "This is A M, the gain of the prediction; the reading of this sample may "
             "already be used."),
            (unsquared, "V holds variances, the squares of the standard deviations."),
        ],
        tolerance=2e-2,  # two digits, as four decimals show of the smallest
        each=True,
    )  # fmt: skip


@on("triple", who="your name")
@judged
def exercise_2(P, rig=None):
    design = reference(rig, KP)
    W = design.model.B @ design.model.B.T

    yield wrong_compensator(P, design)
    yield turned(P, design)
    yield unstable(loop_of(P, design.model), "without filters")
    A, C = design.model.A, design.model.C
    estimator = np.linalg.eigvals((np.eye(len(A)) - kalman_gain(design.model, W) @ C) @ A)
    state = closed_loop_eigenvalues(design.state_feedback_loop)
    found = np.linalg.eigvals(closed(P, design.model))
    for name, wanted in (("state feedback", state), ("the estimator", estimator)):
        missing = max(np.abs(found - value).min() for value in wanted)
        if missing > 1e-4:
            yield (
                f"The loop is stable, but an eigenvalue of {name} is missing among those of "
                f"the closed loop (nearest {missing:.2g} off): separation must hold. Which u "
                "moves your prediction?"
            )
    return "State feedback and estimator, side by side."


def closed(P, model):
    loop = loop_of(P, model)
    return loop.A - loop.B @ loop.C


def turned(P, design):
    """Unstable as it is, stable with the other sign."""
    largest = [np.abs(np.linalg.eigvals(closed(p, design.model))).max() for p in (P, -P)]
    if largest[1] < 1 <= largest[0]:
        return "Stable with -P, not with P: the convention is u = -P y."
    return None


def wrong_compensator(P, design):
    if not isinstance(P, control.StateSpace):
        return f"Expected P as a control.StateSpace from y to u, found {type(P).__name__}."
    model = design.model
    if (P.noutputs, P.ninputs) != (model.ninputs, model.noutputs):
        return (
            f"P takes {model.noutputs} readings and gives {model.ninputs} voltages, yours takes "
            f"{P.ninputs} and gives {P.noutputs}."
        )
    if not np.isclose(P.dt, model.dt):
        return f"P should be sampled at {model.dt} s, yours has dt = {P.dt}."
    return None


def process_noise(W, design):
    return weights("W", W, design.model.nstates)


@on("triple", who="your name")
@judged
def exercise_3(W, rig=None):
    design = reference(rig, KP)
    W = process_noise(W, design)
    recovered = modulus_margins(design, filters=False)[0]
    P = compensator(design, W)

    yield not_semidefinite(W)
    yield unstable(loop_of(P, design.model), "without filters")
    found = margins(broken_at(loop_of(P, design.model), 0)).modulus
    if found > BAD * recovered:
        yield (
            f"The modulus margin at input 1 is {found:.3f}, state feedback has {recovered:.3f}; "
            f"find a W for which less than {BAD:.0%} of it is left. Does your filter expect large "
            "disturbances exactly where the motors act?"
        )
    return "An optimal gain, an optimal filter, and hardly any margin left."


def not_semidefinite(W):
    if np.linalg.eigvalsh(W)[0] < -1e-9 * np.abs(W).max():
        return "W is a covariance: it must have no negative eigenvalue."
    return None


@on("triple", who="your name")
@judged
def exercise_4(W, rig=None):
    design = reference(rig, KP)
    W = process_noise(W, design)
    P = compensator(design, W)
    loop = loop_of(P, design.filtered)
    limit = QUIETER * design_noise(design)[0]
    least = modulus_margins(design)

    def found(i):
        return margins(broken_at(loop, i))

    yield not_semidefinite(W)
    yield unstable(loop)
    for i, wanted in enumerate((BETTER * least[0], least[1])):
        if found(i).modulus < wanted:
            yield (
                f"With filters the modulus margin at input {i + 1} is {found(i).modulus:.3f}, "
                f"{wanted:.3f} is asked for; nearest to -1 at "
                f"{found(i).modulus_omega / (2 * np.pi):.2f} Hz."
            )
    yield too_noisy(noise_rms(P, design.filtered)[0], limit)
    return (
        f"Margins {found(0).modulus:.3f} and {found(1).modulus:.3f} at "
        f"{noise_rms(P, design.filtered)[0]:.2f} V of noise; H = 0 with E = diag(0.9, 0.9) has "
        f"{least[0]:.3f} and {least[1]:.3f} at {design_noise(design)[0]:.2f} V."
    )


@on("triple", who="your name")
@judged
def exercise_5(controller, rig=None):
    design = reference(rig, KP)
    if not callable(getattr(controller, "step", None)):
        yield f"Expected an object with step(state, y, y_ref), {found(controller)}."
    yield _remembers_in_self(controller)
    bench = Imperfections(filters=True, saturation=True)
    calm = simulate(rig, controller, 6, [LEAN, 0, 0], imperfections=bench, dt=design.dt)
    with_noise = replace(bench, noise=tuple(NOISE))
    noisy = simulate(rig, controller, 10, imperfections=with_noise, dt=design.dt)
    for run, start in ((calm, f"from a lean of {LEAN} rad"), (noisy, "with noise")):
        if run.fell:
            yield f"The pendulum falls {start}, after {run.fell_at:.2f} s."
    yield _no_integrator(controller, design)
    late = np.abs(calm.angles[calm.t > 5]).max()
    if late > REST:
        yield f"After 5 s the angles still reach {late:.4f} rad, {REST} is asked for."
    shaking = noisy.u[100:, 0].std()
    limit = SHAKES * design_noise(design)[0]
    yield too_noisy(number("voltage", shaking), limit)
    yield _unlimited(controller, rig)
    return f"It stands, and motor 1 shakes with {noisy.u[100:, 0].std():.2f} V."


def _first(controller):
    """The state before the first sample of a pendulum that stands upright."""
    start = getattr(controller, "start", None)
    return None if start is None else start(np.zeros(6))


def _remembers_in_self(controller):
    y, begin = np.array([1e-3, -2e-3, 1e-3, 0.0]), _first(controller)
    u, state = controller.step(begin, y, 0.0)
    controller.step(state, -y, 0.0)
    if not np.array_equal(u, controller.step(begin, y, 0.0)[0]):
        return (
            "Equal calls of step gave different voltages: keep what must be remembered in the "
            "state that step returns, not in self."
        )
    return None


def _no_integrator(controller, design):
    """Whether a reference, after one sample, moves the voltages as -F_w T_s does."""
    y, wish = np.zeros(4), 0.01
    states = [controller.step(_first(controller), y, r)[1] for r in (0.0, wish)]
    plain, moved = (np.asarray(controller.step(state, y, 0.0)[0]) for state in states)
    if np.allclose(moved - plain, -wish * design.dt * design.controller.F[:, -1], 1e-3, 1e-12):
        return None
    if np.allclose(moved, plain, rtol=0, atol=1e-12):
        return "A reference never reaches your voltages: where is w, with w(n+1) = w + T_s (y_ref - y2)?"
    return "A reference moves your voltages, but not by -F_w T_s y_ref a sample later: look at w again."


def _unlimited(controller, rig):
    """Whether the prediction is told more voltage than the motors get.

    Such a controller is linear behind its first sample, however far off that is: a second reading
    that undoes the first one for small angles then leaves no voltage at all.
    """
    zero, far, small, begin = np.zeros(4), np.array([0.5, 0, 0, 0]), 1e-6, _first(controller)

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
