"""Structured stability margin of a loop with two inputs: only diagonal changes (Fig 14, sharpened)."""

from dataclasses import dataclass

import numpy as np

from ..loop import check_loop, closed_loop_eigenvalues, frequency_response, least, loop_frequencies


@dataclass(frozen=True, eq=False)
class StructuredMargin:
    """Smallest diagonal change that makes I + L + diag(delta) singular somewhere on the circle.

    Attributes
    ----------
    value : largest |delta_i| of that change; 1/mu of (I + L)^-1
    omega : rad/s, where
    delta : (2,) complex, the change itself, |delta_1| = |delta_2| = value
    factors : (2,) complex, 1/(1 + delta): with the inputs multiplied by these, the closed loop has
        an eigenvalue e^(j omega dt)
    stable : whether the closed loop is stable; if not, the value is no margin but the distance to
        where an eigenvalue crosses the circle
    """

    value: float
    omega: float
    delta: np.ndarray
    factors: np.ndarray
    stable: bool


def structured_sigma(L):
    """1/mu of (I + L)^-1 for diagonal complex changes: the largest sigma_min(D (I + L) D^-1).

    For two inputs the best D is found in closed form. With a = 1 + L11, b = 1 + L22, c = L12 L21
    the product of both singular values is |ab - c| for every D, and the sum of their squares is
    least, hence the smaller one largest, at p = |a|^2 + |b|^2 + 2|c|:
    sigma^2 = (p - sqrt(p^2 - 4 |ab - c|^2))/2. For two blocks this bound is exact. L is a frequency
    response (N, 2, 2).

    Sources: Maciejowski 1989, chapter 3 (the paper's reference); Doyle 1982, IEE Proc. D 129, 242-250.
    """
    a, b = 1 + L[:, 0, 0], 1 + L[:, 1, 1]
    c = L[:, 0, 1] * L[:, 1, 0]
    p = np.abs(a) ** 2 + np.abs(b) ** 2 + 2 * np.abs(c)
    det = np.abs(a * b - c)
    # The smaller root by the product of both: no cancellation where it is small.
    return det / np.sqrt((p + np.sqrt(np.maximum(p**2 - 4 * det**2, 0))) / 2)


def structured_margin(loop, points=3000):
    """`StructuredMargin` of a sampled loop with two inputs, such as ``design.filtered_loop``.

    >>> margin = pl.structured_margin(pl.paper_design("triple").filtered_loop)
    >>> round(margin.value, 3), margin.stable
    (0.042, True)
    """
    check_loop(loop)
    if loop.ninputs != 2:
        raise ValueError(
            f"loop: expected two inputs, found {loop.ninputs}; for one the margin is "
            "pl.margins(loop).modulus."
        )

    def sigma(omega):
        return structured_sigma(frequency_response(loop, omega))

    value, omega = least(sigma, loop_frequencies(loop, points))
    delta = _change(np.eye(2) + frequency_response(loop, omega)[0])
    with np.errstate(divide="ignore"):  # delta = -1: no factor but an infinite one does it
        factors = 1 / (1 + delta)
    stable = bool(np.abs(closed_loop_eigenvalues(loop)[0]) < 1)
    return StructuredMargin(value, omega, delta, factors, stable)


def _change(Rd):
    """The smallest diagonal change that makes `Rd` singular.

    (a + d1)(b + d2) = c with |d1| = |d2| = s: at the best D, the least singular vectors u and v of
    D Rd D^-1 have entries of equal size, so -s u v* acts on v like the diagonal -s u/v.
    """
    cross = abs(Rd[0, 1]), abs(Rd[1, 0])
    if min(cross) < 1e-14 * np.abs(Rd).max():  # nothing comes back: each input by itself
        delta = np.zeros(2, dtype=complex)
        k = int(np.argmin(np.abs(np.diag(Rd))))
        delta[k] = -Rd[k, k]
        return delta
    d = np.array([np.sqrt(cross[1] / cross[0]), 1.0])
    U, s, Vh = np.linalg.svd(d[:, None] * Rd / d)
    return -s[1] * U[:, 1] / Vh[1].conj()
