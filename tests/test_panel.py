"""The panel itself: controls linked both ways, pictures, sentences for what cannot work, memory."""

import asyncio
import gc
import io
from concurrent.futures import ThreadPoolExecutor
from threading import Event

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


def hand(panel, name=None, **did):
    """What the browser sends when a hand moves, types, chooses or presses."""
    count = panel._widget.hand.get("count", 0) + 1
    panel._widget.hand = {**({"name": name} if name else {}), **did, "count": count}
    return panel.caption


def shown(panel, name):
    """Position, text and spoken words of a slider in the page."""
    return panel._widget.state["values"][name]


def test_slider_moves_field_and_picture(made):
    before = made.picture
    hand(made, "k", position=51)
    assert made.values["k"] == 3.16 and made.caption.startswith("slope 3.16")
    assert shown(made, "k") == [51, "3.16", "3.16 1/s"]
    assert made.picture != before


def test_field_moves_slider(made):
    assert hand(made, "k", text="5,0") == "slope 5, up"
    assert shown(made, "k") == [55, "5", "5 1/s"]


def test_value_between_two_positions_stays(made):
    """The browser knows positions only; a value that it did not move is the kernel's own."""
    made.at(k=3.0)
    hand(made, "steep", position=1)
    assert made.values["k"] == 3.0 and shown(made, "k")[:2] == [51, "3"]


def test_page_learns_which_move_was_answered(made):
    hand(made, "k", position=10)
    hand(made, "k", position=12)
    assert made._widget.state["count"] == made._widget.hand["count"] == 2


def test_lowest_position_of_a_slider_with_zero_is_zero(made):
    assert hand(made, "k", position=0) == "slope 0, up" and made.values["k"] == 0.0
    hand(made, "k", text="0.01")
    assert shown(made, "k")[0] == 1


@pytest.mark.parametrize("zero", [False, True])
@pytest.mark.parametrize("log", [False, True])
def test_slider_position_and_value_are_inverse(log, zero):
    slider = pl.Slider("k", "k", 0.01, 10, 1.0, log=log, zero=zero and log)
    for position in range(slider.last + 1):
        assert slider.position_of(slider.value_at(position)) == position
    assert slider.value_at(slider.last) == 10 == slider.value_at(slider.last + 5)
    assert slider.value_at(0) == (0.0 if zero and log else 0.01)


def test_ticks_are_decades_and_zero():
    slider = pl.Slider("k", "k, V", 0.1, 100, 10, log=True, zero=True)
    assert slider.ticks == [(0, "0"), (1, ""), (21, ""), (41, ""), (61, "")]
    assert pl.Slider("k", "k", -2, 2, 0, step=0.1).ticks == [(0, ""), (20, ""), (40, "")]


@pytest.mark.parametrize(
    "text, words",
    [
        ("20", "k: expected 0.01 to 10 or 0, found 20. It stays as it was."),
        ("-1", "k: expected 0.01 to 10 or 0, found -1. It stays as it was."),
        ("fast", "k: expected a number, found 'fast'. It stays as it was."),
        ("", "k: expected a number, found ''. It stays as it was."),
        ("nan", "k: expected a finite number, found nan. It stays as it was."),
    ],
)
def test_typed_value_that_cannot_be_is_answered(made, text, words):
    before = made.picture
    hand(made, "k", text=text)
    state = made._widget.state
    assert state["words"][-1] == words and state["sound"] is False
    assert made.values["k"] == 1.0 and shown(made, "k")[1] == "1" and made.picture == before
    hand(made, "k", text="2")
    assert made._widget.state["sound"] and words not in made._widget.state["words"]


def test_switch_and_choice_move_the_picture(made):
    hand(made, "steep", position=1)
    hand(made, "way", position=1)
    assert made.caption == "slope 1, down, twice"


def test_at_moves_the_page(made):
    assert made.at(k=2.0, steep=True) == "slope 2, up, twice"
    assert shown(made, "k")[1] == "2" and shown(made, "steep") == [1]


def test_at_names_what_it_does_not_know(made):
    with pytest.raises(ValueError, match="no such control; it has k, steep, way"):
        made.at(slope=1)
    with pytest.raises(ValueError, match="way: expected one of 'up', 'down'"):
        made.at(k=5.0, way="left")
    with pytest.raises(ValueError, match=r"k: expected 0\.01 to 10 or 0, found -5"):
        made.at(k=-5)
    with pytest.raises(TypeError, match="steep: expected True or False"):
        made.at(steep="yes")
    assert made.values["k"] == 1.0  # nothing moved


