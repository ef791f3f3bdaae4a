"""Reduced-order observers with H = TB = 0: all of them, as a null space (section 3)."""

from dataclasses import dataclass
from functools import cached_property

import control
import numpy as np
from scipy.linalg import null_space, solve_discrete_lyapunov, solve_sylvester
from scipy.optimize import minimize

from ._arguments import array, plain, state_space


@dataclass(frozen=True, eq=False)
class Observer:
    """Reduced-order observer, equation (4), with p states, m inputs, q outputs, n estimates.

    v(n+1) = E v(n) + H u(n) + K y(n),   xhat(n) = L1 y(n) + L2 v(n)

    Parameters
    ----------
    E, H, K : (p, p), eigenvalues inside the unit circle; (p, m); (p, q)
    T : (p, n), v estimates T x
    L1, L2 : (n, q), (n, p), the inverse of [C; T], equation (7)

    >>> pl.paper_design("double").observer.T.round(2)  # (24)
    array([[-0.2 ,  0.96, -0.15, -0.1 ]])
    """

    E: np.ndarray
    H: np.ndarray
    T: np.ndarray
    K: np.ndarray
    L1: np.ndarray
    L2: np.ndarray

    def __post_init__(self):
        set_ = object.__setattr__
        set_(self, "E", dynamics(self.E))
        p = len(self.E)
        for name in "HTK":
            set_(self, name, array(name, getattr(self, name), (p, None)))
        n, q = self.T.shape[1], self.K.shape[1]
        set_(self, "L1", array("L1", self.L1, (n, q)))
        set_(self, "L2", array("L2", self.L2, (n, p)))

    def residuals(self, model):
        """Largest entries of TA - ET - KC, H - TB and [L1 L2][C; T] - I for `model`."""
        state_space("model", model, sampled=True)
        n, q = self.L1.shape
        A, C = array("model.A", model.A, (n, n)), array("model.C", model.C, (q, n))
        B = array("model.B", model.B, (n, self.H.shape[1]))
        return {
            "TA - ET - KC": float(np.abs(self.T @ A - self.E @ self.T - self.K @ C).max()),
            "H - TB": float(np.abs(self.H - self.T @ B).max()),
            "L1 C + L2 T - I": float(np.abs(self.L1 @ C + self.L2 @ self.T - np.eye(len(A))).max()),
        }

    def noise_gain(self, F=None):
        """Standard deviation of xhat, or of F xhat, per unit of white noise in every reading.

        sqrt(trace(G (L1 L1' + L2 W L2') G')) with W = E W E' + K K' and G = F, or I: the H2 norm from
        y to xhat, or to the voltages that a gain F (m, n) makes of it. Unlike the condition of
        [C; T], it does not depend on the units of v: (X T, X K) with X E = E X has the same.

        >>> round(pl.paper_design("double", 2).observer.noise_gain())  # in SI units
        52
        """
        G = np.eye(len(self.L1)) if F is None else array("F", F, (None, len(self.L1)))
        if np.abs(G).max(initial=0.0) > 1e100:
            raise ValueError("F: expected entries up to 1e100, found larger ones.")
        return float(_noise_gain(self.E, self.K, G @ self.L1, G @ self.L2))


def _noise_gain(E, K, L1, L2):
    W = solve_discrete_lyapunov(E, K @ K.T)
    return np.sqrt(np.sum(L1**2) + np.trace(L2 @ W @ L2.T))


def dynamics(E, p=1):
    """E as a stable p x p matrix, from a number, the p diagonal entries or the matrix."""
    E = array("E", E)
    if E.size == 0:
        raise ValueError("E: expected the dynamics of at least one observer state, found none.")
    if E.ndim == 0:
        E = np.full(max(p, 1), E)
    E = np.diag(E) if E.ndim == 1 else array("E", E, (len(E), len(E)))
    radius = np.abs(np.linalg.eigvals(E)).max()
    if radius >= 1:
        raise ValueError(
            "E: the observer's eigenvalues must lie inside the unit circle, found one of "
            f"magnitude {radius:.4g}; choose magnitudes below 1 (the paper: 0.9)."
        )
    return E


def _sized(model, E):
    """`dynamics` of as many states as the outputs of a sampled model leave to estimate."""
    n, q = state_space("model", model, sampled=True).nstates, model.noutputs
    if n <= q:
        raise ValueError(
            f"model: {q} outputs leave none of {n} states to estimate; no observer is needed."
        )
    E = dynamics(E, n - q)
    if len(E) != n - q:
        raise ValueError(
            f"E: {n} states and {q} outputs leave {n - q} to estimate, so E must be "
            f"{n - q} x {n - q}, found {len(E)} x {len(E)}."
        )
    return E


