"""Checks of the warm-up in notebook 00."""

import numpy as np

from ...models import linearize
from ...parameters import load
from .judging import compare, on


@on("triple")
def exercise_1(answer, rig=None):
    """How many states the linear model of a rig has."""
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
                "Four are the measured outputs, and the states of the double; here there are three links.",
            ),
        ],
        praise="One angle and one rate for each link.",
    )


@on("double")
def exercise_2(answer, rig=None):
    """Time in which a falling pendulum's deviation doubles, s."""
    fastest = np.linalg.eigvals(linearize(rig).A).real.max()
    return compare(
        "The doubling time",
        answer,
        np.log(2) / fastest,
        [
            (fastest, "That is the eigenvalue itself, in 1/s; solve e^(s t) = 2 for t."),
            (
                np.log(2) / np.linalg.eigvals(linearize(load("triple")).A).real.max(),
                "That is the triple; the double is asked for.",
            ),
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


@on("double", own="'00.3', mass, rig=rig")
def exercise_3(answer, rig=None):
    """Mass of all links, kg."""
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
