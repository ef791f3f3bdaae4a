"""State feedback by the linear quadratic regulator."""

import control
import numpy as np

from ._arguments import array, plain, state_space


def lqr(model, Q, R):
    """Gain F of u = -F x that minimises the sum of x'Q x + u'R u, equation (22).

    For a sampled model F = (R + B'X B)^-1 B'X A with the stabilising solution X of the discrete
    Riccati equation; for a continuous one the sum is an integral and F = R^-1 B'X.

    Parameters
    ----------
    model : control.StateSpace with n states and m inputs
    Q : weights of the states, n x n symmetric and positive semidefinite, or the n diagonal entries
    R : weights of the inputs, m x m symmetric and positive definite, or the m diagonal entries
        (a number for one input)

    Returns
    -------
    F : array (m, n)

    Raises
    ------
    ValueError : weights of the wrong size, sign or symmetry; a mode that no input moves, or one on
        the stability limit that no weight sees
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
    solve = control.dlqr if model.dt else control.lqr
    try:
        return np.asarray(solve(model.A, model.B, Q, R)[0])
    except (ValueError, np.linalg.LinAlgError) as problem:
        raise ValueError(
            f"Q, R: the Riccati equation could not be solved for these weights ({problem}); "
            "bring them closer together."
        ) from None


def weights(name, value, size):
    """A symmetric weighting matrix from a matrix or from its diagonal."""
    value = array(name, value)
    if value.ndim < 2:
        return np.diag(array(name, np.atleast_1d(value), (size,)))
    value = array(name, value, (size, size))
    if not np.allclose(value, value.T, rtol=1e-10, atol=1e-14):
        raise ValueError(
            f"{name}: expected a symmetric matrix, found one that differs from its transpose by "
            f"{np.abs(value - value.T).max():.3g}; use ({name} + {name}.T)/2."
        )
    return (value + value.T) / 2


def unmoved_modes(A, B, at_least=None, tolerance=1e-9):
    """Eigenvalues of A that the inputs B do not reach (Popov-Belevitch-Hautus test)."""
    n = len(A)
    scale = np.linalg.norm(np.hstack([A, B]))
    return np.array(
        [
            value
            for value in np.linalg.eigvals(A)
            if (at_least is None or at_least(value))
            and np.linalg.svd(np.hstack([A - value * np.eye(n), B]), compute_uv=False)[-1]
            <= tolerance * scale
        ]
    )


def _solvable(model, Q):
    """Stabilisable through B, and no mode on the stability limit that Q does not see."""
    distance = (lambda s: abs(s) - 1) if model.dt else (lambda s: s.real)
    stuck = unmoved_modes(model.A, model.B, lambda s: distance(s) > -1e-9)
    if len(stuck):
        raise ValueError(
            f"model: not stabilisable, no input moves the mode at {plain(stuck[0])}; "
            "use another input or model."
        )
    unseen = unmoved_modes(model.A.T, _root(Q).T, lambda s: abs(distance(s)) < 1e-9)
    if len(unseen):
        raise ValueError(
            f"Q: no weight sees the mode at {plain(unseen[0])} on the stability limit; "
            "an integrator needs a weight above zero."
        )


def _root(Q):
    """A square root of Q: root' root = Q."""
    values, vectors = np.linalg.eigh(Q)
    return np.sqrt(np.clip(values, 0, None))[:, None] * vectors.T
