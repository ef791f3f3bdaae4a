"""Checks of the warm-up in notebook 00."""

import numpy as np

from ...models import linearize
from ...parameters import load
from .judging import compare, not_own


def exercise_1(answer, rig=None):
    """How many states the linear model of a rig has."""
    rig = load("triple") if rig is None else rig
    truth = linearize(rig).nstates
    return compare(
        "The number of states",
        answer,
        truth,
        [
            (
                rig.n_links,
                "Angles alone are not enough: to know what comes next you need the rates too.",
            ),
            (
                rig.n_links + 1,
                "That is the number of measured outputs; states are angles and rates.",
            ),
        ],
        praise="One angle and one rate for each link.",
    )


def exercise_2(answer, rig=None):
    """Time in which a falling pendulum's deviation doubles, s."""
    rig = load("double") if rig is None else rig
    fastest = np.linalg.eigvals(linearize(rig).A).real.max()
    return compare(
        "The doubling time",
        answer,
        np.log(2) / fastest,
        [
            (1 / fastest, "In that time it grows by a factor e; doubling is less."),
            (2 / fastest, "Growth is exponential, not linear."),
            (np.log10(2) / fastest, "The exponential has base e: take the natural logarithm."),
            (
                np.log(2) / np.sort(np.linalg.eigvals(linearize(rig).A).real)[-2],
                "That is the slow unstable motion; the fast one decides when it is too late.",
            ),
        ],
        praise="Some tens of samples of 10 ms: little time, but enough.",
    )


def exercise_3(answer, rig=None):
    """Mass of all links, kg."""
    wrong = not_own(rig, "pl.check('00.3', mass, rig=rig)")
    if wrong:
        return wrong
    total = sum(link.mass for link in rig.links)
    return compare(
        "The mass",
        answer,
        total,
        [
            (rig.links[0].mass, "That is link 1 alone; sum over rig.links."),
            (total * rig.g, "That is a weight in newtons; the mass is asked for."),
        ],
        praise="Your rig is loaded and read: you can work with it in every notebook.",
    )
