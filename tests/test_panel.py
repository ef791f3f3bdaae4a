"""The panel itself: controls linked both ways, pictures, sentences for what cannot work, memory."""

import gc
import io

import ipywidgets as widgets
import numpy as np
import pytest
from matplotlib.image import imread

import pendlab as pl
from pendlab.figures.picture import Picture, png_bytes
from pendlab.figures.style import freeze_layout, new_figure
from pendlab.widgets import panel as module


def view(moving=True):
    """A line whose slope is k, refused above 8."""
    fig = new_figure(3, 2)
    ax = fig.subplots()
    (line,) = ax.plot([0.1, 0.9], [1, 1])  # clear of the spines, which a full drawing puts on top
    ax.set(xlim=(0, 1), ylim=(0, 10))
    freeze_layout(fig)

    def update(k, steep=False, way="up"):
        if k > 8:
            raise ValueError(f"k: expected at most 8, found {k:g}.")
        line.set_ydata([1, k * (2 if steep else 1)])
        return f"slope {k:g}, {way}{', twice' if steep else ''}"

    return pl.View(fig, update, (line,) if moving else ())


def panel(shown=None, **more):
    controls = [
        pl.Slider("k", "slope k, 1/s", 0.01, 10, 1.0, log=True, zero=True),
        pl.Switch("steep", "twice as steep"),
        pl.Choice("way", "way", {"upward": "up", "downward": "down"}, "up"),
    ]
    return pl.Panel("A line", controls, shown or view(), presets={"Two": {"k": 2.0}}, **more)


@pytest.fixture
def made():
    p = panel()
    yield p
    p.close()


def pixels(png):
    return imread(io.BytesIO(png))[:, :, :3]


# Controls


def test_slider_moves_field_and_picture(made):
    before = made.picture
    made._sliders["k"].value = 0.5
    assert made.values["k"] == 3.16 and made.caption.startswith("slope 3.16")
    assert made.picture != before


def test_field_moves_slider(made):
    made._fields["k"].value = 5.0
    assert made._sliders["k"].value == pytest.approx(np.log10(5))
    assert made.caption == "slope 5, up"


def test_slider_that_settles_on_its_nearest_step_changes_nothing(made):
    made.at(k=3.0)
    made._sliders["k"].value = 0.5  # what the browser does: log10(3) is 0.477, its steps are 0.05
    assert made.values["k"] == 3.0 and made.caption == "slope 3, up"
    made._sliders["k"].value = 0.55
    assert made.values["k"] == 3.55


def test_late_word_from_the_browser_does_not_bring_an_earlier_value_back(made):
    """Run All: the code moves on before the browser has told where it put the slider."""
    made.at(k=3.0)  # between two steps; the browser will put the slider onto 3.16
    made.at(k=0.02)
    made._sliders["k"].value = 0.5
    assert made.values["k"] == 0.02
    assert made._sliders["k"].value == pytest.approx(np.log10(0.02))
    made._sliders["k"].value = 0.5  # the second time it is a hand
    assert made.values["k"] == 3.16


def test_lowest_notch_of_a_slider_with_zero_is_zero(made):
    made._sliders["k"].value = made._sliders["k"].min
    assert made.values["k"] == 0.0 and made.caption == "slope 0, up"
    made._fields["k"].value = 0.01
    assert made._sliders["k"].value == pytest.approx(-2)


@pytest.mark.parametrize("value", [0.01, 0.2, 1.0, 10.0])
def test_slider_position_and_value_are_inverse(value):
    slider = pl.Slider("k", "k", 0.01, 10, 1.0, log=True, zero=True)
    assert slider.value_at(slider.position_of(value)) == value
    assert slider.position_of(0.0) == slider.span[0] and slider.value_at(slider.span[0]) == 0.0


def test_switch_and_choice_move_the_picture(made):
    made._fields["steep"].value = True
    made._fields["way"].value = "down"
    assert made.caption == "slope 1, down, twice"


def test_at_moves_the_widgets_and_clips(made):
    assert made.at(k=2.0, steep=True) == "slope 2, up, twice"
    assert made._fields["k"].value == 2.0 and made._fields["steep"].value is True
    assert made._sliders["k"].value == pytest.approx(np.log10(2))
    made.at(k=-5)
    assert made.values["k"] == 0.0


def test_at_names_what_it_does_not_know(made):
    with pytest.raises(ValueError, match="no such control; it has k, steep, way"):
        made.at(slope=1)
    with pytest.raises(ValueError, match="expected one of up, down"):
        made.at(k=5.0, way="left")
    assert made.values["k"] == 1.0  # nothing moved


def test_ends_reach_every_control_and_come_back(made):
    made.at(k=2.0)
    captions = made.ends()
    assert len(captions) == 3 + 1 + 2
    assert "slope 0, up" in captions and "slope 2, up, twice" in captions
    assert made.values == {"k": 2.0, "steep": False, "way": "up"}


def test_presets_and_reset_by_their_buttons(made):
    made.at(k=5.0, steep=True)
    buttons = {b.description: b for b in descendants(made._widget) if isinstance(b, widgets.Button)}
    buttons["Two"].click()
    assert made.values["k"] == 2.0 and made.values["steep"] is True
    buttons["Reset"].click()
    assert made.values == {"k": 1.0, "steep": False, "way": "up"}


