"""Homework 2: E = diag(alpha, beta) and what it costs."""

import numpy as np

import pendlab as pl

from ..._arguments import number
from . import acceptance
from .judging import asks

RIG = dict(base="triple", who="your name")
KP = 5.0
EQUAL, DIFFERENT = (0.9, 0.9), (0.9, 0.8)  # eigenvalues of E
DEAREST, FINELY, SPREAD, APART, SLOWEST = 1.5, 0.02, 0.1, 0.05, 0.95
QUIETER = 0.66  # of the reference's noise


@asks("freedom", apart=True)
def exercise_1(rig):
    """Coefficients that change the transfer from y to the estimate, for equal and different E."""
    model = acceptance.reference(rig, KP).model
    families = [pl.observer_family(model, E) for E in (EQUAL, DIFFERENT)]
    yield [family.dimension - commuting(family.E) for family in families], None
    null = "That is the dimension of the null space. Which choices leave every estimate as it is?"
    yield [4, 4], null
    scale = """The equal case is right. With two different eigenvalues, is every number that you
        choose seen in the estimate? Scale one row of T."""
    yield [0, 4], scale
    yield [3, 3], "One common factor of T drops out, but that is not all."


def commuting(E):
    """Dimension of the matrices M with ME = EM, which only rename the observer's states."""
    identity = np.eye(len(E))
    return len(E) ** 2 - np.linalg.matrix_rank(np.kron(identity, E.T) - np.kron(E, identity))


def exercise_2(alpha, rig):
    """The fastest observer E = alpha I whose noise is within the limit."""
    alpha = number("alpha", alpha)
    if not 0 <= alpha < 1:
        yield "alpha should be from 0 up to, but not including, 1."
    design = acceptance.reference(rig, KP)

    def noise(value):
        return acceptance.design_noise(design.changed(E=(value, value)))

    here, limit = noise(alpha), DEAREST * noise(EQUAL[0])
    if here > limit:
        yield f"At your alpha motor 1 shakes with {here:.2f} V, {limit:.2f} V is the limit."
    if noise(max(alpha - FINELY, 0)) <= limit:
        yield f"""{here:.2f} V is within the limit of {limit:.2f} V, but an observer faster by
            {FINELY} would be too."""
    return f"{here:.2f} V, and {FINELY} faster would exceed the limit."


def exercise_3(*pair, rig):
    """Two members for one E whose margins differ."""
    if len(pair) != 2:
        yield "Two designs are asked for: pl.check(..., one, other, rig=rig)."
    for design in pair:
        yield acceptance.wrong_design(design, rig)
        yield too_slow(design)
        yield acceptance.unstable(design.filtered_loop)
    one, other = pair
    if not np.allclose(one.family.E, other.family.E):
        yield "Both should have the same E: it is the member of the family that may differ."
    if not np.allclose(one.F, other.F) or one.kp != other.kp:
        yield "Both should have the same F and k_p: only the observer may differ."
    first, second = (acceptance.modulus_margins(design)[0] for design in pair)
    apart, E = abs(first - second), one.family.E
    if apart < SPREAD:
        multiple = np.allclose(E, E[0, 0] * np.eye(len(E)), rtol=0, atol=1e-6)
        end = ", and with E = e I they always agree." if multiple else "."
        yield f"Their margins at input 1 differ by {apart:.3f}, {SPREAD} is asked for{end}"
    return "One E, one F, and two very different loops."


def too_slow(design):
    slowest = np.abs(np.linalg.eigvals(design.family.E)).max()
    told = f"""E has an eigenvalue of magnitude {slowest:.3f}: an estimate that starts wrong stays
        wrong for too long; at most {SLOWEST} is allowed."""
    return told if slowest > SLOWEST + 1e-9 else None


def exercise_4(design, rig):
    """An observer as good as the reference's, and quieter."""
    start = acceptance.reference(rig, KP)
    yield acceptance.wrong_design(design, rig)
    if design.kp != KP or design.F.shape != start.F.shape or not np.allclose(design.F, start.F):
        yield "F and k_p stay those of reference: what the observer alone can do is the question."
    values = np.linalg.eigvals(design.family.E)
    if abs(values[0] - values[1]) < APART:
        yield f"The eigenvalues of your E are (nearly) equal; keep them at least {APART} apart."
    yield too_slow(design)
    yield acceptance.unstable(design.filtered_loop)
    mine, theirs = map(measured, (design, start))
    yield acceptance.small_margins(design, np.array(theirs[:2]) - 1e-6)
    yield acceptance.too_noisy(mine[2], QUIETER * theirs[2])
    has = "{:.3f} and {:.3f} at {:.2f} V"
    said = f"Margins {has.format(*mine)} of noise; the paper's E = diag(0.9, 0.9) has"
    return f"{said} {has.format(*theirs)}."


def measured(design):
    return *acceptance.modulus_margins(design), acceptance.design_noise(design)
