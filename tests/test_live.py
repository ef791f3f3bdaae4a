"""The live rig: its script is the simulator, and its page answers to hands and keys."""

import html
import math
import os
import re
import shutil

import numpy as np
import pytest

import pendlab as pl
from pendlab.__main__ import main
from pendlab.bench.generated import kernel_text
from pendlab.widgets.javascript import to_javascript

RIGS = ["double", "triple"]
CHROMIUM = next(
    filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None
)
in_browser = pytest.mark.skipif(
    CHROMIUM is None and os.environ.get("CI") != "true", reason="no Chromium or Chrome on PATH"
)


# ---- Python to JavaScript ------------------------------------------------------------------------


@pytest.mark.parametrize(
    "python, script",
    [
        ("x[i - 1] if i > 0 else x[i]", "((i > 0) ? x[(i - 1)] : x[i])"),
        ("not abs(x) < 1.5 or y != 2", "(!((Math.abs(x) < 1.5)) || (y !== 2))"),
        ("-a ** 2 % 3", "(-((a ** 2)) % 3)"),
        ("x[N:]", "x.subarray(N)"),
        ("int(len(plant.pulses))", "Math.trunc(plant.pulses.length)"),
    ],
)
def test_expressions(python, script):
    assert to_javascript(f"def f():\n    return {python}").splitlines()[1] == f"  return {script};"


@pytest.mark.parametrize(
    "python", ["x = [i for i in y]", "while True:\n    pass", "a < b < c", "x = 'text'", "f(*a)"]
)
def test_what_has_no_counterpart_is_named(python):
    with pytest.raises(ValueError, match=r"source: line 1 has .* no counterpart"):
        to_javascript(python)


def test_every_function_of_the_kernel_is_there():
    script = to_javascript(kernel_text(3, 2), skip=("constants",))
    for name in ("accelerate", "derivative", "drag", "advance", "read", "send", "hold", "run"):
        assert f"function {name}(" in script
    assert "function constants" not in script


# ---- the page ------------------------------------------------------------------------------------


def test_a_page_needs_nothing_from_elsewhere():
    page = str(pl.live_rig("double")).replace("http://www.w3.org/2000/svg", "")
    assert "http:" not in page and "https:" not in page and "import " not in page
    assert not any(mark in page for mark in ("TITLE", "KERNEL", "SCRIPT", "PAYLOAD"))


def test_a_notebook_shows_the_page_in_a_frame():
    live = pl.live_rig("triple")
    shown = live._repr_html_()
    assert "<iframe class=" in shown and "title=" in shown and shown.count('srcdoc="') == 1
    assert html.unescape(re.search('srcdoc="([^"]*)"', shown)[1]) == str(live)
    assert "0x" not in repr(live)


def test_without_its_frame_a_picture_is_left():
    """An untrusted notebook loses frame and style; what is left has words and a picture."""
    left = re.sub(
        "<style>.*</style>|<iframe.*</iframe>", "", pl.live_rig("double")._repr_html_(), flags=re.S
    )
    assert 'alt="The double pendulum held nearly upright' in left and "trusted" in left
    assert "style" not in left and "srcdoc" not in left


def test_a_design_of_ones_own(double_design):
    softer = double_design.changed(R=(10 * double_design.R[0],))
    assert str(pl.live_rig(softer)) != str(pl.live_rig("double"))


@pytest.mark.parametrize("wrong", [None, 3, "quadruple", pl.load])
def test_no_design(wrong):
    with pytest.raises((TypeError, ValueError), match="expected"):
        pl.live_rig(wrong)


def test_command_writes_a_page_for_each_rig(tmp_path, capsys):
    assert main(["live", "--folder", str(tmp_path / "pages")]) == 0
    assert sorted(path.name for path in (tmp_path / "pages").iterdir()) == [
        "double.html",
        "triple.html",
    ]


# ---- in the browser ------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def browser():
    from playwright.sync_api import sync_playwright

    with sync_playwright() as play:
        chromium = play.chromium.launch(
            executable_path=CHROMIUM,
            args=["--no-sandbox", "--disable-gpu", "--disable-background-networking",
                  "--disable-dev-shm-usage"],
        )  # fmt: skip
        yield chromium
        chromium.close()


@pytest.fixture
def page(browser, request, tmp_path):
    """The rig's page from a file, without network; errors of its script fail the test."""
    name = getattr(request, "param", "triple")
    file = tmp_path / f"{name}.html"
    file.write_text(str(pl.live_rig(name)), encoding="utf-8")
    context = browser.new_context(viewport={"width": 1366, "height": 768}, offline=True)
    page = context.new_page()
    problems = []
    page.on("pageerror", lambda error: problems.append(str(error)))
    page.goto(file.as_uri())
    page.wait_for_function("frames > 3")
    yield page
    context.close()
    assert problems == []


