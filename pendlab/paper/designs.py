"""The paper's two designs with the observers that it prints."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
from scipy.optimize import linprog

from ..design import Design
from ..parameters import load
from .ledger import published

# T, K and the estimating rows of [L1 L2] of the observers that the paper prints.
OBSERVERS = {
    ("double", 1): ("eq24.T", "eq24.K", "eq27.L"),
    ("double", 2): ("eq25.T", "eq25.K", "eq28.L"),
    ("triple", 1): ("eq36.T", "eq36.K", "eq37.L"),
}


def paper_design(name, observer=1):
    """The `Design` of section 4.

    Parameters
    ----------
    name : "double" or "triple"
    observer : which printed observer: 1 is (24) with (27) of the double and (36) with (37) of the
        triple, 2 is (25) with (28) of the double; the member of the null space that rounds to the
        printed T, K and [L1 L2]

    >>> pl.paper_design("triple").kp
    10.0
    """
    whole_number = isinstance(observer, (int, np.integer)) and not isinstance(observer, bool)
    if not (isinstance(name, str) and whole_number and (name, observer) in OBSERVERS):
        known = ", ".join(f"{rig!r} with observer {number}" for rig, number in OBSERVERS)
        raise ValueError(
            f"name, observer: expected {known}; found {name!r} with observer {observer!r}."
        )
    return _paper_design(name, int(observer))


@lru_cache
def _paper_design(name, observer):
    Q, R, E = (
        tuple(np.atleast_1d(published(f"sec4.{name}.{key}").values).tolist()) for key in "QRE"
    )
    kp = float(published("sec4.k_p").values) if name == "triple" else None
    design = Design(load(name), Q, R, E, kp)
    coefficients, _ = printed_member(design.family, *OBSERVERS[name, observer])
    return replace(design, coefficients=tuple(coefficients))


def printed_member(family, *keys):
    """(coefficients, worst) of the member that comes nearest to the printed T, K and L at once.

    Minimises the largest |ours - printed| / half digit by repeated linear programs on the
    linearised entries (L follows from T by an inverse), starting from the projection; a `worst` of
    1 or less means that every printed digit is met.
    """
    entries = [published(key) for key in keys]

    def misfit(c):
        member = family.member(c)
        pairs = zip((member.T, member.K, estimating_rows(member)), entries, strict=True)
        gaps = [(own.reshape(e.values.shape) - e.values) / e.half_digit for own, e in pairs]
        return np.concatenate([np.ravel(gap) for gap in gaps])

    c = family.project(np.atleast_2d(entries[0].values), np.atleast_2d(entries[1].values))
    values, reach = misfit(c), 1e-2
    worst = np.abs(values).max()
    while reach > 1e-12:
        slope = np.array([(misfit(c + e) - values) / 1e-7 for e in 1e-7 * np.eye(len(c))]).T
        ones = np.ones((len(values), 1))
        best = linprog(
            np.append(np.zeros(len(c)), 1.0),
            A_ub=np.block([[slope, -ones], [-slope, -ones]]),
            b_ub=np.append(-values, values),
            bounds=[(-reach, reach)] * len(c) + [(0, None)],
        )
        trial = c + best.x[:-1]
        trial_values = misfit(trial)
        if np.abs(trial_values).max() < worst * (1 - 1e-9):
            c, values, worst = trial, trial_values, np.abs(trial_values).max()
        else:
            reach /= 4
    return c, float(worst)


def estimating_rows(observer):
    """[L1 L2] without the rows on top that copy the measured states."""
    return np.hstack([observer.L1, observer.L2])[observer.K.shape[1] :]