def observer(model, E, T, K):
    """The `Observer` with H = TB and [L1 L2] the inverse of [C; T], equations (5)-(7).

    ValueError where [C; T] is singular to working precision or TA - ET = KC is not met.

    >>> model = control.ss([[1.2, 1], [0, 0.5]], [[0], [1]], [[0.6, 1]], 0, 0.01)
    >>> pl.observer(model, 0.6, [[1, 0]], [[1]]).L2.round(3)
    array([[ 1. ],
           [-0.6]])
    """
    E = _sized(model, E)
    A, B, C = model.A, model.B, model.C
    T = array("T", T, (len(E), model.nstates))
    K = array("K", K, (len(E), model.noutputs))
    gap = np.abs(T @ A - E @ T - K @ C).max()
    if gap > 1e-7 * (np.abs(T) @ np.abs(A) + np.abs(E @ T) + np.abs(K) @ np.abs(C)).max():
        raise ValueError(
            f"T, K: TA - ET = KC must hold, found a gap of {gap:.3g}; the nearest that do are "
            "family.member(family.project(T, K)) with family = pl.observer_family(model, E)."
        )
    stacked = np.vstack([C, T])
    # Rows of T scale freely and states have units: neither decides what counts as singular.
    columns = np.maximum(np.abs(stacked).max(axis=0), 1e-300)
    sizes = np.maximum(np.linalg.norm(stacked / columns, axis=1), 1e-300)
    rows = stacked / columns / sizes[:, None]
    if np.linalg.svd(rows, compute_uv=False)[-1] < 1e-10:
        raise ValueError("T: [C; T] is singular and (7) unsolvable; take another of the family.")
    inverse = np.linalg.inv(rows)
    inverse[np.abs(inverse) < 1e-14 * np.abs(inverse).max()] = 0.0
    inverse = inverse / sizes / columns[:, None]
    H = T @ B
    H[np.abs(H) < 1e-12 * np.linalg.norm(T, axis=1, keepdims=True) * np.abs(B).max()] = 0.0
    return Observer(E, H, T, K, inverse[:, : len(C)], inverse[:, len(C) :])


def luenberger(model, E, K):
    """The reduced-order observer for a chosen K: T from TA - ET = KC, and H = TB as it comes.

    Unique when E and A share no eigenvalue; H is zero only for special K.

    >>> pl.luenberger(pl.paper_design("double").model, 0.9, [[1, 2, 3]]).H.round(4)
    array([[0.6115]])
    """
    E = _apart(model, _sized(model, E))
    K = array("K", K, (len(E), model.noutputs))
    if not 0 < np.abs(K).max() < 1e100:
        raise ValueError("K: expected entries up to 1e100, not all zero (T = 0), found others.")
    return observer(model, E, solve_sylvester(-E, model.A, K @ model.C), K)


@dataclass(frozen=True, eq=False)
class ObserverFamily:
    """All (T, K) of `model` and E with TA - ET = KC and TB = 0: the null space of S, equation (12).

    S alpha = 0, where alpha holds the rows of T, then those of K. The orthonormal rows of `basis`,
    (dimension, p (n + q)), are canonical: the same on every machine.
    """

    model: control.StateSpace
    E: np.ndarray
    S: np.ndarray
    basis: np.ndarray

    @property
    def dimension(self):
        return len(self.basis)

    def split(self, alpha):
        """T (p, n) and K (p, q) from the vector alpha."""
        p, n = len(self.E), self.model.nstates
        alpha = array("alpha", alpha, (self.basis.shape[1],))
        return alpha[: p * n].reshape(p, n), alpha[p * n :].reshape(p, self.model.noutputs)

    def member(self, coefficients):
        """The `Observer` with alpha = coefficients . basis; ValueError where [C; T] is singular."""
        coefficients = array("coefficients", coefficients, (self.dimension,))
        if not 0 < np.abs(coefficients).max() < 1e100:
            raise ValueError(
                "coefficients: expected sizes up to 1e100, not all zero, found others; "
                "with zeros alone T = 0 and [C; T] is singular."
            )
        T, K = self.split(coefficients @ self.basis)
        return observer(self.model, self.E, T, K)

    def project(self, T, K):
        """Coefficients of the member nearest to (T, K) in the least-squares sense."""
        return self.basis @ self._alpha(T, K)

    def distance(self, T, K):
        """Distance of (T, K) from the null space, relative to the size of (T, K)."""
        alpha = self._alpha(T, K)
        alpha = alpha / (np.abs(alpha).max() or 1.0)
        residual = alpha - self.basis.T @ (self.basis @ alpha)
        return float(np.linalg.norm(residual) / max(np.linalg.norm(alpha), 1e-300))

    def _alpha(self, T, K):
        T = array("T", T, (len(self.E), self.model.nstates))
        K = array("K", K, (len(self.E), self.model.noutputs))
        return np.concatenate([T.ravel(), K.ravel()])

    def condition(self, coefficients):
        """Condition number of [C; T] at `coefficients` (any size of them)."""
        c = array("coefficients", coefficients, (self.dimension,))
        T, _ = self.split(c @ self.basis)
        return float(np.linalg.cond(np.vstack([self.model.C, T])))

    def _cost(self, c):
        """Log of the noise gain; by a trace of the condition, the best description of that observer."""
        T, K = self.split(c @ self.basis)
        try:
            inverse = np.linalg.inv(np.vstack([self.model.C, T]))
        except np.linalg.LinAlgError:
            return 1e3
        q = len(self.model.C)
        noise = _noise_gain(self.E, K, inverse[:, :q], inverse[:, q:])
        cost = np.log(noise) + 1e-6 * np.log(self.condition(c))
        return cost if np.isfinite(cost) else 1e3

    @cached_property
    def _best(self):
        starts = np.random.default_rng(0).standard_normal((8 * self.dimension, self.dimension))
        start = min(starts, key=self._cost)
        options = dict(xatol=1e-10, fatol=1e-12, maxiter=4000, maxfev=8000)
        return minimize(self._cost, start, method="Nelder-Mead", options=options).x

    def best(self):
        """The quietest member: least `Observer.noise_gain`, so least noise from the readings to xhat."""
        return self.member(self._best)


