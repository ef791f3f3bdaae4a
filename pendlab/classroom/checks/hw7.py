"""Homework 7: does a horizontal bar help?"""

import numpy as np

import pendlab as pl

from ..._arguments import found, number, whole
from .acceptance import REAL, alike, before, fallen, no_design, unstable
from .judging import Verdict, all_right, not_callable

RIG = dict(base="triple", who="your name")
TUBE = 0.2  # kg/m
LONGEST, HEAVIEST, WEIGHT = 1.5, 0.2, 0.5  # m, kg at each end, kg in all
FLATTERED, HARDER = 0.9, 0.7  # of the bare ratio and tilt
BETTER, CLOSE = 1.35, 0.84  # of the bare tilt, of the bar's own
EXAMPLE = 0.1  # kg m^2
CAUGHT = 0.1  # rad


def weigh(length, ends):
    """(inertia about the middle, mass) of a tube with a weight at each end."""
    mass = TUBE * length
    return mass * length**2 / 12 + 2 * ends * (length / 2) ** 2, mass + 2 * ends


def barred(rig, link, length, ends, height):
    return pl.with_bar(rig, link, *weigh(length, ends), height)


def exercise_1(function, rig):
    """A function that puts a bar on a link."""
    yield not_callable(function, "your function carry(link, inertia, mass, height)")
    for i, link in enumerate(rig.links, 1):
        for bar in ((0.05, 0.0, 0.1), (0.05, 0.3, 0.0), (0.1, 0.5, link.com), (0.02, 0.2, 0.25)):
            truth, made = pl.with_bar(rig, i, *bar).links[i - 1], function(link, *bar)
            if not isinstance(made, pl.Link):
                yield f"carry must return a pl.Link, {found(made)}."
            for name in ("mass", "com", "inertia", "length", "friction"):
                if not np.isclose(getattr(made, name), getattr(truth, name), rtol=1e-6):
                    yield _carry_hint(name, made, link, bar)
    return "Mass, centre of mass and inertia follow as they should."


def _carry_hint(name, made, link, bar):
    inertia, mass, height = bar
    near = link.inertia + inertia
    about_old = near + mass * (height - link.com) ** 2
    if name == "inertia" and np.isclose(made.inertia, near):
        return "The two centres are apart: each part adds mass times distance squared."
    if name == "inertia" and np.isclose(made.inertia, about_old) and mass:
        return "Distances count from the *new* centre of mass, which has moved for both parts."
    if name == "com":
        return "The centre of mass is the mean of both, weighted by mass."
    kept = name in ("length", "friction")
    wanted = "stay as it was" if kept else "be computed from both parts"
    return f"""{name} is not what follows for a bar of {mass:g} kg at {height:.3g} m; it should
        {wanted}."""


def exercise_2(by_ratio, by_tilt, rig):
    """On which link a bar of EXAMPLE helps most, by Furuta's ratio and by the recoverable tilt."""
    measures = [pl.controllability_measures(pl.with_bar(rig, link, EXAMPLE)) for link in (1, 2, 3)]

    def verdict(name, answer, values, better):
        if answer == 1 + int(np.argmin(values)):
            return Verdict(True, "Two measures, two opinions.")
        said = f"{name}: not link {whole(name, answer, 1, 3)}."
        return Verdict(False, f"{said} Of this measure {better} is better; links count from 1.")

    return all_right(
        verdict("by_ratio", by_ratio, [m.ratio for m in measures], "less"),
        verdict("by_tilt", by_tilt, [-m.tilt for m in measures], "more"),
    )


def exercise_3(link, inertia, rig):
    """A bar that flatters the ratio and makes the pendulum harder to catch."""
    link, inertia = whole("link", link, least=1), number("inertia", inertia, above=0)
    rigs = rig, pl.with_bar(rig, link, inertia)
    bare, made = map(pl.controllability_measures, rigs)
    ratio, tilt = made.ratio / bare.ratio, made.tilt / bare.tilt
    if ratio > FLATTERED:
        yield f"The ratio is {ratio:.2f} of the bare one; {FLATTERED:g} or less is asked."
    if tilt > HARDER:
        so = "this bar does help" if tilt > 1 else "not the right amount of it"
        yield f"""The ratio falls, but the tilt is {tilt:.2f} of the bare one, {HARDER:g} or less is
            asked: {so}."""
    return f"Ratio {ratio:.2f}, tilt {tilt:.2f} of the bare pendulum's."


def exercise_4(bar, rig):
    """A bar from the kit that lets more tilt be caught."""
    if not isinstance(bar, (tuple, list)) or len(bar) != 4:
        yield "Expected the four numbers (link, length, ends, height)."
    link, length, ends, _ = bar
    link = whole("link", link, least=1)
    if link > rig.n_links:
        yield f"There are links 1 to {rig.n_links}, found {link}."
    limits = (LONGEST, HEAVIEST, rig.links[link - 1].length)
    for name, value, most in zip(("length", "ends", "height"), bar[1:], limits):
        if number(name, value, least=0) > most:
            yield f"The {name} may be {most:.4g} at most, yours is {value:.4g}."
    _, mass = weigh(length, ends)
    if mass > WEIGHT + 1e-9:
        yield f"""This bar weighs {mass:.2f} kg, {WEIGHT:g} kg is the most: does a kilogram do more
            in the tube or at its ends?"""
    gain = pl.recoverable_tilt(barred(rig, *bar)) / pl.recoverable_tilt(rig)
    if gain < BETTER:
        yield f"""With this bar the recoverable tilt is {gain:.2f} times the bare one, {BETTER:g} is
            asked for. Inertia helps, weight high up hurts: what gives inertia for little weight,
            and where does weight hurt least?"""
    return "A bar that is worth its weight."


def exercise_5(bar, design, rig):
    """A design that catches the pendulum with its bar."""
    yield before("The bar", "task 4", exercise_4(bar, rig))
    yield no_design(design)
    if not alike(design.rig, barred(rig, *bar)):
        yield "The design belongs to another rig; make it for barred(rig, *bar)."
    yield unstable(design.filtered_loop)
    lean = CLOSE * pl.recoverable_tilt(design.rig)
    run = pl.simulate(design.rig, design.controller, 8, [lean, 0, 0], imperfections=REAL)
    if run.fell:
        yield f"""{fallen(run, f"Let go at {lean:.3f} rad")} Which motor is at its limit just
            before, and does it push the right way there?"""
    left = np.abs(run.angles[run.t > 7]).max()
    if left > CAUGHT:
        yield f"It stays up, but still swings by {left:.2f} rad in the eighth second."
    times = lean / pl.recoverable_tilt(rig)
    return f"Caught from {lean:.3f} rad, {times:.2f} times the bare recoverable tilt."
