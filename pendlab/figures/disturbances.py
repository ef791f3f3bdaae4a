"""What noise and torques do in closed loop, and how far the two gains may stray.

The figures take a dict from label to `Design`.
"""

import numpy as np
from matplotlib.colors import ListedColormap

from .._arguments import instance, number, whole
from ..bench.arguments import mapping
from ..design import Design
from ..loop import frequency_response
from ..studies.transmission import closed_loop, peak_gain
from .frequency import HZ
from .style import COLORS, angle_name, describe, look, new_figure, styled

STROKES = ("--", "-", ":", "-.")  # one for each design; the colour says which signal


def gains(design, hz):
    """Gains over frequency with filters: of noise, of torques, and the torques' peaks.

    Noise: sqrt(sum of |readings -> u_i|^2), in shares of u_max per rad (rad/s). Torque: length of the
    vector of relative angles per N m on link i.
    """
    loop, n = closed_loop(design), design.rig.n_links
    T = np.abs(frequency_response(loop, HZ * hz))
    u_max, q = np.array(design.rig.u_max), n + 1
    noise = np.sqrt((T[:, n:, :q] ** 2).sum(axis=2)) / u_max
    torque = np.sqrt((T[:, :n, q : q + n] ** 2).sum(axis=1))
    peaks = [peak_gain(loop[:n, q + i])[0] for i in range(n)]
    return noise.T, torque.T, peaks


def draw_transmission(ax, hz, looks, curves):
    """Curves over frequency on two logarithmic axes; `curves` has for each design (signals, len(hz)).

    A signal has one of `looks`, a design one of `STROKES`.
    """
    ax.set(xscale="log", yscale="log", xlabel="frequency, Hz", xlim=(hz[0], hz[-1]))
    widths = np.linspace(3.2, 1.2, len(looks))  # told apart without colour, and where they coincide
    for one, width, *rows in zip(looks, widths, *curves.values()):
        ax.plot([], [], **{**one, "linewidth": width})
        for row, stroke in zip(rows, STROKES):
            ax.plot(hz, row, **{**one, "linewidth": width, "linestyle": stroke, "label": None})
    for label, stroke in zip(curves, STROKES):
        ax.plot([], [], color=COLORS["grey"], linestyle=stroke, label=label)
    ax.legend(loc="best")


@styled()
def transmission_figure(designs, points=400):
    """Readings -> voltages and torques -> angles over frequency, with filters, for each design."""
    n, m = _sizes(designs)
    dt = next(iter(designs.values())).dt
    hz = np.geomspace(0.01, 0.5 / dt, whole("points", points, least=2, most=100_000))
    noise, torque, peaks = (
        dict(zip(designs, each))
        for each in zip(*(gains(design, hz) for design in designs.values()))
    )
    fig = new_figure(10, 4.2)
    left, right = fig.subplots(1, 2)
    left.set(title="noise to voltages", ylabel="share of the limit per rad")
    right.set(title="torque to angles", ylabel="rad per N m")
    draw_transmission(left, hz, [look(f"u{i + 1}", linestyle="-") for i in range(m)], noise)
    links = [look(angle_name(i), label=f"torque on link {i}") for i in range(1, n + 1)]
    draw_transmission(right, hz, [{**link, "linestyle": "-"} for link in links], torque)
    each = "; ".join(
        f"{label}: {', '.join(f'{peak:.2g}' for peak in listed)}" for label, listed in peaks.items()
    )
    return describe(
        fig,
        f"Largest gain from a torque on links 1 to {n} to the angles, in rad per N m: {each}.",
        "Two panels over frequency, logarithmic. Left: gain from noise in the readings to each "
        "voltage as a share of its limit. Right: gain from a torque on each link to the angles. "
        f"One line style per design: {', '.join(designs)}.",
    )


def largest_eigenvalue(loop, factors):
    """Largest closed-loop |eigenvalue| with input 1 times g1 and input 2 times g2, as (g2, g1)."""
    g1, g2 = np.meshgrid(factors, factors)
    BgC = np.einsum("ik,gk,kj->gij", loop.B, np.stack([g1.ravel(), g2.ravel()], axis=1), loop.C)
    return np.abs(np.linalg.eigvals(loop.A - BgC)).max(axis=1).reshape(g1.shape)


@styled()
def gain_region_figure(designs, points=61, reach=10.0):
    """For each design a panel of the gain factors at both inputs that keep it stable, with filters."""
    _sizes(designs, motors=2)
    number("reach", reach, above=1, most=1e6)
    points = whole("points", points, least=2, most=501)
    factors = np.geomspace(1 / reach, reach, points)  # an odd count has 1 among them
    fig = new_figure(4.6 * len(designs), 4.4)
    colors = ListedColormap([COLORS["pale"], COLORS["sky"]])
    shares = []
    for ax, (label, design) in zip(
        fig.subplots(1, len(designs), squeeze=False)[0], designs.items()
    ):
        stable = largest_eigenvalue(design.filtered_loop, factors) < 1
        ax.pcolormesh(factors, factors, stable, cmap=colors, vmin=0, vmax=1, shading="nearest")
        ax.plot([1], [1], **look("critical", label="as designed"))
        ax.set(xscale="log", yscale="log", title=label)
        ax.set(xlabel="factor at input 1", ylabel="factor at input 2", aspect="equal")
        ax.grid(False)
        ax.legend(loc="upper left")
        shares.append(f"{stable.mean():.0%} ({label})")
    return describe(
        fig,
        f"Gains at both inputs changed at once, each from 1/{reach:g} to {reach:g} times the "
        f"designed one: stable in the coloured part, {' and '.join(shares)} of the square.",
        "One square per design with logarithmic axes, the factor at input 1 to the right and at "
        "input 2 upwards; the stable part is coloured and the designed point is marked.",
    )


def _sizes(designs, motors=None):
    """(links, motors) of the rigs, the same in the whole dict of designs; `motors` there must be."""
    example = '{"paper": pl.paper_design("triple")}'
    for label, design in mapping("designs", designs, example).items():
        instance(f"designs[{label!r}]", design, Design)
    if len(designs) > len(STROKES):
        raise ValueError(f"designs: at most {len(STROKES)} fit, found {len(designs)}.")
    sizes = {(design.rig.n_links, design.rig.n_motors) for design in designs.values()}
    if len(sizes) > 1:
        each = " and ".join(f"{n} links with {m} motors" for n, m in sorted(sizes))
        raise ValueError(f"designs: expected as many links and motors in all, found {each}.")
    ((links, found),) = sizes
    if motors not in (None, found):
        raise ValueError(f"designs: expected rigs with {motors} motors; try {example}.")
    return links, found
