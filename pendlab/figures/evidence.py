"""What the bench is needed for: extremes before and after, hits without a mechanism, what sets what."""

import numpy as np

from .._arguments import array, found, instances
from ..bench.arguments import mapping
from ..bench.simulation import Run
from ..paper.changes import hertz
from ..paper.experiment import FIGURES, extremes, tick_intervals
from ..studies.describing import Cycle
from .style import COLORS, describe, new_figure, styled

PERCENTILES = (5, 50, 95)
NEEDED = 2.5  # hits that a mechanism must be worth to be named
STRONG = 0.9  # exponent that the description names
EVENT = ("16b min", "16c max", "16d min")  # the signs of one event
SHARES = dict(cmap="Blues", vmin=0, vmax=1)  # how cells are coloured
LOOKS = (("grey", "s"), ("blue", "o"), ("vermillion", "D"))


@styled()
def before_after(ensembles):
    """Every extreme of Figs 15 to 17 in ticks from its axis limit, for several benches.

    Parameters
    ----------
    ensembles : name of a bench -> {"triple": runs, "double": runs}
    """
    shown = {}
    for label, benches in mapping("ensembles", ensembles, '{"bench": {"triple": runs}}').items():
        where = f"ensembles[{label!r}]"
        _all_of(where, benches, FIGURES)
        shown[label] = {
            name: instances(f"{where}[{name!r}]", benches[name], Run) for name in FIGURES
        }
    keys = [key for name in FIGURES for key in tick_intervals(name)]
    fig = new_figure(9, 6.4)
    ax = fig.subplots()
    ax.axvspan(0, 1, color=COLORS["green"], alpha=0.15, label="as printed", linewidth=0)
    counts = []
    for k, (label, runs) in enumerate(shown.items()):
        color, marker = LOOKS[k % len(LOOKS)]
        depths = np.array([row for name in FIGURES for row in _depths(name, runs[name])])
        low, middle, high = np.nanpercentile(depths, PERCENTILES, axis=1)
        y = np.arange(len(keys)) + 0.3 * (k - (len(shown) - 1) / 2)
        ax.errorbar(middle, y, xerr=(middle - low, high - middle), fmt=marker, markersize=5,
                    color=COLORS[color], label=label, elinewidth=2.2)  # fmt: skip
        met = int((((depths >= 0) & (depths <= 1)).mean(axis=1) >= 0.5).sum())
        counts.append(f"{label}: {met} of {len(keys)}")
    ax.axvline(0, color=COLORS["black"], linewidth=1)
    ax.set(xlabel="ticks inside the printed axis limit (below 0: outside the axes)",
           yticks=range(len(keys)), yticklabels=keys, ylim=(len(keys) - 0.5, -0.5), xlim=(-1.5, 4))  # fmt: skip
    ax.legend(loc="lower right")
    words = "; ".join(counts)
    return describe(
        fig,
        f"Extremes that lie within the printed tick in at least half of the runs: {words}.",
        "One row for each of the 22 extremes; a mark and a bar (median, 5 to 95 % of the runs) show "
        f"how far inside the axis limit it lies, in ticks; the shaded column is where it must be. {words}.",
    )


def _all_of(name, table, needed):
    """`table` if it is a dict that has the keys `needed`."""
    for key in needed:
        if key not in mapping(name, table, f"{{{key!r}: ...}}"):
            raise ValueError(f"{name}: expected all of {', '.join(needed)}, {found(table)}.")
    return table


def _read(table):
    """Rows, columns and values of a dict of dicts of numbers with the same keys in all."""
    cells = list(mapping("table", table, '{"gap 1": {"15a min": 0.5}}').values())
    for row, one in table.items():
        if mapping(f"table[{row!r}]", one, '{"15a min": 0.5}').keys() != cells[0].keys():
            columns = ", ".join(map(str, cells[0]))
            raise ValueError(f"table[{row!r}]: expected numbers for {columns}, {found(one)}.")
    values = [[one[column] for column in cells[0]] for one in cells]
    return list(table), list(cells[0]), array("table", values, (None, None), finite=False)


def _depths(name, runs):
    """For each extreme the runs' distances inside the axis limit, in ticks."""
    values = [extremes(name, run) for run in runs]
    for key, (low, high) in tick_intervals(name).items():
        edge, inward = (low, 1) if key.endswith("min") else (high, -1)
        yield [inward * (value[key] - edge) / (high - low) for value in values]


@styled()
def ablation(table):
    """Hits out of 22 with one mechanism taken away each: ``changes.hits_without()``."""
    rows, keys, shares = _read(_all_of("table", table, ["the bench"]))
    bench, totals = rows.index("the bench"), shares.sum(axis=1)
    lost = totals - totals[bench]
    needed = [row for row, change in zip(rows, lost) if change < -NEEDED]
    order = [bench, *(k for k in np.argsort(lost, kind="stable") if k != bench)]
    fig = new_figure(9, 4.2)
    bars, cells = fig.subplots(1, 2, width_ratios=(2, 3), sharey=True)
    colors = [COLORS["blue"]] + [COLORS["sky"]] * (len(rows) - 1)
    bars.barh(range(len(rows)), totals[order], color=colors)
    bars.text(0.3, 0, f"{totals[bench]:.1f}", va="center", color="white")
    for y, k in enumerate(order[1:], 1):
        bars.text(0.3, y, f"{lost[k]:+.1f}", va="center")
    names = ["the bench", *(f"without {rows[k]}" for k in order[1:])]
    bars.set(yticks=range(len(rows)), yticklabels=names, xlabel="hits of 22", xlim=(0, 22))
    bars.invert_yaxis()
    cells.imshow(shares[order], **SHARES, aspect="auto")
    cells.set_xticks(range(len(keys)), keys, rotation=90, fontsize=8)
    cells.grid(False)
    cells.set_title("share of runs per extreme: white none, dark all", loc="left", fontsize=10)
    return describe(
        fig,
        f"Each of these costs more than {NEEDED} hits when it is taken away: {', '.join(needed)}.",
        "Bars: hits of 22 for the bench and for the bench without each mechanism. Beside them one "
        "cell for each extreme, dark where all runs lie in the printed tick.",
    )


