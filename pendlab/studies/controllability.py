"""How controllable is a rig, and would a bar help? The measures that the introduction speaks of.

A rank says yes or no; these say how much. The ratio of singular values (Furuta) and the distance to
the nearest uncontrollable model (Eising) change with the units of state, time and input
(`in_units`). Least effort and largest tilt do not depend on how the state is written.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import schur, solve_continuous_lyapunov
from scipy.optimize import linprog, minimize

from .._arguments import array, found, instance, number, numbers, state_space, whole
from ..models import linearize
from ..parameters import Pendulum

CELLS = 100_000


def controllability_ratio(A, B):
    """Largest over smallest singular value of the controllability matrix [B, AB, ..., A^(n-1) B].

    1 is the best value; it is inf, or above 1e15 by rounding, where the pair is not controllable.
    A is n x n, B n x m. Source: Furuta et al. 1984, as the paper's introduction reports it.

    >>> pl.controllability_ratio([[0, 1], [0, 0]], [[0], [1]])
    1.0
    """
    A, B = _pair(A, B)
    blocks = [B]
    with np.errstate(over="ignore", invalid="ignore"):
        for _ in range(len(A) - 1):
            blocks.append(A @ blocks[-1])
    if not np.all(np.isfinite(blocks)):
        raise ValueError(
            "A, B: the controllability matrix holds numbers beyond 1e308; use other units of time "
            "and input, as pl.in_units gives them."
        )
    return float(np.linalg.cond(np.hstack(blocks)))


def distance_to_uncontrollability(A, B, tolerance=1e-2):
    """Size of the smallest change of [A, B] that makes the pair uncontrollable.

    (distance, s): min over complex s of sigma_min([A - s I, B]), the 2-norm of a real or complex
    change, and the eigenvalue s that would be lost, Im s >= 0. At the minimum s = u* A u with a
    unit vector u, so s lies in the numerical range of A; and sigma_min never moves further than s
    does. A box round that range is therefore cut up again and again, and cells whose centre shows
    that they cannot hold the minimum are dropped: none slips through, as it might through a grid.

    Parameters
    ----------
    A, B : (n, n), (n, m)
    tolerance : above 0 and below 1; no s gives less than the result by more than this fraction (or
        by more than 1e-9 of the size of [A, B]); the minimum found is refined to about 8 digits.
        ValueError for one that would take more than 100,000 cells

    Sources: Eising 1984; Gahinet and Laub 1992.

    >>> distance, s = pl.distance_to_uncontrollability([[0, 1], [0, 0]], [[0], [1]])
    >>> round(distance**2, 6), round(abs(s), 3)
    (0.75, 0.5)
    """
    A, B = _pair(A, B)
    if not 0 < number("tolerance", tolerance) < 1:
        raise ValueError(f"tolerance: expected a number above 0 and below 1, {found(tolerance)}.")
    size = np.abs(np.hstack([A, B])).max()
    if size == 0:
        return 0.0, 0j
    distance, s = _nearest(A / size, B / size, tolerance)
    return float(size * distance), complex(size * s.real, size * abs(s.imag))


def _nearest(A, B, tolerance):
    """(distance, s) of a pair whose largest entry is 1."""
    least = 1e-9 * np.linalg.norm(np.hstack([A, B]), 2)
    starts = np.linalg.eigvals(A).astype(complex)
    best, at = _descend(A, B, starts[_sigma_min(A, B, starts).argmin()])
    centres, half = _cover(A)
    cells = 0
    # What is that small is zero to the accuracy promised: nothing below it to look for.
    while len(centres) and best > max(tolerance * best, least):
        cells += len(centres)
        if cells > CELLS:
            raise ValueError(
                f"tolerance: {tolerance:g} would take more than {CELLS} cells; use a larger one, or "
                "units in which the entries of A and B are of similar size (pl.in_units)."
            )
        values = _sigma_min(A, B, centres)
        if values.min() < best:
            best, at = _descend(A, B, centres[values.argmin()])
        # No point of a cell is further from its centre than half a diagonal.
        alive = values - np.sqrt(2) * half < best - max(tolerance * best, least)
        half /= 2
        quarters = half * np.array([1 + 1j, 1 - 1j, -1 + 1j, -1 - 1j])
        centres = (centres[alive, None] + quarters).ravel()
    return best, at


def _sigma_min(A, B, points):
    """sigma_min([A - s I, B]) at each of the complex `points`."""
    shifted = A - points[:, None, None] * np.eye(len(A))
    inputs = np.broadcast_to(B, (len(points), *B.shape))
    return np.linalg.svd(np.concatenate([shifted, inputs], axis=2), compute_uv=False)[:, -1]


def _descend(A, B, s):
    """(value, s) of a local minimum near s, never above the value at s."""

    def at(p):
        return _sigma_min(A, B, np.array([complex(*p)]))[0]

    simplex = [s.real, s.imag] + 0.02 * (1 + abs(s)) * np.array([[0, 0], [1, 0], [0, 1]])
    options = dict(xatol=1e-10 * (1 + abs(s)), fatol=1e-12, initial_simplex=simplex)
    p = minimize(at, simplex[0], method="Nelder-Mead", options=options).x
    return at(p), complex(*p)


def _cover(A):
    """Square cells over the upper half of a box round the numerical range: centres, half width."""
    real = np.linalg.eigvalsh((A + A.T) / 2)
    top, width = np.linalg.norm((A - A.T) / 2, 2), real[-1] - real[0]
    half = max(top / 2, width / 64, 1e-12 * (1 + np.abs(real).max()))
    columns = int(np.ceil(width / (2 * half))) + 1
    return real[0] + 2 * half * np.arange(columns) + 1j * half, half


def in_units(plant, angle=1.0, second=1.0, volts=1.0):
    """A and B of `plant` with angles counted in `angle` rad, time in `second` s, inputs in `volts` V.

    With D = diag(angle, ..., angle/second, ...): second D^-1 A D and second D^-1 B diag(volts).
    `plant` is continuous, n angles followed by their n rates, as from `linearize`; `volts` is a
    number for all m inputs or one for each.

    >>> A, B = pl.in_units(pl.linearize(pl.load("double")), second=0.2)
    >>> bool(A[0, 2] == 1)  # an angle grows by one per unit of time at rate one
    True
    """
    state_space("plant", plant, sampled=False)
    angle = number("angle", angle, above=1e-100, most=1e100)
    second = number("second", second, above=1e-100, most=1e100)
    volts = numbers("volts", volts, above=0)
    volts = volts * plant.ninputs if len(volts) == 1 else volts
    volts = np.array(numbers("volts", volts, count=plant.ninputs))
    D = np.repeat([angle, angle / second], plant.nstates // 2)
    return second * plant.A * D / D[:, None], second * plant.B * volts / D[:, None]


def with_bar(rig, link, inertia, mass=0.0, height=None):
    """`rig` with a horizontal bar fixed across one of its links.

    The bar has `inertia` about its own centre and `mass` at `height`; the link's centre of mass and
    inertia follow by the parallel-axis theorem. A uniform bar of length b has the inertia
    mass b^2/12: the longer, the more it is inertia alone, as in the default.

    `link` 1 is the lowest; `inertia` in kg m^2, `mass` in kg, `height` of the bar above the link's
    lower hinge in m, by default that of the link's centre of mass.

    >>> wider = pl.with_bar(pl.load("double"), 2, inertia=0.1)
    >>> round(wider.links[1].inertia, 4)
    0.1305
    """
    instance("rig", rig, Pendulum, 'pl.load("double")')
    whole("link", link, least=1, most=rig.n_links)
    inertia, mass = number("inertia", inertia, least=0), number("mass", mass, least=0, most=1e100)
    old = rig.links[link - 1]
    height = number("height", old.com if height is None else height, least=0, most=1e100)
    com = (old.mass * old.com + mass * height) / (old.mass + mass)
    about = old.inertia + old.mass * (old.com - com) ** 2 + inertia + mass * (height - com) ** 2
    new = replace(old, mass=old.mass + mass, com=com, inertia=about)
    return replace(rig, links=[*rig.links[: link - 1], new, *rig.links[link:]])


def least_effort(rig, x0):
    """Least control effort that brings the linear model from x0 to rest, without limits.

    The integral of sum (u_i/u_max_i)^2 dt, in s: a motor at full voltage for so long spends as much.
    It is z' G^-1 z, where z = V x0 is the unstable part, dz/dt = A_u z + B_u u, and
    A_u G + G A_u' = B_u B_u'; the stable part comes to rest by itself.

    inf where an unstable mode cannot be moved. The rig has limits ``u_max``, x0 holds 2n relative
    angles (rad) and rates (rad/s). It is also the cost of the linear quadratic regulator (22) with
    R = diag(1/u_max^2) as Q goes to zero.

    >>> round(pl.least_effort(pl.load("double"), [0.05, 0, 0, 0]), 2)
    0.13
    """
    A_u, B_u, z = _unstable(rig, "x0", x0)
    G = solve_continuous_lyapunov(A_u, B_u @ B_u.T)
    scale = np.sqrt(np.abs(np.diag(G)))  # so that units of the states do not decide
    if not scale.all():
        return np.inf
    G, z = G / np.outer(scale, scale), z / scale
    return float(z @ np.linalg.solve(G, z)) if np.linalg.cond(G) < 1e15 else np.inf


def recoverable_tilt(rig, direction=None):
    """Largest multiple of `direction` from which some voltages within the limits reach upright.

    Linear model, any controller. From alpha x0, with z = V x0 the unstable part, alpha is the largest
    for which alpha z + integral of e^(-A_u t) B_u u(t) dt = 0 with |u_i| <= u_max_i: a linear program
    for voltages held over intervals that grow with time, the last without end.

    Parameters
    ----------
    rig : Pendulum with finite limits ``u_max``
    direction : 2n relative angles (rad) and rates (rad/s); by default a straight pendulum at rest,
        leaning by theta1 = 1 rad, so that the result is in rad of theta1. One that comes to rest by
        itself gives inf

    >>> round(pl.recoverable_tilt(pl.load("triple")), 3)
    0.182
    """
    A_u, B_u, z = _unstable(rig, "direction", direction)
    if not z.any():
        return np.inf
    size = np.abs(z).max()  # a direction is the same whatever its length
    z = z / size
    s, V = np.linalg.eig(A_u)
    ends = np.append(0.0, np.geomspace(0.02 / np.abs(s).max(), 5 / np.abs(s).min(), 160))
    decay = (V * np.exp(-np.multiply.outer(ends, s))[:, None, :] @ np.linalg.inv(V)).real
    decay = np.concatenate([decay, np.zeros((1, *A_u.shape))])  # e^(-A_u t) fades out
    pushes = np.hstack(list(np.linalg.solve(A_u, (decay[:-1] - decay[1:]) @ B_u)))
    count = pushes.shape[1]
    best = linprog(
        np.append(np.zeros(count), -1.0),
        A_eq=np.column_stack([pushes, z]),
        b_eq=np.zeros(len(z)),
        bounds=[(-1, 1)] * count + [(0, None)],
    )
    return float(best.x[-1] / size)


def _unstable(rig, name, x0):
    """(A_u, B_u, z) of the unstable part, inputs counted in units of their limits."""
    plant = linearize(rig)
    x0 = np.eye(plant.nstates)[0] if x0 is None and name == "direction" else x0
    if not np.all(np.isfinite(rig.u_max)):
        raise ValueError(
            f"u_max: expected a finite limit for each motor, {found(rig.u_max)}; "
            "use dataclasses.replace(rig, u_max=...)."
        )
    x0 = array(name, x0, (plant.nstates,))
    if np.abs(x0).max() > 1e100:
        raise ValueError(f"{name}: expected angles and rates up to 1e100, found larger ones.")
    # Schur vectors of A' for the unstable eigenvalues: V A = A_u V.
    T, Z, k = schur(plant.A.T, output="real", sort="rhp")
    V = Z[:, :k].T
    return T[:k, :k].T, V @ plant.B * np.array(rig.u_max), V @ x0


@dataclass(frozen=True)
class ControllabilityMeasures:
    """Four answers to the question how controllable a rig is; see `controllability_measures`."""

    ratio: float  # `controllability_ratio`; less is better
    distance: float  # `distance_to_uncontrollability`; more is better
    effort: float  # `least_effort`, s, from a lean of the straight pendulum by one unit of angle
    tilt: float  # `recoverable_tilt`, rad


def controllability_measures(rig, angle=0.1, second=0.2):
    """All four measures of `rig`, in units of `angle` rad, `second` s and each motor's voltage limit.

    The units are the same for all rigs that are compared: 0.1 rad is what the paper's Figs 15 to 17
    show, 0.2 s the time constant of the fall, and the limit what a motor can do at most.

    >>> round(pl.controllability_measures(pl.load("double")).tilt, 3)  # rad
    0.094
    """
    A, B = in_units(linearize(rig), angle, second, rig.u_max)
    lean = angle * np.eye(2 * rig.n_links)[0]
    effort, tilt = least_effort(rig, lean), recoverable_tilt(rig)
    try:
        distance, _ = distance_to_uncontrollability(A, B)
    except ValueError as problem:
        raise ValueError(
            f"angle, second: no distance in units of {angle:g} rad and {second:g} s ({problem})."
        ) from None
    return ControllabilityMeasures(controllability_ratio(A, B), distance, effort, tilt)


def _pair(A, B):
    A, B = array("A", A), array("B", B)
    if A.ndim != 2 or A.shape[0] != A.shape[1] or not len(A):
        raise ValueError(f"A: expected a square matrix, found shape {A.shape}.")
    return A, array("B", B, (len(A), None))
