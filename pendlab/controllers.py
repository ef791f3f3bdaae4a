"""The sampled controller: observer, integrator and state feedback, equations (29), (30), (38)."""

from dataclasses import dataclass
from typing import NamedTuple

import control
import numpy as np
from scipy.linalg import block_diag

from ._arguments import array, found, instance, number, numbers, whole
from .observers import Observer


class ControllerState(NamedTuple):
    """State between two samples: observer v and integrators w."""

    v: np.ndarray
    w: np.ndarray


@dataclass(frozen=True, eq=False)
class Controller:
    """Observer-based state feedback with integral action.

    v(n+1) = E v(n) + H u(n) + K y(n),   w(n+1) = w(n) + Ts (y_r(n) - y_tracked(n))
    xhat(n) = L1 y(n) + L2 v(n),         u(n) = -F [xhat(n); w(n)]

    Parameters
    ----------
    F : (m, n + number of integrators)
    observer : Observer for the n-state model with m inputs
    dt : sampling time Ts, s
    tracked : indices of the outputs that track references, one integrator each
    u_max : m voltage limits of step 4, or None

    The functions `start` and `step` keep no state of their own: equal calls give equal results.

    >>> paper = pl.paper_design("double").controller
    >>> u, state = paper.step(paper.start(), [0.01, 0, 0])
    >>> u.round(3)
    array([1.923])
    """

    F: np.ndarray
    observer: Observer
    dt: float
    tracked: tuple = (1,)
    u_max: tuple | None = None

    def __post_init__(self):
        set_ = object.__setattr__
        instance("observer", self.observer, Observer)
        number("dt", self.dt, above=0)
        n, m, q = self.observer.T.shape[1], self.observer.H.shape[1], self.observer.K.shape[1]
        tracked = self.tracked if isinstance(self.tracked, (tuple, list)) else (self.tracked,)
        tracked = tuple(whole("tracked", index, most=q - 1) for index in tracked)
        if len(set(tracked)) < len(tracked):
            raise ValueError(f"tracked: each output takes one integrator, {found(tracked)}.")
        set_(self, "tracked", tracked)
        set_(self, "F", array("F", self.F, (m, n + len(tracked))))
        if self.u_max is not None:
            set_(self, "u_max", numbers("u_max", self.u_max, above=0, count=m, finite=False))

    @property
    def system(self):
        """control.StateSpace from y to u, so that u = -P(z) y with P(z) of equation (31)."""
        o, n = self.observer, len(self.observer.L1)
        p, q, m, integrators = len(o.E), o.K.shape[1], len(self.F), len(self.tracked)
        C = -np.hstack([self.F[:, :n] @ o.L2, self.F[:, n:]])
        D = -self.F[:, :n] @ o.L1  # u = C [v; w] + D y
        A = block_diag(o.E, np.eye(integrators))
        B = np.vstack([o.K, -self.dt * np.eye(q)[list(self.tracked)]])
        H = np.vstack([o.H, np.zeros((integrators, m))])
        labels = dict(
            states=[f"v{i + 1}" for i in range(p)] + [f"w{i + 1}" for i in range(integrators)],
            inputs=[f"y{i + 1}" for i in range(q)],
            outputs=[f"u{i + 1}" for i in range(m)],
        )
        return control.ss(A + H @ C, B + H @ D, C, D, self.dt, name="controller", **labels)

    def start(self, x0=None):
        """State before the first sample: v(0) = T x(0) and w(0) = 0; x0 defaults to upright."""
        n = self.observer.T.shape[1]
        x0 = np.zeros(n) if x0 is None else array("x0", x0, (n,))
        return ControllerState(self.observer.T @ x0, np.zeros(len(self.tracked)))

    def estimate(self, state, y):
        """xhat(n) = L1 y(n) + L2 v(n): step 2."""
        return self.observer.L1 @ self._outputs(state, y) + self.observer.L2 @ state.v

    def control(self, state, y):
        """u(n) = -F [xhat(n); w(n)] within the limits: steps 2 to 4 of section 5."""
        u = -(self.F @ np.concatenate([self.estimate(state, y), state.w]))
        if self.u_max is not None:
            u = np.minimum(np.maximum(u, np.negative(self.u_max)), self.u_max)
        return u

    def update(self, state, y, u, y_ref=0.0):
        """Observer and integrator at the next sample: step 6."""
        o, y = self.observer, self._outputs(state, y)
        y_ref = array("y_ref", y_ref)
        if y_ref.ndim:
            y_ref = array("y_ref", y_ref, (len(self.tracked),))
        u = array("u", u, (len(self.F),))
        v = o.E @ state.v + o.H @ u + o.K @ y
        w = state.w + self.dt * (y_ref - y[list(self.tracked)])
        return ControllerState(v, w)

    def step(self, state, y, y_ref=0.0):
        """(u, next state): steps 2 to 6 of section 5; y_ref: a number, or one per tracked output."""
        u = self.control(state, y)
        return u, self.update(state, y, u, y_ref)

    def _outputs(self, state, y):
        instance("state", state, ControllerState, "controller.start()")
        return array("y", y, (self.observer.K.shape[1],))


def controller(F, observer, dt=0.01, tracked=1, kp=None, *, u_max=None):
    """The paper's `Controller` from a gain and an observer.

    F is the gain of `pl.lqr`, the rest as for `Controller`. With k_p of motor 2's position loop
    (`kp`, V/rad) F has one row less and is given the row [k_p C_p C, 0] of equation (38).

    >>> triple = pl.paper_design("triple")
    >>> pl.controller(triple.F, triple.observer, kp=10).F.shape
    (2, 7)
    """
    instance("observer", observer, Observer)
    F = array("F", F, (None, None))
    if kp is not None:
        # The estimate repeats the measured angles exactly; the last of m motors drives hinge m+1,
        # whose angle is state number m counted from 0.
        F = np.vstack([F, number("kp", kp) * np.eye(1, F.shape[1], observer.H.shape[1])])
    return Controller(F, observer, dt, tracked, u_max)
