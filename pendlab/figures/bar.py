"""Would a bar help? Measures of controllability over the inertia added to each link."""

from dataclasses import dataclass, replace

import numpy as np

from .._arguments import array, found, instance, numbers
from ..parameters import Pendulum
from ..studies.controllability import ControllabilityMeasures, controllability_measures, with_bar
from .moving import check_rig, link_color
from .picture import follow, live
from .style import COLORS, new_figure, styled

PANELS = ("singular-value ratio", "distance to uncontrollability", "tilt that can be caught")
LIMITS = (0.08, 20.0)  # of the drawn factors
TICKS = (0.1, 0.2, 0.5, 1, 2, 5, 10, 20)


@dataclass(frozen=True)
class BarStudy:
    """By which factor each measure improves with a bar on one link at a time."""

    rig: Pendulum  # without bars
    bare: ControllabilityMeasures  # of that rig
    inertias: np.ndarray  # (N,) added inertias, kg m^2
    factors: np.ndarray  # (n links, measures as in `PANELS`, N); above 1 is better

    def of(self, added):
        """The 3 factors, as in `PANELS`, with bars on all links; `added` has an inertia for each."""
        rig, links = self.rig, self.rig.n_links
        for link, inertia in enumerate(numbers("added", added, links, least=0, most=1e6), 1):
            rig = with_bar(rig, link, inertia)
        bare, now = self.bare, controllability_measures(rig)
        return np.array(
            [bare.ratio / now.ratio, now.distance / bare.distance, now.tilt / bare.tilt]
        )

    def best(self, panel):
        """(link, inertia, factor) at which the measure number `panel` gains most."""
        values = self.factors[:, panel]
        link, k = np.unravel_index(values.argmax(), values.shape)
        return int(link) + 1, float(self.inertias[k]), float(values[link, k])


def bar_study(rig, inertias=None):
    """`BarStudy` of a rig; bars without mass, measures in the units of `controllability_measures`.

    `inertias` are rising, in kg m^2; by default 33 of them from 0.001 to 1.
    """
    inertias = array(
        "inertias", np.geomspace(1e-3, 1, 33) if inertias is None else inertias, (None,)
    )
    rising = len(inertias) and 0 < inertias[0] and np.all(np.diff(inertias) > 0)
    if not rising or inertias[-1] > 1e6:
        raise ValueError(
            f"inertias: expected rising numbers above 0 and up to 1e6 kg m^2, {found(inertias)}."
        )
    study = BarStudy(rig, controllability_measures(check_rig(rig)), inertias, np.empty(0))
    alone = [[study.of(bar * link) for bar in inertias] for link in np.eye(rig.n_links)]
    return replace(study, factors=np.array(alone).transpose(0, 2, 1))


@styled()
def draw_bars(ax, study, panel):
    """One panel of factors over the added inertia, one curve for each link.

    Returns ``update((factors, added))`` for bars on all links at once (kg m^2 each): a dashed level
    shows what they make of the rig, dots where each bar alone would be. It returns the moved artists.
    """
    inertias, curves = study.inertias, np.maximum(study.factors[:, panel], 1e-9)
    ends = inertias[[0, -1]]
    ax.axhline(1, color=COLORS["grey"], linewidth=1, zorder=1)
    looks = [dict(color="black", linestyle=":", linewidth=2, zorder=4)]
    for link, curve in enumerate(curves, 1):
        color, stroke = link_color(link), ("-", "--", "-.")[(link - 1) % 3]
        ax.loglog(inertias, curve, stroke, color=color, label=f"bar on link {link}")
        looks.append(dict(color=color, marker="o", markeredgecolor="black", markersize=7, zorder=5))
    ax.set(xlim=ends, ylim=LIMITS, title=PANELS[panel], xlabel="added inertia, kg m²")
    ax.set_yticks(TICKS, [f"{tick:g}" for tick in TICKS])
    ax.minorticks_off()

    def places(data):
        factors, added = data
        yield ends, np.full(2, np.clip(factors[panel], *LIMITS) if any(added) else np.nan)
        for curve, bar in zip(curves, added):
            value = np.exp(np.interp(np.log(max(bar, 1e-9)), np.log(inertias), np.log(curve)))
            yield ([bar], [value]) if bar >= inertias[0] else ([], [])

    return follow(ax, looks, (np.ones(len(PANELS)), np.zeros(len(curves))), places)


@styled()
def bars(study, added=None, width=9.6, height=4.0):
    """The figure of a `BarStudy`, with bars of the inertias `added` marked; ``fig.update(added)``."""
    instance("study", study, BarStudy, "pl.bar_study(rig)")
    fig = new_figure(width, height)
    axes = fig.subplots(1, 3, sharey=True)
    (link, inertia, factor), (tilt_link, tilt_inertia, tilt_factor) = map(study.best, (1, 2))

    def compute(added):
        added = numbers("added", added, study.rig.n_links)
        return [(study.of(added), added)] * len(PANELS)

    def draw(data):
        moves = [draw_bars(ax, study, panel) for panel, ax in enumerate(axes)]
        axes[0].set_ylabel("times better than without")
        handles, labels = axes[0].get_legend_handles_labels()
        fig.legend(handles, labels, loc="outside lower center", ncols=len(labels))
        return moves

    def say(data, added):
        return (
            f"The {study.rig.name} pendulum with a bar on one link: the distance gains most, "
            f"{factor:.1f} times, from a bar of {inertia:.2g} kg m² on link {link}; the tilt that "
            f"can be caught gains most, {tilt_factor:.1f} times, from one of {tilt_inertia:.2g} "
            f"kg m² on link {tilt_link}.",
            f"Three panels with logarithmic axes over the added inertia from {study.inertias[0]:g} to "
            f"{study.inertias[-1]:g} kg m^2, one curve for each link: by which factor the "
            f"singular-value ratio, the distance to uncontrollability and the largest tilt that can be "
            f"caught improve. Above 1 is better than without a bar.",
        )

    return live(fig, draw, compute, say, np.zeros(study.rig.n_links) if added is None else added)


def in_words(study, added):
    """What bars of the inertias `added` (kg m^2, one for each link) do, as a sentence."""
    ratio, distance, tilt = study.of(added)
    bars = ", ".join(f"{bar:.3g} on link {i}" for i, bar in enumerate(added, 1) if bar > 0)
    degrees = np.degrees(study.bare.tilt)
    return (
        f"Bars: {bars or 'none'} (kg m²). Singular-value ratio {_times(ratio)}, distance to "
        f"uncontrollability {_times(distance)}; the largest tilt goes from {degrees:.1f} to {tilt * degrees:.1f} degrees."
    )


def _times(factor):
    if abs(factor - 1) < 0.005:
        return "unchanged"
    return f"{factor:.3g} times better" if factor > 1 else f"{1 / factor:.3g} times worse"
