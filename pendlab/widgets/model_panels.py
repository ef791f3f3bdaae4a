"""Widgets of the model: the horizontal bar, sampling time and filters."""

from dataclasses import replace

from ..figures.bar import bar_study, bars, in_words
from ..figures.pages import PAGE
from ..figures.sampling import sampling_page
from ..paper.designs import paper_design
from ..parameters import Filters, load
from .design_panels import LOOPS, page_panel
from .panel import Panel
from .parts import Slider, View


def bar_panel(name="double", study=None):
    """A horizontal bar on each link: what its inertia does to the measures of controllability.

    `study` is a `BarStudy` made before; by default that of the rig `name` is made.
    """
    rig = load(name)
    study = bar_study(rig) if study is None else study
    fig = bars(study, width=PAGE, height=3.6)
    names = [f"bar{i + 1}" for i in range(study.rig.n_links)]

    def update(**values):
        added = [values[name] for name in names]
        words = in_words(study, added)
        fig.update(added)
        return words

    return Panel(
        f"A horizontal bar on each link of the {study.rig.name}",
        [
            Slider(name, f"bar on link {i + 1}, kg m²", 1e-3, 1.0, 0.0, log=True, zero=True)
            for i, name in enumerate(names)
        ],
        View(fig, update, fig.moving),
        legend=(
            "Sliders: moment of inertia that a bar without mass adds to a link; the lowest notch is none.",
            "Curves: a bar on one link alone, as a factor on each measure; above 1 is better.",
            "Dots: where each of your bars would be alone. Dotted level: all your bars at once.",
        ),
        presets={
            "No bar": dict.fromkeys(names, 0.0),
            "Bar on top": {**dict.fromkeys(names, 0.0), names[-1]: 0.1},
            "Bar below": {**dict.fromkeys(names, 0.0), names[0]: 0.1},
        },
    )


def sampling_panel():
    """Sampling time and filters of the double, and the loop of the paper's weights designed anew."""
    design = paper_design("double")
    (input_hz, *_), (output_hz, *_) = design.rig.filters.input_hz, design.rig.filters.output_hz
    return page_panel(
        "Sampling time and filters of the double",
        sampling_page(design),
        lambda dt, **hz: sampled_design(design, dt / 1e3, **hz),
        [
            Slider("dt", "sampling time, ms", 1, 100, 1e3 * design.dt, log=True),
            Slider("input_hz", "input filter, Hz", 0.5, 200, input_hz, log=True),
            Slider("output_hz", "output filters, Hz", 0.5, 200, output_hz, log=True),
        ],
        legend=(
            "Sliders: sampling time, and cut-off frequencies of the first-order filters.",
            "Left: eigenvalues of the sampled plant with filters. Middle: phase lag of filters and hold.",
            f"Right: F and observer designed anew for each sampling time, without filters. {LOOPS}",
        ),
        presets={"Slow computer": dict(dt=40.0), "Heavy filters": dict(input_hz=2.0)},
    )


def sampled_design(design, dt, input_hz, output_hz):
    """`design` for another sampling time (s) and other filters (Hz).

    The observer keeps its speed, E = E(paper)^(dt / 10 ms), and of its family the member nearest to
    the printed one is taken.
    """
    filters = design.rig.filters
    filters = Filters((input_hz,) * len(filters.input_hz), (output_hz,) * len(filters.output_hz))
    E = tuple(e ** (dt / design.dt) for e in design.E)
    changed = design.changed(rig=replace(design.rig, filters=filters), dt=dt, E=E)
    coefficients = changed.family.project(design.observer.T, design.observer.K)
    return changed.changed(coefficients=tuple(coefficients))
