"""What noise and torques do in closed loop, and how far the two gains may stray.

``draw_...`` creates the artists once and returns ``update(data)``; the figure functions take a dict
from label to `Design` and have ``fig.update(designs)`` for as many others.
"""

import numpy as np

from .._arguments import found, number, whole
from ..design import Design
from ..loop import frequency_response
from ..studies.transmission import closed_loop, peak_gain
from .frequency import HZ
from .style import COLORS, angle_name, look, new_figure, styled
from .updates import live, part

STROKES = ("--", "-", ":", "-.")  # one for each design; the colour says which signal


def gains(design, hz):
    """Gains over frequency with filters: (name, look, values) of both panels.

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


def draw_transmission(ax, hz, curves, names, labels):
    """Curves over frequency on two logarithmic axes.

    Parameters
    ----------
    curves : for every design an array (signals, len(hz))
    names : looks of the signals; labels : names of the designs

    Returns
    -------
    update(curves)
    """
    lines = []
    for values, stroke in zip(curves, STROKES):
        styles = [look(name, linestyle=stroke) for name in names]
        lines.append([ax.loglog(hz, row, **style)[0] for row, style in zip(values, styles)])
    for line in (line for group in lines for line in group):
        line.set_label("_")
    signals = [ax.plot([], [], **look(name, linestyle="-"))[0] for name in names]
    designs = [
        ax.plot([], [], color=COLORS["grey"], linestyle=stroke, label=label)[0]
        for label, stroke in zip(labels, STROKES)
    ]
    ax.set(xlabel="frequency, Hz", xlim=(hz[0], hz[-1]))
    ax.legend(handles=signals + designs, loc="best")

    def update(curves):
        for group, values in zip(lines, curves, strict=True):
            for line, row in zip(group, values, strict=True):
                line.set_ydata(row)
        ax.relim()
        ax.autoscale_view(scalex=False)

    return update


@styled()
def transmission_figure(designs, points=400):
    """Readings -> voltages and torques -> angles over frequency, with filters, for each design."""
    count, first = len(_each_design(designs)), next(iter(designs.values()))
    n, m = first.rig.n_links, first.rig.n_motors
    hz = np.geomspace(0.01, 0.5 / first.dt, whole("points", points, least=2, most=100_000))
    voltages, links = [f"u{i + 1}" for i in range(m)], [angle_name(i + 1) for i in range(n)]
    fig = new_figure(10, 4.2)
    left, right = fig.subplots(1, 2)

    def compute(designs):
        designs = _each_design(designs, count=count)
        return [*zip(*(gains(design, hz) for design in designs.values())), list(designs)]

    def draw(data):
        moves = [
            part(draw_transmission(left, hz, data[0], voltages, designs), 0),
            part(draw_transmission(right, hz, data[1], links, designs), 1),
        ]
        for text, i in zip(right.get_legend().get_texts(), range(n)):
            text.set_text(f"torque on link {i + 1}")
        left.set(title="noise to voltages", ylabel="share of the limit per rad")
        right.set(title="torque to angles", ylabel="rad per N m")

        def rename(data):
            for ax in (left, right):
                for text, label in zip(ax.get_legend().get_texts()[-count:], data[3], strict=True):
                    text.set_text(label)

        return [*moves, rename]

    def say(data, designs):
        each = "; ".join(
            f"{label}: {', '.join(f'{peak:.2g}' for peak in peaks)}"
            for label, peaks in zip(designs, data[2])
        )
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


def draw_gain_region(ax, factors, stable):
    """Which pairs of gain factors keep the loop stable; ``update(stable)`` with booleans (g2, g1)."""
    from matplotlib.colors import ListedColormap

    colors = ListedColormap([COLORS["pale"], COLORS["sky"]])
    mesh = ax.pcolormesh(
        factors, factors, stable.astype(float), cmap=colors, vmin=0, vmax=1, shading="nearest"
    )
    ax.plot([1], [1], **look("critical", label="as designed"))
    ax.set(xscale="log", yscale="log", xlabel="factor at input 1", ylabel="factor at input 2")
    ax.set_aspect("equal")
    ax.grid(False)
    ax.legend(loc="upper left")

    def update(stable):
        mesh.set_array(stable.astype(float))

    return update


@styled()
def gain_region_figure(designs, points=61, reach=10.0):
    """For each design a panel of the gain factors at both inputs that keep it stable, with filters."""
    count = len(_each_design(designs, motors=2))
    number("reach", reach, above=1, most=1e6)
    points = whole("points", points, least=2, most=501)
    factors = np.geomspace(1 / reach, reach, points)  # an odd count has 1 among them
    fig = new_figure(4.6 * count, 4.4)
    axes = np.ravel(fig.subplots(1, count))

    def compute(designs):
        return {
            label: largest_eigenvalue(design.filtered_loop, factors) < 1
            for label, design in _each_design(designs, motors=2, count=count).items()
        }

    def draw(data):
        moves = [
            draw_gain_region(ax, factors, stable)
            for ax, stable in zip(axes, data.values(), strict=True)
        ]

        def redraw(data):
            for ax, move, (label, stable) in zip(axes, moves, data.items(), strict=True):
                move(stable)
                ax.set_title(label)

        redraw(data)
        return [redraw]

    def say(data, designs):
        each = " and ".join(f"{stable.mean():.0%} ({label})" for label, stable in data.items())
        return (
            f"Gains at both inputs changed at once, each from 1/{reach:g} to {reach:g} times the "
            f"designed one: stable in the coloured part, {each} of the square.",
            "One square per design with logarithmic axes, the factor at input 1 to the right and at "
            "input 2 upwards; the stable part is coloured and the designed point is marked.",
        )

    return live(fig, draw, compute, say, designs)


def _each_design(designs, motors=None, count=None):
    """The dict of designs, one kind of rig in all; `motors` and `count` say how many there must be."""
    if not isinstance(designs, dict) or not designs:
        raise TypeError(
            f"designs: expected a dict from label to pl.Design, {found(designs)}; "
            'try {"paper": pl.paper_design("triple")}.'
        )
    for label, design in designs.items():
        if not isinstance(design, Design):
            raise TypeError(f"designs[{label!r}]: expected a pl.Design, {found(design)}.")
    if len(designs) > len(STROKES):
        raise ValueError(f"designs: at most {len(STROKES)} fit, found {len(designs)}.")
    if count is not None and len(designs) != count:
        raise ValueError(f"designs: this figure was made for {count}, found {len(designs)}.")
    sizes = {(design.rig.n_links, design.rig.n_motors) for design in designs.values()}
    if len(sizes) > 1:
        raise ValueError(
            "designs: expected rigs with as many links and motors in all, found "
            f"{' and '.join(f'{n} links with {m} motors' for n, m in sorted(sizes))}."
        )
    if motors is not None and sizes.pop()[1] != motors:
        raise ValueError(
            f'designs: expected rigs with {motors} motors; try {{"paper": pl.paper_design("triple")}}.'
        )
    return designs
