"""Checks of the warm-up in notebook 00."""

import numpy as np

import pendlab as pl

from .judging import asks


def growth(rig):
    """The unstable eigenvalues of a rig, the fastest first, 1/s."""
    values = pl.linearize(rig).poles().real
    return np.sort(values[values > 0])[::-1]


@asks("The number of states", base="triple")
def exercise_1(rig):
    """How many states the linear model of a rig has."""
    yield pl.linearize(rig).nstates, "Now say in words which numbers they are."
    yield rig.n_links, "Is one number for each link enough to tell what comes next?"
    yield 4, "Those are the measured outputs, or the states of the double; here are three links."


@asks("The doubling time", base="double")
def exercise_2(rig):
    """Time in which a falling pendulum's deviation doubles, s."""
    fast, slow = growth(rig)[:2]
    yield np.log(2) / fast, "About fifteen samples of 10 ms: little time, but enough."
    yield fast, "That is the eigenvalue itself, in 1/s; solve e^(s t) = 2 for t."
    yield np.log(2) / growth(pl.load("triple"))[0], "That is the triple; the double is asked for."
    yield 1 / fast, "In that time it grows by a factor e; doubling is less."
    yield 2 / fast, "Growth is exponential, not linear."
    yield np.log10(2) / fast, "The exponential has base e: take the natural logarithm."
    yield np.log(2) / slow, "That is the slow fall; the fast one decides when it is too late."


@asks("The mass", base="double", own="'00.3', mass, rig=rig")
def exercise_3(rig):
    """Mass of all links, kg."""
    total = sum(link.mass for link in rig.links)
    yield total, "Your rig is loaded and read: you can work with it in every notebook."
    yield rig.links[0].mass, "That is link 1 alone; sum over rig.links."
    yield total * rig.g, "That is a weight in newtons; the mass is asked for."
