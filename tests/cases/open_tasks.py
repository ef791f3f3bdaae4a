"""The homework's open tasks: answers without work, and what a search turns for one that passes.

`LAZY[task](rig)` lists answers that cost no thought: the reference, the rows that the notebook
prints, the corners of what is allowed. `answer(task, name, made_of)` is the answer with the numbers
`made_of`, and `candidates(task, rng)` draws such numbers.
"""

from dataclasses import replace

import numpy as np

import pendlab as pl
from pendlab.classroom.checks import hw6, hw7
from pendlab.classroom.checks.acceptance import reference

NAMES = ("Ada", "Grace", "Anna", "Bela", "Chen", "Dora", "Emil", "Fatima", "Goran", "your name")
PAPER = pl.paper_design("triple")


def rig_of(task, name):
    return pl.my_rig(name, "double" if task.startswith("hw6") else "triple")


def choose(rig, dt, motors_hz, sensors_hz, kp):
    """As in homework 1."""
    filters = pl.Filters((motors_hz,) * 2, (sensors_hz,) * 4)
    e = 0.9 ** (dt / 0.01)
    return replace(reference(rig), rig=replace(rig, filters=filters), dt=dt, kp=kp, E=(e, e))


def weigh(rig, q2, qw, R=1):
    """As in homework 4."""
    return replace(reference(rig, 5.0), Q=(0.1, q2, 0, 1, 1, 1, qw), R=(R,))


def both(rig, Q, R):
    """As in homework 8."""
    return pl.Design(rig, Q, R, PAPER.E, kp=None, tracked=(1, 2))


def lazy_periods(rig):
    yield "reference", (reference(rig),)
    yield "no filters", (replace(reference(rig), rig=replace(rig, filters=None)),)
    yield "no sensor filter", (choose(rig, 0.009, 39.0, 1e9, 6.0),)
    for dt in (0.004, 0.006, 0.008, 0.01, 0.012):
        yield f"row {dt}", (choose(rig, dt, 20.0, 30.0, 7.0),)
    for dt in (0.005, 0.0181):  # the load's limit, the alias's
        for sensors in (1.0, 44.72):
            yield f"corner {dt} {sensors}", (choose(rig, dt, 1 / dt / np.sqrt(8), sensors, 10.0),)


def lazy_observers(rig):
    start = reference(rig, 5.0)
    yield "reference", (start,)
    for e in (0.4, 0.6, 0.8, 0.9, 0.95, 0.99):
        yield f"row {e}", (replace(start, E=(e, e)),)
    for E in (
        (0.95, 0.0),
        (0.95, 0.1),
        (0.95, 0.5),
        (0.95, 0.7),
        (0.95, 0.9),
        (0.9, 0.0),
        (0.9, 0.8),
    ):
        yield f"best member of {E}", (replace(start, E=E),)
    for Q, R in (((0.1, 250, 0, 1, 1, 1, 0.001), 10), ((0.1, 25, 0, 1, 1, 1, 0.001), 1)):
        yield f"another F {Q[1]} {R}", (replace(start, Q=Q, R=(R,), E=(0.95, 0.1)),)


def lazy_covariances(rig):
    B = reference(rig, 5.0).model.B
    for q in (1e-4, 1e-3, 1e-2, 1.0, 1e2, 1e4):
        yield f"row {q}", (q * B @ B.T,)
    yield "identity", (np.eye(6),)


def lazy_weights(rig):
    yield "reference", (reference(rig, 5.0),)
    rows = [(250, qw) for qw in (0.001, 0.01, 0.1, 1, 10, 100)]
    for row in (*rows, (25, 0.01), (25, 0.01, 10), (25, 1), (1, 0.03)):
        yield f"row {row}", (weigh(rig, *row),)


def lazy_attitudes(rig):
    start = hw6.reference(rig)
    rows = {"reference": start, **{f"row {R}": replace(start, R=(R,)) for R in (0.3, 30.0)}}
    quick = {f"integrator {q}": replace(start, Q=(*start.Q[:4], q)) for q in (10.0, 100.0)}
    for label, design in (rows | quick).items():
        for attitude in (0.0, hw6.FURTHEST, -hw6.FURTHEST):
            yield f"{label} {attitude}", (design, attitude)


def lazy_flatterers(rig):
    for link in (1, 2, 3):
        yield f"row {link}", (link, hw7.EXAMPLE)
        yield f"with units {link}", (link, 0.05 * (link > 1) or 1e-3)


def kit(rig):
    """Rows that are printed, and corners of the kit."""
    for height in (0.0, rig.links[2].com, 0.4):
        yield (3, 1.0, 0.1, height)
    for link in (1, 2, 3):
        for length in (0.5, hw7.LONGEST):
            for ends in (0.0, hw7.HEAVIEST):
                for height in (0.0, rig.links[link - 1].length):
                    yield (link, length, ends, height)


def lazy_bars(rig):
    for bar in kit(rig):
        yield f"{bar}", (bar,)