def observer_family(model, E):
    """The `ObserverFamily` of `model` with dynamics E: all reduced-order ones with H = TB = 0.

    S alpha = 0 with S = [[I x A' - E x I, -I x C'], [I x B', 0]] (x: Kronecker product).

    With H = 0 the input need not be known: these are unknown-input observers. One with [C; T]
    regular needs rank CB = m, and every invariant zero of (A, B, C) among the eigenvalues of E, so
    inside the circle. The dimension is p (q - m) iff no eigenvalue of E is an invariant zero.

    `model` is sampled with n states, m inputs and q outputs; E belongs to the n - q observer states:
    a number for all, the diagonal entries or the matrix (complex pairs as real 2 x 2 blocks).
    ValueError where E is unstable, of the wrong size or shares an eigenvalue with A, and where no
    solution has H = 0 and [C; T] regular.

    Sources: equations (5)-(7) and (12) of the paper; Kudva, Viswanadham and Ramakrishna 1980;
    Hautus 1983; Darouach, Zasadzinski and Xu 1994.

    >>> pl.observer_family(pl.paper_design("double").model, 0.9).dimension
    2
    """
    E = _apart(model, _sized(model, E))
    S = kronecker_matrix(model.A, model.B, model.C, E)
    family = ObserverFamily(model, E, S, canonical_basis(_null_rows(S)))
    try:
        family.member(np.random.default_rng(1).standard_normal(family.dimension))
    except ValueError:
        raise ValueError(_why_none(model, E, family.dimension)) from None
    return family


def _null_rows(S):
    """Orthonormal rows that span the null space of S, whatever the units of its rows and columns."""
    rows = S / np.maximum(np.linalg.norm(S, axis=1, keepdims=True), 1e-300)
    sizes = np.maximum(np.linalg.norm(rows, axis=0), 1e-300)
    return np.linalg.qr(null_space(rows / sizes, rcond=1e-10) / sizes[:, None])[0].T


def _why_none(model, E, dimension):
    """Which condition for an observer with H = 0 and [C; T] regular is not met."""
    m, rank = model.ninputs, np.linalg.matrix_rank(model.C @ model.B)
    none = "every T with H = TB = 0 leaves [C; T] singular"
    if dimension == 0:
        none = "no observer with H = TB = 0 exists"
    why = "every invariant zero of (A, B, C) must be an eigenvalue of E, and E as free as T"
    if rank < m:
        why = f"rank CB must be {m}, the number of inputs, found {rank}"
    advice = "change E, or use pl.luenberger(model, E, K) with H as it comes"
    return f"E: {none} for this model and E: {why}; {advice}."


def kronecker_matrix(A, B, C, E):
    """S of equation (12) for alpha = [rows of T, rows of K]."""
    I_E, I_A = np.eye(len(E)), np.eye(len(A))
    p, q, m = len(E), len(C), B.shape[1]
    upper = [np.kron(I_E, A.T) - np.kron(E, I_A), -np.kron(I_E, C.T)]  # TA - ET - KC = 0
    lower = [np.kron(I_E, B.T), np.zeros((p * m, p * q))]  # TB = 0
    return np.block([upper, lower])


def canonical_basis(rows):
    """An orthonormal basis of the span of orthonormal `rows` that depends on the span alone.

    Gram-Schmidt over the columns of the projector onto the span, largest remaining column first
    (the earlier one where two agree to nine digits), each vector's largest entry positive.
    """
    projector = rows.T @ rows
    basis = []
    for _ in range(len(rows)):
        sizes = np.linalg.norm(projector, axis=0)
        pivot = int(np.argmax(sizes > sizes.max() * (1 - 1e-9)))
        vector = projector[:, pivot] / sizes[pivot]
        basis.append(vector)
        projector = projector - np.outer(vector, vector)
        projector = (projector + projector.T) / 2
    return np.array(basis).reshape(len(rows), rows.shape[1])


def _apart(model, E):
    """E, if no eigenvalue of A is one of its own."""
    for value in np.linalg.eigvals(E):
        if np.abs(np.linalg.eigvals(model.A) - value).min() < 1e-9:
            raise ValueError(
                f"E: shares the eigenvalue {plain(value, 6)} with A, so TA - ET = KC does not determine "
                "T from K; move it a little."
            )
    return E
