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
    fig = kp_page(design)

    def update(k_p):
        return fig.update(design.changed(kp=k_p)).caption

    return Panel(
        "The spring k_p of motor 2",
        [_kp_slider(design)],
        View(fig, update, fig.moving),
        legend=(
            "k_p: voltage of motor 2 per radian between links 2 and 3, equation (18).",
            "Left: eigenvalues of the sampled model with this spring alone, on their branches.",
            f"Middle and right: loop 2, with F designed anew. {LOOPS}",
        ),
        presets={PAPER: {"k_p": design.kp}, "Far too soft": {"k_p": 0.3}, "Stiff": {"k_p": 60.0}},
    )


def weights_panel(name="double"):
    """Weights Q and R of the double or the triple: gain F, margins, eigenvalues, step."""
    design = paper_design(name)
    fig = weights_page(design)

    def update(**values):
        return fig.update(design.changed(**_weights(values, design))).caption

    return Panel(
        f"Weights Q and R of the {name}",
        _weight_sliders(design),
        View(fig, update, fig.moving),
        legend=(
            "Q: what a deviation of each state costs, equation (22); the lowest notch is 0. w is the "
            "integral of the tracking error. R: what voltage costs.",
            LOOPS,
            "Eigenvalues of the closed loop with filters; crosses lie outside the unit circle.",
            "Step: answer of the linear loop with filters, time on a logarithmic scale.",
        ),
        presets={
            PAPER: _weight_values(design),
            "Faster integrator": {"Q" + str(len(design.Q)): 100 * design.Q[-1]},
            "Cheap voltage": {"R": design.R[0] / 100},
        },
        first=("Q2", f"Q{len(design.Q)}", "R"),
    )


def observer_panel(name="double"):
    """E and the choice in the null space: loops with filters, L, noise gain."""
    design = paper_design(name)
    fig = observer_page(design)
    controls, presets = OBSERVERS[name]

    def update(**values):
        return fig.update(CHOOSE[name](design, **values)).caption

    choice = {
        "double": (
            "E: eigenvalue of the observer. beta1, beta2: T = beta1 T1 + beta2 T2 as in (26), with the "
            "members of E's family nearest to the printed (24) and (25).",
            "Without filters every choice gives the same loop; with filters they differ.",
        ),
        "triple": (
            "alpha, beta: E = diag(alpha, beta). phi1, phi2: direction of each row of [T K] in its "
            "plane of solutions; 0 is nearest to the printed (36).",
            "With alpha = beta the directions change T and L and nothing that a signal could notice.",
        ),
    }
    return Panel(
        f"E and the choice in the null space, {name}",
        controls,
        View(fig, update, fig.moving, idle=IDLE.get(name)),
        legend=(
            *choice[name],
            LOOPS,
            "Right: how much voltage motor 1 makes of each reading; high at high frequency is noise.",
        ),
        presets=presets,
    )


def triple_panel():
    """All in one for the triple: Q, R, k_p, E; Figs 10, 11, 12, 14 and a run on the bench."""
    design = paper_design("triple")
    rig = design.rig
    imperfections, start, stands = bench_imperfections(rig), bench_start(rig), bench_rig(rig)

    def run(design):
        return simulate(stands, design.controller, 8.0, initial=start, imperfections=imperfections)

    fig = triple_page(design, run)

    def update(k_p, alpha, beta, **values):
        changed = design.changed(kp=k_p, **_weights(values, design))
        return fig.update(near_printed(changed, (alpha, beta))).caption

    weights = _weight_values(design)
    paper = {**weights, "k_p": design.kp, "alpha": design.E[0], "beta": design.E[1]}
    controls = [*_weight_sliders(design), _kp_slider(design), *_E_sliders(design)]
    return Panel(
        "The triple, all in one",
        controls,
        View(fig, update, fig.moving),
        legend=(
            "Q and R: weights of (22). k_p: spring of motor 2. alpha, beta: eigenvalues of the observer, "
            "whose T is the one nearest to the printed (36).",
            LOOPS,
            "det(I + PG) must go round 0; the smallest singular value says how near the whole loop is "
            "to singular.",
            "Below: the nonlinear pendulum with filters, limits, converters, friction and backlash.",
        ),
        presets={PAPER: paper, "Softer spring": {"k_p": 4.0}},
        first=("k_p", "R", "alpha"),
    )


