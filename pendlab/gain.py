"""State feedback by the linear quadratic regulator."""

import control
import numpy as np
from scipy.linalg import matrix_balance

from ._arguments import array, plain, state_space


def lqr(model, Q, R):
    """Gain F (m, n) of u = -F x that minimises the sum of x'Q x + u'R u, equation (22).

    For a sampled model F = (R + B'X B)^-1 B'X A with the stabilising solution X of the discrete
    Riccati equation; for a continuous one the sum is an integral and F = R^-1 B'X.

    Q (n x n, positive semidefinite) weighs the n states, R (m x m, positive definite) the m inputs;
    of each the diagonal entries alone will do, and for one input a number.

    ValueError for weights of the wrong size, sign or symmetry, for a mode that no input moves, and
    for one on the stability limit that no weight sees.

    Only the ratio of Q to R counts. The paper's weights give (23):

    >>> pl.lqr(pl.paper_design("double").augmented, [0.1, 100, 0, 0.01, 1], 3).round(2)
    array([[-254.6 ,  -99.18,  -51.35,  -29.85,    0.55]])
    """
    state_space("model", model)
    n, m = model.nstates, model.ninputs
    Q, R = weights("Q", Q, n), weights("R", R, m)
    least = np.linalg.eigvalsh(Q)[0]
    if least < -1e-12 * np.abs(Q).max():
        raise ValueError(
            f"Q: expected a positive semidefinite matrix, found the eigenvalue {least:.4g}; "
            "use weights of zero or more."
        )
    least = np.linalg.eigvalsh(R)[0]
    if least <= 0:
        raise ValueError(
            f"R: expected a positive definite matrix, found the eigenvalue {least:.4g}; "
            "every input needs a weight above zero."
        )
    _solvable(model, Q)
    # Powers of two change no digit; R of size 1 keeps the Riccati solver's tolerances in place.
    scale = 2.0 ** -np.round(np.log2(np.abs(R).max()))
    Q, R = Q * scale, R * scale
    solve = control.dlqr if model.dt else control.lqr
    try:
        with np.errstate(invalid="ignore"):  # what comes of it is judged below
            F = np.asarray(solve(model.A, model.B, Q, R)[0])
    except (ValueError, np.linalg.LinAlgError) as problem:
        raise ValueError(
            f"Q, R: the Riccati equation could not be solved for these weights ({problem}); "
            "bring them closer together."
        ) from None
    if not _decay(model, np.linalg.eigvals(model.A - model.B @ F)).max() < 0:
        raise ValueError("Q, R: rounding leaves no stabilising gain; bring the weights together.")
    return F


def weights(name, value, size):
    """A symmetric weighting matrix from a matrix or from its diagonal."""
    value = array(name, value)
    if value.ndim < 2:
        return np.diag(array(name, value, (size,)))
    value = array(name, value, (size, size))
    if not np.allclose(value, value.T, rtol=1e-10, atol=1e-14 * np.abs(value).max()):
        raise ValueError(
            f"{name}: expected a symmetric matrix, found one that differs from its transpose by "
            f"{np.abs(value - value.T).max():.3g}; use ({name} + {name}.T)/2."
        )
    return (value + value.T) / 2


def unmoved_modes(A, B, at_least=None):
    """Eigenvalues of A that the inputs B do not reach (Popov-Belevitch-Hautus test).

    Judged in balanced coordinates and with inputs of equal size, so that units do not matter.
    """
    A, T = matrix_balance(A, permute=False)
    B = np.linalg.solve(T, B)
    size = np.linalg.norm(A) or 1.0
    B = B * size / np.maximum(np.linalg.norm(B, axis=0), 1e-300)
    values = [value for value in np.linalg.eigvals(A) if at_least is None or at_least(value)]
    pencils = [np.hstack([A - value * np.eye(len(A)), B]) for value in values]
    least = np.array([np.linalg.norm(pencil, -2) for pencil in pencils])  # singular values
    return np.array(values)[least <= 1e-9 * size]


def _decay(model, values):
    """How far outside the stability limit `values` lie, as a share of the model's size."""
    if model.dt:
        return np.abs(values) - 1
    return np.real(values) / (np.linalg.norm(model.A) or 1.0)


def _solvable(model, Q):
    """Stabilisable through B, and no mode on the stability limit that Q does not see."""
    stuck = unmoved_modes(model.A, model.B, lambda s: _decay(model, s) > -1e-9)
    if len(stuck):
        raise ValueError(
            f"model: not stabilisable, no input moves the mode at {plain(stuck[0])}; "
            "use another input or model."
        )
    values, vectors = np.linalg.eigh(Q)
    root = vectors * np.sqrt(np.clip(values, 0, None))  # root root' = Q
    unseen = unmoved_modes(model.A.T, root, lambda s: abs(_decay(model, s)) < 1e-9)
    if len(unseen):
        raise ValueError(
            f"Q: no weight sees the mode at {plain(unseen[0])} on the stability limit; "
            "an integrator needs a weight above zero."
        )
