"""Widgets of the design: k_p, Q and R, E with the choice in the null space, all in one."""

import numpy as np

from ..bench.gearbox import bench_imperfections, bench_rig, bench_start
from ..bench.simulation import simulate
from ..figures.outcomes import angle_in_words
from ..figures.pages import kp_page, observer_page, triple_page, weights_page
from ..paper.designs import paper_design
from .panel import Panel
from .parts import Slider, View

PAPER = "Paper's values"
LOOPS = (
    "Black: loop gain without filters, dashed: with them. The cross is -1; ▼ marks where a curve "
    "meets the real axis, ● where it meets the unit circle. In words: the factors that the gain "
    "bears, the phase that it bears, and the smallest distance from -1, where instability begins."
)


def kp_panel():
    """k_p of the triple: eigenvalues on the root locus of Fig 6, and the margins of loop 2."""
    design = paper_design("triple")
    return page_panel(
        "The spring k_p of motor 2",
        kp_page(design),
        lambda k_p: design.changed(kp=k_p),
        [_kp_slider(design)],
        legend=(
            "k_p: voltage of motor 2 per radian between links 2 and 3, equation (18).",
            "Left: eigenvalues of the sampled model with this spring alone, on their branches.",
            f"Middle and right: loop 2, with F designed anew. {LOOPS}",
        ),
        presets={"Far too soft": {"k_p": 0.3}, "Stiff": {"k_p": 60.0}},
    )


def weights_panel(name="double"):
    """Weights Q and R of the double or the triple: gain F, margins, eigenvalues, step."""
    design = paper_design(name)
    return page_panel(
        f"Weights Q and R of the {name}",
        weights_page(design),
        lambda **values: design.changed(**_weights(values, design)),
        _weight_sliders(design),
        legend=(
            "Q: what a deviation of each state costs, equation (22); the lowest notch is 0. w is the "
            "integral of the tracking error. R: what voltage costs.",
            LOOPS,
            "Eigenvalues of the closed loop with filters; crosses lie outside the unit circle.",
            "Step: answer of the linear loop with filters, time on a logarithmic scale.",
        ),
        presets={
            "Faster integrator": {"Q" + str(len(design.Q)): 100 * design.Q[-1]},
            "Cheap voltage": {"R": design.R[0] / 100},
        },
        first=("Q2", f"Q{len(design.Q)}", "R"),
    )


def observer_panel(name="double"):
    """E and the choice in the null space: loops with filters, L, noise gain."""
    design = paper_design(name)
    choose, controls, choice, start, presets, idle = OBSERVERS[name]
    return page_panel(
        f"E and the choice in the null space, {name}",
        observer_page(design),
        lambda **values: choose(design, **values),
        controls,
        legend=(
            *choice,
            LOOPS,
            "Right: how much voltage motor 1 makes of each reading; high at high frequency is noise.",
        ),
        presets=presets,
        start=start,
        idle=idle,
    )


def triple_panel():
    """All in one for the triple: Q, R, k_p, E; Figs 10, 11, 12, 14 and a run on the bench."""
    design = paper_design("triple")
    bench = bench_imperfections(design.rig)
    rig, start = bench_rig(design.rig), bench_start(design.rig)

    def run(design):
        return simulate(rig, design.controller, 8.0, initial=start, imperfections=bench)

    def change(k_p, alpha, beta, **values):
        return near_printed(design.changed(kp=k_p, **_weights(values, design)), alpha, beta)

    return page_panel(
        "The triple, all in one",
        triple_page(design, run),
        change,
        [*_weight_sliders(design), _kp_slider(design), *E_SLIDERS],
        legend=(
            "Q and R: weights of (22). k_p: spring of motor 2. alpha, beta: eigenvalues of the observer, "
            "whose T is the one nearest to the printed (36).",
            LOOPS,
            "det(I + PG) must go round 0; the smallest singular value says how near the whole loop is "
            "to singular.",
            "Below: the nonlinear pendulum with filters, limits, converters, friction and backlash.",
        ),
        presets={"Softer spring": {"k_p": 4.0}},
        first=("k_p", "R", "alpha"),
    )


def page_panel(
    title, page, change, controls, *, legend, presets, start=PAPER, first=None, idle=None
):
    """A panel round a page of pictures; `change` makes a design of the controls' values.

    `start` is the name of the values with which it starts, as a preset.
    """

    def update(**values):
        return page.update(change(**values)).caption

    view = View(page, update, page.moving, idle=idle)
    presets = {start: {c.name: c.value for c in controls}, **presets}
    return Panel(title, controls, view, legend, presets, first=first)


