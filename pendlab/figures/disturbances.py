"""What noise and torques do in closed loop, and how far the two gains may stray.

The figures take a dict from label to `Design` and have ``fig.update(designs)`` for as many others.
"""

import numpy as np
from matplotlib.colors import ListedColormap

from .._arguments import instance, number, whole
from ..bench.arguments import mapping
from ..design import Design
from ..loop import frequency_response
from ..studies.transmission import closed_loop, peak_gain
from .frequency import HZ
from .picture import follow, live, part
from .style import COLORS, angle_name, look, new_figure, styled

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


def draw_transmission(ax, hz, looks, data):
    """Curves over frequency on two logarithmic axes, in one of `looks` for each signal.

    `data` are the names of the designs and for each an array (signals, len(hz)). Returns
    update(data).
    """
    strokes = STROKES[: len(data[0])]
    widths = np.linspace(3.2, 1.2, len(looks))  # told apart without colour, and where they coincide
    looks = [{**look, "linewidth": width} for look, width in zip(looks, widths)]
    ax.set(xscale="log", yscale="log", xlabel="frequency, Hz", xlim=(hz[0], hz[-1]))
    styles = [{**look, "linestyle": stroke} for stroke in strokes for look in looks]

    def rows(data):
        return [(hz, row) for values in data[1] for row in values]

    move = follow(ax, styles, data, rows)
    grey = [dict(color=COLORS["grey"], linestyle=stroke) for stroke in strokes]
    handles = [ax.plot([], [], **look)[0] for look in [*looks, *grey]]
    names = [*(look["label"] for look in looks), *data[0]]
    texts = ax.legend(handles, names, loc="best").get_texts()[len(looks) :]

    def update(data):
        move(data)
        ax.relim()
        ax.autoscale_view(scalex=False)
        for text, label in zip(texts, data[0], strict=True):
            text.set_text(label)

    update(data)
    return update


@styled()
def transmission_figure(designs, points=400):
    """Readings -> voltages and torques -> angles over frequency, with filters, for each design."""
    count, first = len(_each_design(designs)), next(iter(designs.values()))
    n, m = first.rig.n_links, first.rig.n_motors
    hz = np.geomspace(0.01, 0.5 / first.dt, whole("points", points, least=2, most=100_000))
    voltages = [look(f"u{i}", linestyle="-") for i in range(1, m + 1)]
    links = {angle_name(i): f"torque on link {i}" for i in range(1, n + 1)}
    torques = [look(name, linestyle="-", label=label) for name, label in links.items()]
    fig = new_figure(10, 4.2)
    left, right = fig.subplots(1, 2)

    def compute(designs):
        designs = _each_design(designs, count=count)
        noise, torque, peaks = zip(*(gains(design, hz) for design in designs.values()))
        return (list(designs), noise), (list(designs), torque), peaks

    def draw(data):
        left.set(title="noise to voltages", ylabel="share of the limit per rad")
        right.set(title="torque to angles", ylabel="rad per N m")
        return [
            part(draw_transmission(left, hz, voltages, data[0]), 0),
            part(draw_transmission(right, hz, torques, data[1]), 1),
        ]

    def say(data, designs):
        peaks = [", ".join(f"{peak:.2g}" for peak in peaks) for peaks in data[2]]
        each = "; ".join(f"{label}: {listed}" for label, listed in zip(designs, peaks))
        return (
            f"Largest gain from a torque on links 1 to {n} to the angles, in rad per N m: {each}.",
            "Two panels over frequency, logarithmic. Left: gain from noise in the readings to each "
            "voltage as a share of its limit. Right: gain from a torque on each link to the angles. "
            f"One line style per design: {', '.join(designs)}.",
        )

    return live(fig, draw, compute, say, designs)


def largest_eigenvalue(loop, factors):
    """Largest closed-loop |eigenvalue| with input 1 times g1 and input 2 times g2, as (g2, g1)."""
    g1, g2 = np.meshgrid(factors, factors)
    BgC = np.einsum("ik,gk,kj->gij", loop.B, np.stack([g1.ravel(), g2.ravel()], axis=1), loop.C)
    return np.abs(np.linalg.eigvals(loop.A - BgC)).max(axis=1).reshape(g1.shape)


def draw_gain_region(ax, factors, data):
    """Which pairs of gain factors keep a loop stable; `data` are its name and booleans (g2, g1).

    Returns update(data).
    """
    colors = ListedColormap([COLORS["pale"], COLORS["sky"]])
    mesh = ax.pcolormesh(factors, factors, data[1], cmap=colors, vmin=0, vmax=1, shading="nearest")
    ax.plot([1], [1], **look("critical", label="as designed"))
    ax.set(xscale="log", yscale="log", xlabel="factor at input 1", ylabel="factor at input 2")
    ax.set_aspect("equal")
    ax.grid(False)
    ax.legend(loc="upper left")

    def update(data):
        ax.set_title(data[0])
        mesh.set_array(data[1])

    update(data)
    return update


@styled()
def gain_region_figure(designs, points=61, reach=10.0):
    """For each design a panel of the gain factors at both inputs that keep it stable, with filters."""
    count = len(_each_design(designs, motors=2))
    number("reach", reach, above=1, most=1e6)
    points = whole("points", points, least=2, most=501)
    factors = np.geomspace(1 / reach, reach, points)  # an odd count has 1 among them
    fig = new_figure(4.6 * count, 4.4)
    axes = fig.subplots(1, count, squeeze=False)[0]

    def compute(designs):
        designs = _each_design(designs, motors=2, count=count)
        return [
            (label, (largest_eigenvalue(design.filtered_loop, factors) < 1).astype(float))
            for label, design in designs.items()
        ]

    def draw(data):
        return [
            part(draw_gain_region(ax, factors, one), k)
            for k, (ax, one) in enumerate(zip(axes, data, strict=True))
        ]

    def say(data, designs):
        each = " and ".join(f"{stable.mean():.0%} ({label})" for label, stable in data)
        return (
            f"Gains at both inputs changed at once, each from 1/{reach:g} to {reach:g} times the "
            f"designed one: stable in the coloured part, {each} of the square.",
            "One square per design with logarithmic axes, the factor at input 1 to the right and at "
            "input 2 upwards; the stable part is coloured and the designed point is marked.",
        )

    return live(fig, draw, compute, say, designs)


def _each_design(designs, motors=None, count=None):
    """The dict of designs, one kind of rig in all; `motors` and `count` say how many there must be."""
    example = '{"paper": pl.paper_design("triple")}'
    for label, design in mapping("designs", designs, example).items():
        instance(f"designs[{label!r}]", design, Design)
    if len(designs) > len(STROKES):
        raise ValueError(f"designs: at most {len(STROKES)} fit, found {len(designs)}.")
    if count is not None and len(designs) != count:
        raise ValueError(f"designs: this figure was made for {count}, found {len(designs)}.")
    sizes = {(design.rig.n_links, design.rig.n_motors) for design in designs.values()}
    if len(sizes) > 1:
        each = " and ".join(f"{n} links with {m} motors" for n, m in sorted(sizes))
        raise ValueError(f"designs: expected as many links and motors in all, found {each}.")
    if motors is not None and sizes.pop()[1] != motors:
        raise ValueError(f"designs: expected rigs with {motors} motors; try {example}.")
    return designs