def test_start_outside_the_slider_is_refused():
    with pytest.raises(ValueError, match="k value: expected 1 to 2, found 3"):
        pl.Slider("k", "k", 1, 2, 3.0)


def test_tabs_hold_all_controls():
    p = pl.Panel(
        "Tabs", {"One": [pl.Slider("k", "k", 0, 5, 1.0)], "Two": [pl.Switch("steep", "s")]}, view()
    )
    assert p.at(k=3.0, steep=True) == "slope 3, up, twice"
    (tab,) = [w for w in descendants(p._widget) if isinstance(w, widgets.Tab)]
    assert tab.titles == ("One", "Two")
    p.close()


# Values that cannot work


def test_impossible_value_gives_a_sentence_and_recovers(made):
    good = made.picture
    words = made.at(k=9.0)
    assert words == (
        "These values cannot work. k: expected at most 8, found 9. "
        "The picture still shows the last ones."
    )
    assert made.picture == good and "B00020" in made._words.value
    assert made.at(k=1.0) == "slope 1, up" and "B00020" not in made._words.value
    assert made.picture == good


def test_caption_is_announced_and_escaped(made):
    made._say("a < b\nc")
    assert 'role="status"' in made._words.value and "a &lt; b<br>c" in made._words.value


def test_mistakes_in_code_are_not_hidden():
    def broken(k):
        raise TypeError("a mistake")

    with pytest.raises(TypeError, match="a mistake"):
        pl.Panel("Broken", [pl.Slider("k", "k", 0, 1, 0.5)], pl.View(new_figure(2, 2), broken))


# Actions


def test_action_shows_progress_and_adds_its_sentence():
    seen = []

    def count(values, progress):
        for k in range(3):
            progress(k + 1, 3)
            seen.append((p._progress.value, p._progress.max, p._progress.layout.display))
        return f"counted with k = {values['k']:g}"

    p = panel(actions={"Count": count})
    assert p.act("Count") == "slope 1, up\ncounted with k = 1"
    assert seen == [(k, 3, "flex") for k in (1, 2, 3)]
    assert p._progress.layout.display == "none"
    with pytest.raises(ValueError, match="expected one of Count"):
        p.act("count")
    p.close()


def test_action_that_fails_says_so():
    def fail(values, progress):
        raise ValueError("nothing to count.")

    p = panel(actions={"Count": fail})
    assert p.act("Count").endswith("Count: nothing to count.")
    assert p._progress.layout.display == "none"
    p.close()


# Pictures


def test_picture_on_a_kept_background_equals_a_full_drawing():
    kept, full = view(), view(moving=False)
    one, other = Picture(kept.figure, kept.moving), Picture(full.figure)
    one.png()
    for k in (0.5, 4.0):
        kept.update(k), full.update(k)
        assert np.array_equal(pixels(one.png()), pixels(other.png()))


def test_background_follows_the_frame():
    v = view()
    picture = Picture(v.figure, v.moving)
    first = picture.png()
    v.figure.axes[0].set_ylim(0, 5)
    second = picture.png()
    v.figure.axes[0].set_ylim(0, 10)
    assert first != second and picture.png() == first


def test_png_holds_the_pixels():
    colours = np.random.default_rng(0).integers(0, 256, (7, 5, 3), dtype=np.uint8)
    assert np.array_equal(np.round(pixels(png_bytes(colours)) * 255), colours)


# In the page


def test_bundle_has_live_widget_picture_and_words(made):
    bundle = made._repr_mimebundle_()
    assert bundle["application/vnd.jupyter.widget-view+json"]["model_id"]
    assert bundle["text/plain"] == repr(made) == "slope 1, up"
    assert isinstance(bundle["image/png"], bytes)
    assert pixels(bundle["image/png"]).shape == (200, 300, 3)


def test_running_a_cell_again_closes_the_earlier_panel(monkeypatch):
    monkeypatch.setattr(module, "running_cell", lambda: "cell 1")
    first, second = panel(), panel()
    first._repr_mimebundle_()
    first._repr_mimebundle_()  # showing it twice does not close it
    assert first._image.comm is not None
    second._repr_mimebundle_()
    assert first._image.comm is None and second._image.comm is not None
    second.close()


def test_panel_shown_elsewhere_stays_open(monkeypatch):
    first, second = panel(), panel()
    for cell, shown in (("a", first), ("b", first), ("b", second)):
        monkeypatch.setattr(module, "running_cell", lambda cell=cell: cell)
        shown._repr_mimebundle_()
    assert first._image.comm is not None
    first.close(), second.close()


@pytest.mark.parametrize("shown", [False, True])
def test_memory_does_not_grow_when_a_cell_runs_again(monkeypatch, shown):
    monkeypatch.setattr(module, "running_cell", lambda: "cell 2")
    counts, once = [], view()
    for _ in range(5):
        for _ in range(10):
            p = panel(once)
            if shown:
                p._repr_mimebundle_()
        del p
        gc.collect()
        counts.append(len(widgets.widget._instances))
    assert max(counts) == counts[0]


def test_two_panels_do_not_disturb_each_other():
    one, other = panel(), panel()
    before = other.picture, other.caption, other.values
    one.at(k=5.0, steep=True, way="down")
    one.at(k=9.0)
    assert (other.picture, other.caption, other.values) == before
    one.close()
    assert other.at(k=2.0) == "slope 2, up"
    other.close()


def descendants(widget):
    for child in getattr(widget, "children", ()):
        yield from descendants(child)
    yield widget
