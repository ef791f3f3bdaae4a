"""Would a bar help? Measures of controllability over the inertia added to each link.

Computing is apart from drawing: `bar_study` returns frozen values, `draw_bars` creates its artists
once and returns ``update(added)``, so that a slider for each link can drive it.
"""

from dataclasses import dataclass

import numpy as np

from .._arguments import array, found, instance, number
from ..parameters import Pendulum
from ..studies.controllability import ControllabilityMeasures, controllability_measures, with_bar
from .moving import check_rig, link_color
from .picture import live
from .style import COLORS, new_figure, styled

PANELS = ("singular-value ratio", "distance to uncontrollability", "tilt that can be caught")
LIMITS = (0.08, 20.0)  # of the drawn factors


@dataclass(frozen=True)
class BarStudy:
    """By which factor each measure improves with a bar on one link at a time."""

    rig: Pendulum  # without bars
    bare: ControllabilityMeasures  # of that rig
    inertias: np.ndarray  # (N,) added inertias, kg m^2
    factors: np.ndarray  # (n links, measures as in `PANELS`, N); above 1 is better

    def of(self, added):
        """The 3 factors with bars on all links at once; `added` has one inertia for each link."""
        added = array("added", added, (self.rig.n_links,))
        rig = self.rig
        for link, inertia in enumerate(added, 1):
            inertia = number(f"added[{link - 1}]", float(inertia), least=0, most=1e6)
            rig = with_bar(rig, link, inertia)
        return _factors(self.bare, controllability_measures(rig))

    def best(self, panel):
        """(link, inertia, factor) at which the measure number `panel` gains most."""
        values = self.factors[:, panel]
        link, k = np.unravel_index(values.argmax(), values.shape)
        return int(link) + 1, float(self.inertias[k]), float(values[link, k])


def bar_study(rig, inertias=None):
    """`BarStudy` of a rig; bars without mass, measures in the units of `controllability_measures`.

    `inertias` are rising, in kg m^2; by default 33 of them from 0.001 to 1.
    """
    inertias = (
        np.geomspace(1e-3, 1, 33) if inertias is None else array("inertias", inertias, (None,))
    )
    if not (
        len(inertias) and 0 < inertias[0] and inertias[-1] <= 1e6 and np.all(np.diff(inertias) > 0)
    ):
        raise ValueError(
            f"inertias: expected rising numbers above 0 and up to 1e6 kg m^2, {found(inertias)}."
        )
    bare = controllability_measures(check_rig(rig))
    factors = [
        [
            _factors(bare, controllability_measures(with_bar(rig, link, float(bar))))
            for bar in inertias
        ]
        for link in range(1, rig.n_links + 1)
    ]
    return BarStudy(rig, bare, inertias, np.array(factors).transpose(0, 2, 1))


def _factors(bare, measures):
    """By which factors the second rig is better than the first, in the order of `PANELS`."""
    return np.array(
        [
            bare.ratio / measures.ratio,
            measures.distance / bare.distance,
            measures.tilt / bare.tilt,
        ]
    )


@styled()
def draw_bars(axes, study):
    """Three panels of factors over the added inertia, one curve for each link.

    Returns ``update((factors, added))`` for bars on all links at once (kg m^2 each): a dashed level
    shows what they make of the rig, dots where each bar alone would be. It returns the moved artists.
    """
    n = study.rig.n_links
    moved = []
    for panel, (ax, title) in enumerate(zip(axes, PANELS)):
        ax.axhline(1, color=COLORS["grey"], linewidth=1, zorder=1)
        for link in range(n):
            style = ("-", "--", "-.")[link % 3]
            ax.loglog(study.inertias, np.maximum(study.factors[link, panel], 1e-9), style,
                      color=link_color(link + 1), label=f"bar on link {link + 1}")  # fmt: skip
        ax.set(xlim=study.inertias[[0, -1]], ylim=LIMITS, title=title)
        ax.set_yticks(
            [0.1, 0.2, 0.5, 1, 2, 5, 10, 20], ["0.1", "0.2", "0.5", "1", "2", "5", "10", "20"]
        )
        ax.minorticks_off()
        ax.set_xlabel("added inertia, kg m²")
        moved.append(ax.plot(study.inertias[[0, -1]], [1, 1], ":", color="black", linewidth=2,
                             zorder=4)[0])  # fmt: skip
        moved += [
            ax.plot([], [], "o", color=link_color(link + 1), markeredgecolor="black", markersize=7,
                    zorder=5)[0]
            for link in range(n)
        ]  # fmt: skip
    axes[0].set_ylabel("times better than without")

    def update(data):
        factors, added = data
        for panel in range(len(PANELS)):
            level, *dots = moved[panel * (n + 1) : (panel + 1) * (n + 1)]
            level.set_ydata(np.full(2, np.clip(factors[panel], *LIMITS) if any(added) else np.nan))
            for link, (dot, inertia) in enumerate(zip(dots, added)):
                on = inertia >= study.inertias[0]
                curve = study.factors[link, panel]
                value = np.exp(np.interp(np.log(max(inertia, 1e-9)), np.log(study.inertias),
                                         np.log(np.maximum(curve, 1e-9))))  # fmt: skip
                dot.set_data(*([inertia], [value]) if on else ([], []))
        return moved

    return update


@styled()
def bars(study, added=None, width=9.6, height=4.0):
    """The figure of a `BarStudy`, with bars of the inertias `added` marked; ``fig.update(added)``."""
    instance("study", study, BarStudy, "pl.bar_study(rig)")
    fig = new_figure(width, height)
    axes = fig.subplots(1, 3, sharey=True)
    by_distance, by_tilt = study.best(1), study.best(2)

    def compute(added):
        return study.of(added), array("added", added, (study.rig.n_links,))

    def draw(data):
        move = draw_bars(axes, study)
        handles, labels = axes[0].get_legend_handles_labels()
        fig.legend(handles, labels, loc="outside lower center", ncols=len(labels))
        return [move]

    def say(data, added):
        return (
            f"The {study.rig.name} pendulum with a bar on one link: the distance gains most, "
            f"{by_distance[2]:.1f} times, from a bar of {by_distance[1]:.2g} kg m² on link "
            f"{by_distance[0]}; the tilt that can be caught gains most, {by_tilt[2]:.1f} times, from "
            f"one of {by_tilt[1]:.2g} kg m² on link {by_tilt[0]}.",
            f"Three panels with logarithmic axes over the added inertia from {study.inertias[0]:g} to "
            f"{study.inertias[-1]:g} kg m^2, one curve for each link: by which factor the "
            f"singular-value ratio, the distance to uncontrollability and the largest tilt that can be "
            f"caught improve. Above 1 is better than without a bar.",
        )

    return live(fig, draw, compute, say, np.zeros(study.rig.n_links) if added is None else added)


def in_words(study, added):
    """What bars of the inertias `added` (kg m^2, one for each link) do, as a sentence."""
    ratio, distance, tilt = study.of(added)
    bars = (
        ", ".join(f"{bar:.3g} on link {i}" for i, bar in enumerate(added, 1) if bar > 0) or "none"
    )
    degrees = np.degrees(study.bare.tilt)
    return (
        f"Bars: {bars} (kg m²). Singular-value ratio {_times(ratio)}, distance to uncontrollability "
        f"{_times(distance)}; the largest tilt goes from {degrees:.1f} to {tilt * degrees:.1f} degrees."
    )


def _times(factor):
    if abs(factor - 1) < 0.005:
        return "unchanged"
    return f"{factor:.3g} times better" if factor > 1 else f"{1 / factor:.3g} times worse"