def test_tell_leaves_values_and_picture_where_they_are(made):
    caption, picture = made.caption, pixels(made.picture)
    assert made.tell(k=2.0, steep=True) == "slope 2, up, twice"
    assert made.values["k"] == 1.0 and made.caption == caption
    assert np.array_equal(pixels(made.picture), picture)
    with pytest.raises(ValueError, match="no such control"):
        made.tell(slope=1)


def test_presets_and_reset_by_their_buttons(made):
    made.at(k=5.0, steep=True)
    assert made._widget.face["buttons"] == ["Two", "Reset"]
    hand(made, button="Two")
    assert made.values["k"] == 2.0 and made.values["steep"] is True
    hand(made, button="Reset")
    assert made.values == {"k": 1.0, "steep": False, "way": "up"}


def test_start_outside_the_slider_is_refused():
    with pytest.raises(ValueError, match="k value: expected 1 to 2, found 3"):
        pl.Slider("k", "k", 1, 2, 3.0)


def test_two_or_three_controls_are_in_sight_and_the_rest_is_folded():
    sliders = [pl.Slider(f"k{i}", "k", 0, 5, 1.0) for i in range(6)]
    fig = new_figure(2, 2)
    parts = {"One": sliders[:3], "Two": sliders[3:]}
    p = pl.Panel("Folds", parts, pl.View(fig, lambda **_: "c"), first=("k4", "k0"))
    groups = [
        (group["heading"], [c["name"] for c in group["controls"]])
        for group in p._widget.face["groups"]
    ]
    assert groups == [("", ["k4", "k0"]), ("One", ["k1", "k2"]), ("Two", ["k3", "k5"])]
    assert p.at(k5=3.0) == "c" and p.values["k5"] == 3.0
    p.close()
    with pytest.raises(ValueError, match="first: expected names of controls, found 'k9'"):
        pl.Panel("Folds", sliders, pl.View(fig, lambda **_: "c"), first=("k9",))


def test_wrong_parts_are_named():
    shown = pl.View(new_figure(2, 2), lambda **_: "c")
    with pytest.raises(TypeError, match=r"controls: expected pl.Slider"):
        pl.Panel("Wrong", ["k"], shown)
    with pytest.raises(ValueError, match="names that differ, found 'k' twice"):
        pl.Panel("Twice", [pl.Switch("k", "k"), pl.Switch("k", "k")], shown)


def test_control_that_moves_nothing_says_why():
    fig = new_figure(2, 2)
    controls = [pl.Switch("on", "noise"), pl.Slider("noise", "noise, V", 0, 1, 0.5)]
    idle = lambda values: {} if values["on"] else {"noise": "needs the switch"}  # noqa: E731
    p = pl.Panel("Idle", controls, pl.View(fig, lambda **_: "c", idle=idle))
    assert p._widget.state["idle"] == {"noise": "needs the switch"}
    hand(p, "on", position=1)
    assert p._widget.state["idle"] == {}
    p.close()


def test_what_a_figure_tells_apart_is_shown_apart():
    fig = new_figure(2, 2)
    fig.alt, fig.verdict, fig.table, fig.lead = "d", ("falls", False), [["a"], ["1"]], "First."
    p = pl.Panel("Apart", [pl.Switch("k", "k")], pl.View(fig, lambda k: "First.\nSecond."))
    state = p._widget.state
    assert (state["verdict"], state["table"], state["words"]) == (
        ("falls", False),
        [["a"], ["1"]],
        ["First."],
    )
    assert state["alt"] == "d" and p.caption == "First.\nSecond."
    p.close()


def test_dense_screen_gets_as_many_dots(made):
    assert pixels(made.picture).shape == (200, 300, 3)
    hand(made, ratio=2)
    assert pixels(made.picture).shape == (400, 600, 3)
    hand(made, "k", position=3, ratio=1)
    assert pixels(made.picture).shape == (200, 300, 3)


# Values that cannot work


def test_a_move_while_the_picture_is_stored(made):
    """JupyterLab has moves handled in a second thread."""
    alone, done = panel(), Event()

    def store():
        while not done.is_set():
            made.still()

    with ThreadPoolExecutor(1) as second:
        storing = second.submit(store)
        try:
            drawn = [
                [(hand(p, "k", position=k), p.picture) for k in range(20)] for p in (made, alone)
            ]
        finally:
            done.set()
        storing.result()
    assert drawn[0] == drawn[1]
    alone.close()