def rows(run):
    return np.hstack([run.angles, run.rates, run.u])


def script_rows(page, seconds, options):
    script = (
        f"() => simulate(rig.start, {seconds}, {options}, {options} === IDEAL ? 0.001 : rig.inner)"
    )
    answer = page.evaluate(script)
    assert answer["fell"] == -1
    return np.array(answer["rows"])


@pytest.mark.browser
@in_browser
@pytest.mark.parametrize("page", RIGS, indirect=True)
def test_the_script_is_the_simulator(page):
    """1e-9 over ten seconds of the ideal rig and the first second of the bench."""
    name = page.url.rpartition("/")[2].removesuffix(".html")
    design = pl.paper_design(name)
    bench = pl.bench_imperfections(design.rig)
    start = pl.bench_start(design.rig)
    ideal = pl.simulate(
        pl.bench_rig(design.rig), design.controller, 10, initial=start, inner_step=1e-3
    )
    on_bench = pl.simulate(
        pl.bench_rig(design.rig), design.controller, 1, initial=start, imperfections=bench
    )
    assert np.abs(script_rows(page, 10, "IDEAL") - rows(ideal)).max() < 1e-9
    assert np.abs(script_rows(page, 1, "BENCH") - rows(on_bench)).max() < 1e-9


@pytest.mark.browser
@in_browser
def test_on_the_bench_its_runs_spread_as_the_simulators(page):
    """Where chaos has parted single runs, amplitudes of twelve starts agree in the mean."""
    design = pl.paper_design("triple")
    bench, start = pl.bench_imperfections(design.rig), np.array(pl.bench_start(design.rig))
    ours, theirs = [], []
    for k in range(12):
        initial = (start + 1e-4 * k * np.array([1, -1, 0.5])).tolist()
        run = pl.simulate(
            pl.bench_rig(design.rig), design.controller, 8, initial=initial, imperfections=bench
        )
        script = page.evaluate(f"() => simulate({initial}, 8, BENCH, rig.inner).rows")
        ours.append(run.angles[300:].std(axis=0))
        theirs.append(np.array(script)[300:, :3].std(axis=0))
    assert np.allclose(np.mean(ours, axis=0), np.mean(theirs, axis=0), rtol=0.15)


@pytest.mark.browser
@in_browser
@pytest.mark.parametrize("page", RIGS, indirect=True)
def test_it_balances_is_pushed_and_falls_when_pushed_too_hard(page):
    assert page.inner_text("#badge") == "balances"
    page.click("#pause")
    page.focus("#rig")
    page.keyboard.press("ArrowRight")
    page.evaluate("() => { for (let k = 0; k < 300 && one.fell < 0; k++) advanceOne(); }")
    assert page.evaluate("one.fell") == -1
    page.evaluate("options.push = 1.0")
    page.keyboard.press("ArrowRight")
    page.evaluate("() => { for (let k = 0; k < 300 && one.fell < 0; k++) advanceOne(); }")
    assert page.inner_text("#badge").startswith("falls at")
    assert "passed the horizontal" in page.inner_text("#words")
    page.click("#hold")
    assert page.inner_text("#badge") == "held by hand"
    page.click("#go")
    page.wait_for_function("one.k > 20")
    assert page.inner_text("#badge") == "balances"


@pytest.mark.browser
@in_browser
def test_a_push_is_the_simulators_pulse(page):
    design = pl.paper_design("triple")
    start = pl.bench_start(design.rig)
    pulse = pl.Pulse(2, 0.2, 0.1, -0.2)
    run = pl.simulate(
        pl.bench_rig(design.rig),
        design.controller,
        1,
        initial=start,
        disturbance=pulse,
        inner_step=1e-3,
    )
    script = page.evaluate(
        """() => {
          pause(true); options = { ...IDEAL, push: 0.2 }; chosen = 1;
          one = heldStill(rig.start, options, 0.001); mode = "held"; change("runs");
          const angles = [];
          for (let k = 0; k <= 100; k++) {
            if (k === 20) shove(-1);
            advanceOne();
            angles.push(Array.from(one.rows.X[0]).slice(0, N));
          }
          return angles;
        }"""
    )
    assert np.abs(np.array(script) - run.angles).max() < 1e-9


