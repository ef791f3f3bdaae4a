"""Figure of the bar: factors, what the slider moves, and words."""

import numpy as np
import pytest

import pendlab as pl
from pendlab.figures.bar import PANELS, bar_study, bars, in_words


@pytest.fixture(scope="module")
def study():
    return bar_study(pl.load("double"), [1e-3, 0.03, 0.3])


def test_factors_compare_with_the_bare_rig(study):
    barred = pl.controllability_measures(pl.with_bar(study.rig, 2, 0.03))
    assert study.factors.shape == (2, len(PANELS), 3)
    ratio, distance, tilt = study.factors[1, :, 1]
    assert ratio == pytest.approx(study.bare.ratio / barred.ratio)
    assert distance == pytest.approx(barred.distance / study.bare.distance)
    assert tilt == pytest.approx(barred.tilt / study.bare.tilt)


def test_no_bars_change_nothing(study):
    assert study.of([0.0, 0.0]) == pytest.approx(np.ones(3))
    assert "none" in in_words(study, [0.0, 0.0]) and "unchanged" in in_words(study, [0.0, 0.0])


def test_one_bar_marks_its_own_curve_and_level(study):
    fig = bars(study)
    fig.update([0.0, 0.03])
    moved = fig.moving
    for panel in range(len(PANELS)):
        level, low, up = moved[3 * panel : 3 * panel + 3]
        assert len(low.get_xdata()) == 0
        assert up.get_xydata()[0] == pytest.approx([0.03, study.factors[1, panel, 1]])
        assert level.get_ydata()[0] == pytest.approx(study.factors[1, panel, 1])


def test_update_only_changes_data(study):
    fig = bars(study)
    before = [len(ax.get_children()) for ax in fig.axes]
    fig.update([0.1, 0.2])
    assert [len(ax.get_children()) for ax in fig.axes] == before


def test_caption_names_the_upper_link(study):
    fig = bars(study)
    assert "link 2; the tilt" in fig.caption and study.best(1)[0] == 2
    assert np.all(np.isnan(fig.axes[0].lines[3].get_ydata()))  # no level where there are no bars
    assert fig.alt


def test_wrong_number_of_bars_is_named(study):
    with pytest.raises(ValueError, match="added: expected 2 numbers"):
        study.of([0.1])
    with pytest.raises(TypeError, match="rig"):
        bar_study("double")