def test_impossible_value_gives_a_sentence_and_recovers(made):
    good = made.picture
    words = made.at(k=9.0)
    assert words == (
        "These values cannot work. k: expected at most 8, found 9. "
        "The picture still shows the last ones."
    )
    assert made.picture == good and made._widget.state["sound"] is False
    assert made._widget.state["verdict"] == ("cannot work", False)
    assert made.at(k=1.0) == "slope 1, up" and made._widget.state["sound"]
    assert made.picture == good


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
            seen.append(p._widget.state["progress"])
        return f"counted with k = {values['k']:g}"

    p = panel(actions={"Count": count})
    assert p.act("Count") == "slope 1, up\ncounted with k = 1"
    assert seen == [[k, 3] for k in (1, 2, 3)]
    assert p._widget.state["progress"] is None
    with pytest.raises(ValueError, match="expected one of Count"):
        p.act("count")
    p.close()


def test_action_that_fails_says_so():
    def fail(values, progress):
        raise ValueError("nothing to count.")

    p = panel(actions={"Count": fail})
    assert p.act("Count").endswith("Count: nothing to count.")
    assert p._widget.state["progress"] is None
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


@pytest.fixture
def page(monkeypatch):
    """What a cell displays: a list of (bundle, handle that counts its updates)."""
    import IPython.display

    outputs = []

    class Handle:
        def __init__(self):
            self.updates = []

        def update(self, bundle, raw):
            self.updates.append(bundle)

    def keep(bundle, raw=False, display_id=None):
        outputs.append((bundle, Handle()))
        return outputs[-1][1] if display_id else None

    monkeypatch.setattr(IPython.display, "display", keep)
    return outputs


def test_page_has_the_live_panel_and_the_picture_that_stays(made, page):
    made._ipython_display_()
    (live, _), (still, _) = page
    assert live["application/vnd.jupyter.widget-view+json"]["model_id"] == made._widget.model_id
    assert live["text/plain"] == "A line" and "image/png" not in live
    assert still["text/plain"] == repr(made) == "slope 1, up"
    mark = made._widget.face["still"]
    assert (
        f'<div class="{mark}">' in still["text/html"] and 'alt="slope 1, up"' in still["text/html"]
    )
    assert np.abs(pixels(still["image/png"]) - pixels(made.picture)).max() < 0.2


def test_stored_picture_follows_a_hand_that_rests(made, page, monkeypatch):
    monkeypatch.setattr(module, "REST", 0.01)

    async def move():
        made._ipython_display_()
        made.at(k=2.0)  # code does not change what is stored: it runs again with the notebook
        for position in (40, 41, 42):
            hand(made, "k", position=position)
        await asyncio.sleep(0.1)

    asyncio.run(move())
    (_, handle) = page[1]
    assert [bundle["text/plain"] for bundle in handle.updates] == [made.caption]
    assert made.caption != "slope 2, up"


def test_words_in_the_stored_page_are_escaped(page):
    fig = new_figure(2, 2)
    p = pl.Panel("a < b", [pl.Switch("k", "k")], pl.View(fig, lambda k: "a < b\nc"))
    assert "<p>a &lt; b<br>c</p>" in p.still()["text/html"]
    assert "<b>a &lt; b</b>" in p.still()["text/html"]
    p.close()


def test_running_a_cell_again_closes_the_earlier_panel(monkeypatch):
    monkeypatch.setattr(module, "running_cell", lambda: "cell 1")
    first, second = panel(), panel()
    first._ipython_display_()
    first._ipython_display_()  # showing it twice does not close it
    assert first._widget.comm is not None
    second._ipython_display_()
    assert first._widget.comm is None and second._widget.comm is not None
    second.close()


def test_panel_shown_elsewhere_stays_open(monkeypatch):
    first, second = panel(), panel()
    for cell, shown in (("a", first), ("b", first), ("b", second)):
        monkeypatch.setattr(module, "running_cell", lambda cell=cell: cell)
        shown._ipython_display_()
    assert first._widget.comm is not None
    first.close(), second.close()


@pytest.mark.parametrize("shown", [False, True])
def test_memory_does_not_grow_when_a_cell_runs_again(monkeypatch, shown):
    monkeypatch.setattr(module, "running_cell", lambda: "cell 2")
    counts, once = [], view()
    for _ in range(5):
        for _ in range(10):
            p = panel(once)
            if shown:
                p._ipython_display_()
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