# Designs from the values of controls


def near_printed(design, alpha, beta, phi1=0.0, phi2=0.0):
    """`design` with the triple's E = diag(alpha, beta) and the directions nearest to (36).

    Rows of [T K] decouple for a diagonal E, and their length is free. phi1, phi2 turn each row's
    direction in its plane by that many degrees.
    """
    design = design.changed(E=(alpha, beta))
    printed = paper_design("triple").observer
    c = np.zeros(design.family.dimension)
    for i, angle in enumerate(np.radians([phi1, phi2])):
        here = np.arange(2)[:, None] == i  # row i of [T K] takes a printed row, the other is 0
        first, second = (
            design.family.project(np.where(here, printed.T[k], 0), np.where(here, printed.K[k], 0))
            for k in (i, 1 - i)
        )
        across = second - (second @ first) / (first @ first) * first
        across = across * np.linalg.norm(first) / np.linalg.norm(across)
        c += np.cos(angle) * first + np.sin(angle) * across
    return design.changed(coefficients=tuple(c))


def between_printed(design, E, beta1, beta2):
    """`design` with the double's E and (26): beta1, beta2 of the members nearest to (24), (25)."""
    design = design.changed(E=(E,))
    first, second = (paper_design("double", k).observer for k in (1, 2))
    c = beta1 * design.family.project(first.T, first.K)
    c = c + beta2 * design.family.project(second.T, second.K)
    return design.changed(coefficients=tuple(c))


def directions_idle(values):
    """With equal eigenvalues every direction is another description of the same observer."""
    if values["alpha"] != values["beta"]:
        return {}
    return dict.fromkeys(("phi1", "phi2"), "moves no loop while alpha = beta")


def _weights(values, design):
    Q = tuple(values[f"Q{k + 1}"] for k in range(len(design.Q)))
    return dict(Q=Q, R=(values["R"],))


# Controls


def _weight_sliders(design):
    n = design.rig.n_links
    angles = [angle_in_words(i) for i in range(1, n + 1)]
    labels = [f"{angle}, 1/rad²" for angle in angles]
    labels += [f"rate of {angle}, s²/rad²" for angle in angles]
    labels += ["weight of w, 1/(rad s)²"]
    return [
        Slider(f"Q{k + 1}", f"Q{k + 1}: {label}", 1e-4, 1e4, weight, log=True, zero=True)
        for k, (label, weight) in enumerate(zip(labels, design.Q, strict=True))
    ] + [Slider("R", "R: u1, 1/V²", 1e-3, 1e3, design.R[0], log=True)]


def _kp_slider(design):
    return Slider("k_p", "k_p, V/rad", 0.1, 100, design.kp, log=True, zero=True)


E_SLIDERS = [Slider(name, f"{name} of E", 0, 1, 0.9, step=0.01) for name in ("alpha", "beta")]

# Rig -> how a design is chosen, controls, what they do, the values at first and others, what is idle
OBSERVERS = {
    "double": (
        between_printed,
        [
            Slider("E", "E", 0, 1, 0.9, step=0.01),
            Slider("beta1", "beta1", -2, 2, 1.0, step=0.05),
            Slider("beta2", "beta2", -2, 2, 0.0, step=0.05),
        ],
        (
            "E: eigenvalue of the observer. beta1, beta2: T = beta1 T1 + beta2 T2 as in (26), with the "
            "members of E's family nearest to the printed (24) and (25).",
            "Without filters every choice gives the same loop; with filters they differ.",
        ),
        "Observer 1, (24)",
        {
            "Observer 2, (25)": dict(E=0.9, beta1=0.0, beta2=1.0),
            "Neither": dict(beta1=0.0, beta2=0.0),
        },
        None,
    ),
    "triple": (
        near_printed,
        [
            *E_SLIDERS,
            Slider("phi1", "phi1, degrees", -90, 90, 0.0, step=1),
            Slider("phi2", "phi2, degrees", -90, 90, 0.0, step=1),
        ],
        (
            "alpha, beta: E = diag(alpha, beta). phi1, phi2: direction of each row of [T K] in its "
            "plane of solutions; 0 is nearest to the printed (36).",
            "With alpha = beta the directions change T and L and nothing that a signal could notice.",
        ),
        PAPER,
        {"Two different eigenvalues": dict(alpha=0.9, beta=0.8)},
        directions_idle,
    ),
}