@pytest.mark.browser
@in_browser
def test_a_link_is_dragged_by_the_pointer(page):
    lean = "Math.abs(one.state.x[2])"
    x, y = page.evaluate(
        "() => { const at = new DOMPoint(place[6], place[7]).matrixTransform(picture.getScreenCTM());"
        " return [at.x, at.y]; }"
    )
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 60, y, steps=4)
    assert page.evaluate("grip.link") == 2
    page.wait_for_function(f"{lean} > 0.05")
    page.mouse.up()
    assert page.evaluate("grip") is None


@pytest.mark.browser
@in_browser
def test_one_sample_pause_and_sliders_that_speak(page):
    page.click("#pause")
    before = page.evaluate("one.k")
    page.click("#one")
    assert page.evaluate("one.k") == before + 1
    gain = page.locator("#knob-kp")
    assert gain.get_attribute("aria-valuetext") == "10 V/rad"
    gain.focus()
    page.keyboard.press("ArrowRight")
    assert gain.get_attribute("aria-valuetext") == "14 V/rad"
    wanted = pl.paper_design("triple").changed(kp=14.0).controller.F
    assert np.array_equal(page.evaluate("one.law.F"), wanted)
    page.evaluate("() => { for (const id of ['gap', 'friction']) { const knob = $(`knob-${id}`);"
                  " knob.value = 0; knob.dispatchEvent(new Event('input')); } }")  # fmt: skip
    assert page.evaluate("one.plant.gear.every(row => row[HALF_GAP] === 0 && row[DRY] === 0)")
    assert page.inner_text("#knobs label:has(#knob-gap) output") == "none"


@pytest.mark.browser
@in_browser
@pytest.mark.parametrize("color", ["light", "dark"])
def test_in_a_notebooks_frame_verdict_picture_and_words_are_seen_at_once(browser, tmp_path, color):
    file = tmp_path / "notebook.html"
    file.write_text(pl.live_rig("triple")._repr_html_(), encoding="utf-8")
    page = browser.new_page(viewport={"width": 1040, "height": 680}, color_scheme=color)
    page.goto(file.as_uri())
    assert not page.is_visible(".pendlab-still")
    frame = page.frames[1]
    frame.wait_for_function("frames > 3")
    frame.evaluate(
        "options.push = 1, shove(1); for (let k = 0; k < 300 && one.fell < 0; k++) advanceOne()"
    )
    assert frame.inner_text("#badge").startswith("falls")
    assert frame.evaluate("document.documentElement.scrollHeight <= innerHeight")
    boxes = frame.evaluate(
        "bars.map(bar => [bar.frame.y.baseVal.value, bar.frame.x.baseVal.value])"
    )
    assert abs(boxes[0][0] - boxes[1][0]) >= 16 and all(-190 < x < 40 for _, x in boxes)
    page.close()


@pytest.mark.browser
@in_browser
@pytest.mark.parametrize("color", ["light", "dark"])
def test_axe_finds_nothing_on_the_page(page, color):
    from axe_playwright_python.sync_playwright import Axe

    page.emulate_media(color_scheme=color)
    page.click("summary")
    found = Axe().run(page).response
    assert len(found["passes"]) > 25 and found["violations"] == []


@pytest.mark.browser
@in_browser
def test_reduced_motion_starts_paused(browser, tmp_path):
    file = tmp_path / "double.html"
    file.write_text(str(pl.live_rig("double")), encoding="utf-8")
    page = browser.new_page(reduced_motion="reduce")
    page.goto(file.as_uri())
    page.wait_for_function("frames > 3")
    assert page.inner_text("#badge") == "held by hand" and page.evaluate("one.k") == 0
    page.close()


@pytest.mark.browser
@in_browser
def test_a_pull_is_the_torque_of_its_force(page):
    """Virtual work: torques times small turns are the force times the way of its point."""
    work = page.evaluate(
        """() => {
          const x = one.state.x, tip = () => rig.lengths.reduce((at, l, i) =>
            [at[0] + l * Math.sin(x[i]), at[1] + l * Math.cos(x[i])], [0, 0]);
          torques.fill(0); force(0.7, -0.3, N - 1, rig.lengths[N - 1]);
          return Array.from(torques, (torque, i) => {
            const h = 1e-6; x[i] += h; const b = tip(); x[i] -= 2 * h; const a = tip(); x[i] += h;
            return [torque, (0.7 * (b[0] - a[0]) - 0.3 * (b[1] - a[1])) / (2 * h)];
          });
        }"""
    )
    for torque, wanted in work:
        assert math.isclose(torque, wanted, rel_tol=1e-6, abs_tol=1e-9)