# Designs from the values of controls


def near_printed(design, E, coefficients=None):
    """`design` with the triple's E = diag(E) and, row by row, the directions nearest to (36).

    Rows of [T K] decouple for a diagonal E, and their length is free. `coefficients` turns each
    row's direction in its plane by that many degrees.
    """
    design = design.changed(E=E)
    printed = paper_design("triple").observer
    rows = np.hstack([printed.T, printed.K])
    n, angles = printed.T.shape[1], np.radians((0, 0) if coefficients is None else coefficients)
    c = np.zeros(design.family.dimension)
    for i, angle in enumerate(angles):
        first, second = (_in_row(design.family, i, row, n) for row in (rows[i], rows[1 - i]))
        across = second - (second @ first) / (first @ first) * first
        across = across * np.linalg.norm(first) / np.linalg.norm(across)
        c += np.cos(angle) * first + np.sin(angle) * across
    return design.changed(coefficients=tuple(c))


def _in_row(family, i, row, n):
    """Coefficients of [t k] put into row i of [T K], nearest member."""
    T, K = np.zeros((2, n)), np.zeros((2, len(row) - n))
    T[i], K[i] = row[:n], row[n:]
    return family.project(T, K)


def between_printed(design, E, beta1, beta2):
    """`design` with the double's E and (26): beta1, beta2 of the members nearest to (24), (25)."""
    design = design.changed(E=(E,))
    first, second = (paper_design("double", k).observer for k in (1, 2))
    c = beta1 * design.family.project(first.T, first.K)
    c = c + beta2 * design.family.project(second.T, second.K)
    return design.changed(coefficients=tuple(c))


def turned(design, alpha, beta, phi1, phi2):
    """`design` with the triple's E and its directions turned by phi1, phi2 (degrees)."""
    return near_printed(design, (alpha, beta), (phi1, phi2))


def directions_idle(values):
    """With equal eigenvalues every direction is another description of the same observer."""
    if values["alpha"] != values["beta"]:
        return {}
    return dict.fromkeys(("phi1", "phi2"), "moves no loop while alpha = beta")


IDLE = {"triple": directions_idle}
CHOOSE = {"double": between_printed, "triple": turned}


def _weights(values, design):
    Q = tuple(values[f"Q{k + 1}"] for k in range(len(design.Q)))
    return dict(Q=Q, R=(values["R"],))


def _weight_values(design):
    return {**{f"Q{k + 1}": q for k, q in enumerate(design.Q)}, "R": design.R[0]}


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


def _E_sliders(design):
    return [
        Slider(name, f"{name} of E", 0, 1, e, step=0.01)
        for name, e in zip(("alpha", "beta"), design.E, strict=True)
    ]


OBSERVERS = {
    "double": (
        [
            Slider("E", "E", 0, 1, 0.9, step=0.01),
            Slider("beta1", "beta1", -2, 2, 1.0, step=0.05),
            Slider("beta2", "beta2", -2, 2, 0.0, step=0.05),
        ],
        {
            "Observer 1, (24)": dict(E=0.9, beta1=1.0, beta2=0.0),
            "Observer 2, (25)": dict(E=0.9, beta1=0.0, beta2=1.0),
            "Neither": dict(beta1=0.0, beta2=0.0),
        },
    ),
    "triple": (
        [
            Slider("alpha", "alpha of E", 0, 1, 0.9, step=0.01),
            Slider("beta", "beta of E", 0, 1, 0.9, step=0.01),
            Slider("phi1", "phi1, degrees", -90, 90, 0.0, step=1),
            Slider("phi2", "phi2, degrees", -90, 90, 0.0, step=1),
        ],
        {
            PAPER: dict(alpha=0.9, beta=0.9, phi1=0.0, phi2=0.0),
            "Two different eigenvalues": dict(alpha=0.9, beta=0.8),
        },
    ),
}
