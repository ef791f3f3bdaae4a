"""The minimum-variance unknown-input observer: what H = 0 costs in noise when order is free.

With H = TB = 0 an observer never sees the voltages, so its estimate is right whatever they are:
an unknown-input observer. Those of minimal order (`pl.observer_family`) choose E first and pay in
noise; this one keeps all n states and takes the least noise that TB = 0 allows.
"""

import numpy as np

from .._arguments import state_space
from ..gain import weights
from ..observers import Observer


def unknown_input_observer(model, noise, process=None):
    """The filter of least error variance among those that do not use the inputs.

    xhat(n) = (I - MC) A xhat(n-1) + M y(n) with (I - MC)B = 0. In steady state, with
    P = A P+ A' + W and S = C P C' + V,

        M = P C' S^-1 + (I - P C' S^-1 C) B (B'C' S^-1 C B)^-1 B'C' S^-1
        P+ = (I - MC) P (I - MC)' + M V M'

    As an `Observer` with v = (I - MC) A xhat(n-1): E = (I - MC)A, H = 0, T = I - MC, K = E M,
    L1 = M, L2 = I, so that `pl.controller` takes it and the loop is the one of state feedback.

    Exists iff rank CB = m, with a steady state that forgets its start iff every invariant zero of
    (A, B, C) lies inside the unit circle. It is the limit of the (current) Kalman filter whose
    process noise enters at the inputs, as that noise grows: loop transfer recovery.

    Parameters
    ----------
    model : sampled control.StateSpace, n states, m inputs, q >= m outputs, D = 0
    noise : covariance V of the readings, q x q positive definite, or its q diagonal entries
    process : covariance W of further process noise, n x n, or its n diagonal entries; default none

    ValueError for a rank of CB below m, or an invariant zero that is not inside the unit circle.

    Sources: Kitanidis 1987, Automatica 23, 775-778; Darouach, Zasadzinski and Xu 1994, IEEE Trans.
    Autom. Control 39, 606-609; Hautus 1983, Linear Algebra Appl. 50, 353-368; Maciejowski 1985,
    IEEE Trans. Autom. Control 30, 602-605 (the current estimator recovers, the predictor cannot).

    >>> filter = pl.unknown_input_observer(pl.paper_design("double").model, [1e-6, 1e-6, 1e-4])
    >>> filter.residuals(pl.paper_design("double").model)["H - TB"] < 1e-12
    True
    """
    A, B, C = (getattr(state_space("model", model, sampled=True), part) for part in "ABC")
    n, m = B.shape
    V = weights("noise", noise, model.noutputs)
    W = np.zeros((n, n)) if process is None else weights("process", process, n)
    if np.linalg.eigvalsh(V)[0] <= 0 or np.linalg.eigvalsh(W)[0] < -1e-12 * np.abs(W).max():
        raise ValueError(
            "noise, process: expected variances above zero for every output and none below zero "
            "for the states; square the standard deviations."
        )
    if model.noutputs < m or _rank(C @ B) < m:
        raise ValueError(
            f"model: an unknown-input observer needs rank CB = {m}, the number of inputs, found "
            f"{_rank(C @ B)}; measure what the inputs move first."
        )
    P, M = 1e3 * np.trace(V) * np.eye(n), None
    for _ in range(20_000):
        previous, M = M, _gain(P, B, C, V)
        T = np.eye(n) - M @ C
        if previous is not None and np.abs(M - previous).max() <= 1e-13 * np.abs(M).max():
            break
        P = A @ (T @ P @ T.T + M @ V @ M.T) @ A.T + W
        P = (P + P.T) / 2
    E = T @ A
    radius = np.abs(np.linalg.eigvals(E)).max()
    if not radius < 1 - 1e-9:
        raise ValueError(
            f"model: its unknown-input observer does not forget its start, found an eigenvalue of "
            f"magnitude {radius:.6g}; an invariant zero is not inside the unit circle."
        )
    return Observer(E, np.zeros((n, m)), T, E @ M, M, np.eye(n))


def _gain(P, B, C, V):
    """M of least variance among those with (I - MC)B = 0."""
    kalman = np.linalg.solve(C @ P @ C.T + V, C @ P).T
    weighted = np.linalg.solve(C @ P @ C.T + V, C @ B).T
    from_input = np.linalg.solve(weighted @ C @ B, weighted)
    return kalman + (B - kalman @ C @ B) @ from_input


def _rank(X):
    """Rank whatever the units of the rows and columns."""
    X = X / np.maximum(np.linalg.norm(X, axis=0), 1e-300)
    return np.linalg.matrix_rank(X / np.maximum(np.linalg.norm(X, axis=1, keepdims=True), 1e-300))