def _draw_cells(ax, rows, columns, values, words, dark, size=11, **colours):
    """A table of coloured cells with the values in `words`, in white beyond `dark`."""
    ax.imshow(values, **colours, aspect="auto")
    for (i, j), value in np.ndenumerate(values):
        color = "white" if abs(value) > dark else "black"
        ax.text(j, i, words(value), ha="center", va="center", color=color, fontsize=size)
    ax.set_xticks(range(len(columns)), columns)
    ax.set_yticks(range(len(rows)), rows)
    ax.xaxis.tick_top()
    ax.grid(False)


@styled()
def what_sets_what(table):
    """Exponents of ``changes.exponents(name)`` as a table of coloured cells."""
    parts, quantities, values = _read(table)
    fig = new_figure(8.5, 0.9 + 0.42 * len(parts))

    def words(value):
        return f"{value:+.1f}" if abs(value) >= 0.05 else "0"

    colours = dict(cmap="RdBu_r", vmin=-1, vmax=1)
    _draw_cells(fig.subplots(), parts, quantities, values, words, 0.65, **colours)
    strong = "; ".join(
        f"{quantities[j]} with {parts[i]}" for i, j in np.argwhere(np.abs(values) > STRONG)
    )
    return describe(
        fig,
        "The power with which each quantity follows each part: 1 in proportion, 0 not at all.",
        f"A table of exponents, red for growing and blue for falling. Nearly in proportion: {strong or 'none'}.",
    )


@styled()
def pushed(table):
    """Which extremes of Fig 16 an ensemble meets under each push: rows of `tick_hits`."""
    rows, columns, shares = _read(table)
    _all_of("table[...]", table[rows[0]], EVENT)
    of_16 = [k for k, key in enumerate(columns) if str(key).startswith("16")]
    keys, shares = [columns[k] for k in of_16], shares[:, of_16]
    fig = new_figure(8.5, 1.2 + 0.34 * len(rows))
    _draw_cells(fig.subplots(), rows, keys, shares, "{:.0%}".format, 0.6, size=9, **SHARES)
    event = [keys.index(key) for key in EVENT]
    at_once = int((shares[:, event].min(axis=1) >= 0.5).sum())
    return describe(
        fig,
        f"Of {len(rows)} pushes, {at_once} meet {', '.join(EVENT)} together.",
        "Rows: pushes. Columns: the extremes of Fig 16, dark where most runs lie in the printed tick.",
    )


@styled()
def cycles_figure(predicted, seen):
    """Predicted limit cycles beside those of ensembles: size over frequency, one colour a mechanism.

    Parameters
    ----------
    predicted : mechanism -> list of `studies.describing.Cycle`
    seen : mechanism -> runs of the triple
    """
    _all_of("seen", seen, mapping("predicted", predicted, '{"play": pl.limit_cycles(...)}'))
    fig = new_figure(9, 3.8)
    axes = fig.subplots(1, 2, sharex=True)
    for name, color, marker in zip(predicted, ("blue", "vermillion", "green"), "s^o"):
        cycles = instances(f"predicted[{name!r}]", predicted[name], Cycle)
        up = [run for run in instances(f"seen[{name!r}]", seen[name], Run) if not run.fell]
        frequencies = [hertz(run) for run in up]
        # of a first harmonic of equal power
        sizes = np.sqrt(2) * np.array([run.angles[run.t >= 10.0].std(axis=0) for run in up])
        for ax, joint in zip(axes, (0, 1)):
            told = [max(c.joints[joint], 3e-4) for c in cycles]
            ax.loglog([c.hertz for c in cycles], told, marker, markersize=12, markeredgewidth=2,
                      fillstyle="none", color=COLORS[color], label=name)  # fmt: skip
            ax.loglog(frequencies, np.maximum(sizes[:, 1 + joint], 3e-4), marker, markersize=6,
                      alpha=0.6, color=COLORS[color])  # fmt: skip
    for ax, title in zip(axes, ("θ2−θ1", "θ3−θ2")):
        ax.set(xlabel="frequency, Hz", ylabel=f"amplitude of {title}, rad", ylim=(2e-4, 2))
        ax.set_xticks((0.2, 0.5, 1, 2, 5), ("0.2", "0.5", "1", "2", "5"))
        ax.minorticks_off()
    axes[0].legend(loc="lower right")
    return describe(
        fig,
        "Hollow: predicted by harmonic balance. Filled: the runs of an ensemble.",
        "Amplitude over frequency on logarithmic axes for play alone, friction alone and both; "
        "predicted points hollow, simulated ones filled.",
    )
