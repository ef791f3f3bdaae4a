"""The figures of the paper, drawn from a rig and a design that can be changed.

`figure` gives any of them by its number, `show` displays one with its caption in a notebook, `save`
writes it as PNG and SVG.
"""

import html
import re
from numbers import Integral

from matplotlib.figure import Figure

from .._arguments import found, instance, text
from ..bench.arguments import path
from ..bench.simulation import Run
from ..design import Design
from ..parameters import Pendulum, load
from . import apparatus, blocks, experiments, loops, schematics, style
from .style import new_figure

__all__ = ["figure", "new_figure", "save", "show"]

# Number -> the function that draws it; of a rig, also the paper's rig for it.
OF_A_RIG = {
    1: (apparatus.apparatus, "triple"),
    2: (schematics.schematic, "double"),
    3: (schematics.schematic, "triple"),
    4: (blocks.apparatus_blocks, "triple"),
}
OF_NOTHING = {5: blocks.observer_blocks, 9: blocks.triple_loops}
OF_A_DESIGN_OR_RUN = {
    6: loops.locus_figure,
    14: loops.sigma_figure,
    **dict.fromkeys((7, 13), loops.whole_figure),
    **dict.fromkeys((8, 10, 11, 12), loops.near_figure),
    **dict.fromkeys((15, 16, 17), experiments.experiment),
}


def figure(number, design=None, **options):
    """A figure of the paper as a matplotlib Figure with ``.caption`` and ``.alt``.

    Parameters
    ----------
    number : the paper's number
    design : Design, by default the paper's; for the drawings 1 to 4 a Pendulum too, for the traces
        15 to 17 a Run. The diagrams 5 and 9 are the same for every design.
    options : passed on to the function that draws it, such as ``angles`` of 2 and 3, ``kps`` of 6,
        ``other`` of 8

    Raises
    ------
    ValueError : a number without a figure here, or a design that has not what the figure shows

    >>> figure(5).caption[:6]
    'Fig 5.'
    """
    if not isinstance(number, Integral) or isinstance(number, bool) or number not in numbers():
        known = ", ".join(map(str, numbers()))
        raise ValueError(
            f"number: expected a figure of the paper, one of {known}, {found(number)}."
        )
    if number in OF_A_RIG:
        draw, name = OF_A_RIG[number]
        rig = design.rig if isinstance(design, Design) else design
        rig = load(name) if rig is None else instance("design", rig, Pendulum, f'pl.load("{name}")')
        return draw(rig, **options)
    if number in OF_NOTHING:
        return OF_NOTHING[number](**options)
    if number >= 15 and design is not None:
        instance("design", design, Run, "pl.simulate(...)")
    return OF_A_DESIGN_OR_RUN[number](number, design, **options)


def numbers():
    """The numbers of all figures, in order."""
    return sorted([*OF_A_RIG, *OF_NOTHING, *OF_A_DESIGN_OR_RUN])


def show(fig):
    """Display a figure in a notebook: the picture, then caption and folded description as text."""
    from IPython.display import Markdown, display

    instance("fig", fig, Figure, "pl.new_figure()")
    display(style.bundle(fig), raw=True)
    words = re.sub(r"^(Fig \d+\.)", r"**\1**", getattr(fig, "caption", ""))
    alt = getattr(fig, "alt", "")
    folded = f"<details><summary>Description</summary>{html.escape(alt)}</details>" if alt else ""
    if words or folded:
        display(Markdown(f"{words}\n\n{folded}".strip()))


def save(fig, folder, name):
    """Write ``name.png`` and ``name.svg`` into `folder`, equal for equal figures; their two paths."""
    instance("fig", fig, Figure, "pl.new_figure()")
    folder, name = path("folder", folder), text("name", name)
    folder.mkdir(parents=True, exist_ok=True)
    return tuple(style.save(fig, folder / f"{name}.{suffix}") for suffix in ("png", "svg"))