def lazy_catchers(rig):
    bars = [*kit(rig), (2, 1.5, 0.1, 0.0), (3, 1.5, 0.1, 0.0)]  # and the kit's at half a kilogram
    ones = dict(Q=(1, 1, 1, 0, 0, 0, 0.01), R=(1, 1), E=PAPER.E, kp=None, tracked=1)
    for bar in bars[-2:] + bars[:4]:
        made = hw7.barred(rig, *bar)
        for kp in (5.0, 10.0):
            yield f"paper {kp} {bar}", (bar, pl.Design(made, PAPER.Q, PAPER.R, PAPER.E, kp))
        yield f"ones {bar}", (bar, pl.Design(made, **ones))


def lazy_attitudes_of_both(rig):
    for q in (1, 3, 10, 30, 50, 60, 70, 100):
        yield f"first with {q}", (both(rig, (1, 1, 1, 0, 0, 0, q, q), (1, 1)),)
    yield "reference", (reference(rig),)


LAZY = {
    "hw1.4": lazy_periods,
    "hw2.4": lazy_observers,
    "hw3.4": lazy_covariances,
    "hw4.3": lazy_weights,
    "hw4.4": lazy_weights,
    "hw6.5": lazy_attitudes,
    "hw7.3": lazy_flatterers,
    "hw7.4": lazy_bars,
    "hw7.5": lazy_catchers,
    "hw8.3": lazy_attitudes_of_both,
}
OPEN = tuple(LAZY)


def candidates(task, rng):
    """Numbers to try, as a list: the first draw of each is the notebook's solution or near it."""

    def any_of(*values):
        return values[rng.integers(len(values))]

    def decades(low, high):
        return round(float(10 ** rng.uniform(low, high)), 4)

    return {
        "hw1.4": lambda: [any_of(0.009, 0.011, 0.013), any_of(25.0, 30.0, 35.0), any_of(4.0, 4.5, 5.0)],
        "hw2.4": lambda: [any_of(0.0, 0.03), *np.round(rng.standard_normal(4), 3).tolist()],
        "hw3.4": lambda: [decades(-2, -0.5), decades(-2, 0)],
        "hw4.3": lambda: [any_of(25, 50, 100, 250), any_of(1, 3, 10, 30, 100), any_of(1, 3, 10)],
        "hw4.4": lambda: [any_of(25, 50, 100, 250), any_of(1, 3, 10, 30, 100), any_of(1, 3, 10)],
        "hw6.5": lambda: [any_of(0.04, 0.05), any_of(0.1, 1), any_of(1, 10, 100), any_of(0, 0.1), any_of(3, 10, 30, 100), any_of(1, 3, 10, 30), any_of(0.5, 0.7, 0.9)],
        "hw7.3": lambda: [1, any_of(0.02, 0.03, 0.04, 0.05, 0.06)],
        "hw7.4": lambda: [any_of(2, 3), any_of(1.3, 1.4, 1.5), any_of(0.08, 0.1), 0.0],
        "hw7.5": lambda: [any_of(1, 3, 10, 30), any_of(0.01, 0.1, 1), any_of(1, 3, 10), any_of(0.5, 0.7, 0.9), round(rng.uniform(5, 9), 1)],
        "hw8.3": lambda: [any_of(1, 3, 10, 30), any_of(50, 60, 75, 100), any_of(50, 60), any_of(1, 2, 3), any_of(0.1, 0.2, 0.3)],
    }[task]()  # fmt: skip


def answer(task, name, made_of):
    """The answer that the check takes, from its numbers."""
    rig = rig_of(task, name)
    if task == "hw1.4":
        dt, sensors, kp = made_of
        return (choose(rig, dt, 1 / dt / np.sqrt(8), sensors, kp),)
    if task == "hw2.4":
        e, *c = made_of
        return (replace(reference(rig, 5.0), E=(0.95, e), coefficients=tuple(c)),)
    if task == "hw3.4":
        B = reference(rig, 5.0).model.B
        return (B @ np.diag(made_of) @ B.T,)
    if task in ("hw4.3", "hw4.4"):
        return (weigh(rig, *made_of),)
    if task == "hw6.5":
        attitude, lower, upper, rate, q, R, e = made_of
        design = replace(hw6.reference(rig), Q=(lower, upper, rate, 0, q), R=(R,), E=(e,))
        return design, attitude
    if task == "hw7.3":
        return tuple(made_of)
    if task == "hw7.4":
        return (tuple(made_of),)
    if task == "hw7.5":
        q, rates, R, e, kp = made_of
        bar = (2, 1.5, 0.1, 0.0)
        Q = (0.1, q, 0, rates, rates, rates, 1e-3)
        return bar, pl.Design(hw7.barred(rig, *bar), Q, (R,), (e, e), kp=kp)
    q, first, second, R1, R2 = made_of
    return (both(rig, (1, 1, q, 0, 0, 0, first, second), (R1, R2)),)
