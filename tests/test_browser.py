"""JupyterLab in headless Chromium: every widget answers to the keyboard, in the page a student sees.

One server, one notebook with a cell for each widget. PENDLAB_SCREENSHOTS=folder keeps the pictures.
The last pictures of panels outlive their kernel, and axe-core finds nothing but what is not ours.
"""

import base64
import io
import json
import os
import shutil
import socket
import subprocess
import sys
import time
import urllib.request
from contextlib import suppress
from pathlib import Path

import nbformat
import numpy as np
import pytest
from PIL import Image
from refresh_notebooks import notebooks

import pendlab as pl
from pendlab.__main__ import main

pytestmark = pytest.mark.browser

CHROMIUM = next(
    filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None
)
if CHROMIUM is None and os.environ.get("CI") != "true":
    pytest.skip("no Chromium or Chrome found on PATH", allow_module_level=True)

# A cell for each widget, and a field with a value that cannot work (None where every value can).
WIDGETS = {
    "kp_panel()": None,
    'weights_panel("double")': ("Q5: weight of w", "0"),
    'weights_panel("triple")': ("Q7: weight of w", "0"),
    'observer_panel("double")': None,
    'observer_panel("triple")': None,
    "triple_panel()": None,
    'bench_panel("double")': None,
    "bar_panel()": None,
    "sampling_panel()": None,
}
ROOT = Path(__file__).parent.parent
LAB_PC = {"width": 1366, "height": 768}
SETTINGS = {
    "apputils-extension/notification": {"fetchNews": "false", "checkForUpdates": False},
    "notebook-extension/tracker": {"windowingMode": "none"},
}


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    """Address of the workspaces of a JupyterLab on this machine, with folders of its own."""
    home = tmp_path_factory.mktemp("lab")
    cells = [
        nbformat.v4.new_code_cell(f"import pendlab as pl\n\npl.{call}", id=f"widget-{k}")
        for k, call in enumerate(WIDGETS)
    ]
    mover = "mover = pl.bar_panel()\nmover", "mover.at(bar1=0.03)", "mover.at(bar1=0.0)"
    cells += [
        nbformat.v4.new_code_cell(source, id=f"mover-{k}")
        for k, source in enumerate((*mover, "print(mover.values)"))
    ]
    kernel = {"display_name": "Python 3 (ipykernel)", "language": "python", "name": "python3"}
    notebook = nbformat.v4.new_notebook(cells=cells, metadata={"kernelspec": kernel})
    nbformat.write(notebook, home / "widgets.ipynb")
    notebook.cells = cells[:1]
    nbformat.write(notebook, home / "seven.ipynb")
    start = nbformat.read(ROOT / "notebooks" / "00_start_here.ipynb", as_version=4)
    for cell in start.cells:
        if cell.cell_type == "code":  # what the page shows then must come from running it
            cell.outputs, cell.execution_count = [], None
    nbformat.write(start, home / "start.ipynb")
    for name, value in SETTINGS.items():
        path = home / "settings" / "@jupyterlab" / f"{name}.jupyterlab-settings"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(value))
    folders = {
        "JUPYTER_CONFIG_DIR": "config",
        "JUPYTER_DATA_DIR": "data",
        "IPYTHONDIR": "ipython",
        "JUPYTERLAB_SETTINGS_DIR": "settings",
        "JUPYTERLAB_WORKSPACES_DIR": "workspaces",
    }
    environment = {**os.environ, **{key: str(home / name) for key, name in folders.items()}}
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    command = [sys.executable, "-m", "jupyterlab", "--no-browser", "--ip=127.0.0.1"]
    command += [f"--port={port}", "--ServerApp.port_retries=0", "--IdentityProvider.token=lab"]
    command += ["--allow-root", f"--ServerApp.root_dir={home}"]
    with open(home / "server.log", "w") as log:
        server = subprocess.Popen(command, env=environment, stdout=log, stderr=log)
    try:
        _wait_for(f"http://127.0.0.1:{port}/api/status?token=lab", server)
        yield f"http://127.0.0.1:{port}/lab/workspaces"
    finally:
        server.terminate()
        server.wait(20)


def _wait_for(address, server):
    for _ in range(120):
        try:
            urllib.request.urlopen(address, timeout=5)
            return
        except OSError:
            assert server.poll() is None, "JupyterLab stopped while starting"
            time.sleep(0.5)
    raise TimeoutError("JupyterLab did not answer within a minute")


@pytest.fixture(scope="module")
def browser():
    from playwright.sync_api import sync_playwright

    assert CHROMIUM, "CI must have Chromium: see .ci/run"
    flags = ["--no-sandbox", "--disable-gpu", "--disable-background-networking"]
    with sync_playwright() as play:
        browser = play.chromium.launch(
            executable_path=CHROMIUM, args=[*flags, "--disable-dev-shm-usage"]
        )
        yield browser
        browser.close()


def opened(browser, lab, name, complaints):
    """A page with the notebook opened as a student would, and all its cells run.

    JupyterLab that starts on a busy machine may ask for a kernel, or lose the first command; what is
    tested here begins once it runs, so a start that hangs is made again in a new workspace.
    """
    from playwright.sync_api import TimeoutError as Hangs

    for attempt in range(4):
        complaints.clear()
        # What moves would keep a processor busy as long as the page is open.
        page = browser.new_page(viewport=LAB_PC, reduced_motion="reduce")
        page.set_default_timeout(30_000)
        page.on("console", lambda m: complaints.append(m.text) if m.type == "error" else None)
        page.on("pageerror", lambda error: complaints.append(str(error)))
        try:
            page.goto(f"{lab}/{name}{attempt}?token=lab")
            if started(page, name):
                page.set_default_timeout(60_000)
                return page
        except Hangs as problem:
            print(f"start {attempt + 1} of JupyterLab hangs:", str(problem).splitlines()[0])
        page.close()
    raise AssertionError("JupyterLab did not run the cells")


def started(page, name):
    """Open the notebook from the file browser and run its cells; whether they run."""
    from playwright.sync_api import TimeoutError as Hangs

    # The launcher's card says that Lab knows its kernels; opened earlier, a notebook asks for one.
    page.wait_for_selector(".jp-LauncherCard[data-category='Notebook']")
    page.dblclick(f".jp-DirListing-item:has-text('{name}.ipynb')")
    page.wait_for_selector(".jp-Notebook-ExecutionIndicator[data-status='idle']")
    if page.locator(".jp-Dialog").count():
        page.locator(".jp-Dialog .jp-mod-accept").first.click()
    for _ in range(3):
        page.click(".lm-MenuBar-itemLabel:text-is('Run')")
        page.click(".lm-Menu-itemLabel:text-is('Run All Cells')")
        with suppress(Hangs):
            page.wait_for_function(
                "() => [...document.querySelectorAll('.jp-CodeCell .jp-InputPrompt')]"
                ".some(prompt => /[*1-9]/.test(prompt.textContent))",
                timeout=4000,
            )
            return True
    return False


def settled(page):
    """Wait until the kernel has nothing left to do."""
    page.wait_for_timeout(1500)  # Lab moves the focus after Run All
    page.wait_for_selector(".jp-Notebook-ExecutionIndicator[data-status='idle']", timeout=120_000)
    assert_no_complaint(page)


def assert_no_complaint(page):
    assert page.locator(".jp-RenderedText[data-mime-type*=stderr]").count() == 0
    assert page.locator(".jp-RenderedText:has-text('Traceback')").count() == 0


def answered(page, face):
    """Wait until the kernel has answered what the hand did last."""
    page.wait_for_function(
        "face => !face.classList.contains('asked')", arg=face.element_handle(), timeout=120_000
    )
    assert_no_complaint(page)


def test_start_page_runs(browser, lab):
    complaints = []
    page = opened(browser, lab, "start", complaints)
    keep(page, "start")
    if main(["doctor"]) == 0:  # not at the lower bounds, which are other versions
        page.locator("text=all well").first.wait_for(timeout=60_000)
    page.locator("text=Your rig is loaded").first.wait_for(timeout=120_000)
    settled(page)
    keep(page, "start")
    assert complaints == []
    page.close()


@pytest.fixture(scope="module")
def widgets(browser, lab):
    """The page with all widgets, and what the browser complained about."""
    complaints = []
    page = opened(browser, lab, "widgets", complaints)
    page.wait_for_function(
        "n => document.querySelectorAll('.pendlab-face').length >= n",
        arg=len(WIDGETS),
        timeout=180_000,
    )
    settled(page)
    yield page, complaints
    page.close()


def pixels(image):
    """The picture that the browser shows, as an array."""
    data = image.evaluate(
        """async image => {
            const bytes = new Uint8Array(await (await fetch(image.src)).arrayBuffer());
            let text = ''; for (const byte of bytes) text += String.fromCharCode(byte);
            return btoa(text);
        }"""
    )
    return np.asarray(Image.open(io.BytesIO(base64.b64decode(data))).convert("RGB"))


def keep(page, name):
    folder = os.environ.get("PENDLAB_SCREENSHOTS")
    if folder:
        page.screenshot(path=Path(folder) / f"{name}.png")


def face_of(page, call):
    """The panel of one cell, scrolled into sight."""
    face = (
        page.locator(".jp-CodeCell").nth(list(WIDGETS).index(call)).locator(".pendlab-face").first
    )
    face.evaluate("face => face.scrollIntoView()")
    face.locator("button:text-is('Reset')").click()
    answered(page, face)
    return face


def pressed(page, face, slider, key):
    """Press a key on a slider and wait for the next picture."""
    image = face.locator(".views > img")
    before = image.get_attribute("src")
    slider.focus()
    page.keyboard.press(key)
    page.wait_for_function(
        "([image, before]) => image.getAttribute('src') !== before",
        arg=[image.element_handle(), before],
        timeout=30_000,
    )
    answered(page, face)


@pytest.mark.parametrize("call", WIDGETS)
def test_slider_moves_the_picture_to_what_the_panel_computes(widgets, call):
    page, _ = widgets
    face = face_of(page, call)
    image, slider = face.locator(".views > img"), face.locator("input[type=range]:enabled").first
    panel = eval(f"pl.{call}", {"pl": pl})
    assert np.array_equal(pixels(image), decoded(panel))
    told = panel._widget.face["groups"][0]["controls"]
    name = next(control["name"] for control in told if control["kind"] == "slider")
    control = panel.controls[name]
    assert slider.evaluate("slider => slider.labels[0].textContent") == control.label
    low = control.position_of(panel.values[name]) < 10
    for key, way in (("PageUp", 10) if low else ("PageDown", -10), ("ArrowLeft", -1)):
        pressed(page, face, slider, key)
        value = control.value_at(control.position_of(panel.values[name]) + way)
        caption = panel.at(**{name: value})
        assert slider.evaluate("slider => slider.ariaValueText") == control.spoken(value)
    assert np.array_equal(pixels(image), decoded(panel))
    state = panel._widget.state
    words = face.locator("[role=status]").inner_text().split()
    assert words == " ".join(state["words"]).split()
    cells = [cell for row in state["table"] for cell in row]
    assert face.locator("td, th").all_inner_texts() == cells
    assert image.get_attribute("alt") == state["alt"] and caption
    keep(page, call.split("(")[0] + ("_triple" if "triple" in call else ""))
    panel.close()


def decoded(panel):
    return np.asarray(Image.open(io.BytesIO(panel.picture)).convert("RGB"))


def test_verdict_and_picture_are_in_sight_together(widgets):
    """On a screen of 1366 x 768, with what JupyterLab leaves of it."""
    page, _ = widgets
    for call in WIDGETS:
        face = face_of(page, call)
        image = face.locator(".views > img").bounding_box()
        room = page.locator(".jp-WindowedPanel-outer, .jp-Notebook").first.bounding_box()
        bottom = room["y"] + room["height"]
        assert image["y"] + image["height"] <= bottom, call
        if "bar" not in call:
            assert face.locator(".verdict").bounding_box()["y"] >= room["y"] - 1, call


@pytest.mark.parametrize("call", [call for call, bad in WIDGETS.items() if bad])
def test_impossible_value_shows_its_sentence(widgets, call):
    page, _ = widgets
    label, value = WIDGETS[call]
    face = face_of(page, call)
    face.locator("summary").first.click()
    field = face.locator(f"input[aria-label^='{label}']")
    good = field.input_value()
    field.fill(value)
    field.press("Enter")
    sentence = face.locator("[role=status]:has-text('cannot work')")
    sentence.wait_for(timeout=30_000)
    keep(page, f"{call.split('(')[0]}_impossible")
    field.fill("a lot")
    field.press("Enter")
    face.locator("[role=status]:has-text('expected a number')").wait_for(timeout=30_000)
    field.fill(good)
    field.press("Enter")
    sentence.wait_for(state="detached", timeout=30_000)


def test_slider_that_moves_nothing_is_disabled_and_says_why(widgets):
    page, _ = widgets
    face = face_of(page, 'observer_panel("triple")')
    turn = face.locator("input[aria-label^=phi1]")
    assert turn.is_disabled() and face.locator("small:has-text('alpha = beta')").count() == 2
    pressed(page, face, face.locator("input[type=range]").nth(1), "ArrowLeft")
    assert turn.is_enabled() and not face.locator("small:has-text('alpha = beta')").count()


def test_a_halted_pendulum_stays_halted_while_sliders_move(widgets):
    page, _ = widgets
    face = face_of(page, 'bench_panel("double")')
    face.locator(".beside button").click()
    drawing = face.locator(".beside svg")
    halted = drawing.evaluate("svg => svg.getCurrentTime()")
    pressed(page, face, face.locator("input[type=range]:enabled").first, "PageUp")
    go_on = face.locator(".beside button:text-is('Go on')")
    go_on.wait_for(timeout=30_000)
    clock = "svg => [svg.animationsPaused(), svg.getCurrentTime()]"
    assert drawing.evaluate(clock) == [True, pytest.approx(halted, abs=0.01)]
    go_on.click()
    assert drawing.evaluate(clock)[0] is False


def test_values_stay_where_the_code_put_them(widgets):
    """After Run All the browser reports, late, where it drew the slider; that must change nothing."""
    page, _ = widgets
    last = page.locator(".jp-CodeCell").last
    last.scroll_into_view_if_needed()
    last.locator(".cm-content").click()
    page.keyboard.press("Control+Enter")
    settled(page)
    assert "'bar1': 0.0," in last.locator(".jp-OutputArea-output").inner_text()


def test_nothing_is_wider_than_a_lab_pc(widgets):
    page, _ = widgets
    room = page.locator(".jp-OutputArea-output").first.bounding_box()["width"]
    for box in page.locator(".pendlab-face img:visible").all():
        assert box.bounding_box()["width"] <= room


def barriers(page, context=None, allowed=()):
    """What axe-core finds in a page, or in a part of it, that keeps readers out; by all its rules."""
    from axe_playwright_python.sync_playwright import Axe

    off = {"rules": {rule: {"enabled": False} for rule in allowed}}
    found = Axe().run(page, context, options=off).response
    assert found["passes"], "axe saw nothing"
    return [
        (rule["id"], node["html"][:200]) for rule in found["violations"] for node in rule["nodes"]
    ]


# JupyterLab's own: buttons of its toolbars, editors without a name, its list of cells, its skip link.
OF_LAB = ("aria-allowed-attr", "aria-input-field-name", "aria-required-children", "region")


def test_live_panels_keep_nobody_out(widgets):
    page, _ = widgets
    assert barriers(page, ".pendlab-face") == []
    assert barriers(page, allowed=OF_LAB) == []


def test_arrow_keys_move_a_slider_in_notebook_7_too(browser, lab):
    """It takes them for its cells before a page's own listeners hear of them."""
    page = browser.new_page(viewport=LAB_PC)
    page.goto(f"{lab.removesuffix('/lab/workspaces')}/notebooks/seven.ipynb?token=lab")
    page.wait_for_selector(".jp-Notebook-ExecutionIndicator[data-status='idle']", timeout=60_000)
    page.click(".jp-Notebook .cm-content")
    page.keyboard.press("Control+Enter")
    page.wait_for_selector(".pendlab-face", timeout=180_000)
    settled(page)
    face = page.locator(".pendlab-face")
    slider = face.locator("input[type=range]").first
    here = int(slider.input_value())
    for key, way in (("ArrowRight", 1), ("ArrowDown", 0)):
        pressed(page, face, slider, key)
        assert int(slider.input_value()) == here + way
    page.close()


def test_browser_has_nothing_to_complain_about(widgets):
    _, complaints = widgets
    assert complaints == []


def test_saved_notebook_shows_the_last_pictures_without_a_kernel(widgets, browser, lab):
    """Saved, kernel shut down, opened again: every panel's last picture with its words, no error."""
    page, _ = widgets
    face = face_of(page, "kp_panel()")
    pressed(page, face, face.locator("input[type=range]").first, "PageUp")
    last = face.locator("[role=status]").inner_text().split()[:3]
    page.wait_for_timeout(2000)  # the stored picture follows once the hand rests
    face.locator("input[type=range]").first.focus()
    page.keyboard.press("Control+s")
    page.wait_for_selector(".jp-DirListing-item:has-text('widgets.ipynb')")
    page.wait_for_timeout(3000)
    server = lab.removesuffix("/lab/workspaces")
    for session in json.load(urllib.request.urlopen(f"{server}/api/sessions?token=lab")):
        request = urllib.request.Request(
            f"{server}/api/sessions/{session['id']}?token=lab", method="DELETE"
        )
        urllib.request.urlopen(request)
    again = browser.new_page(viewport=LAB_PC)
    again.goto(f"{lab}/again?token=lab")
    again.wait_for_selector(".jp-LauncherCard[data-category='Notebook']")
    again.dblclick(".jp-DirListing-item:has-text('widgets.ipynb')")
    pictures = again.locator(".jp-OutputArea-output img")
    again.wait_for_function(
        "n => document.querySelectorAll('.jp-OutputArea-output img').length >= n",
        arg=len(WIDGETS) + 1,
        timeout=90_000,
    )
    again.wait_for_timeout(3000)
    assert all(picture.is_visible() and picture.get_attribute("alt") for picture in pictures.all())
    assert not any(error.is_visible() for error in again.locator("text=model not found").all())
    words = again.locator(".jp-OutputArea-output p").first.inner_text().split()
    assert words[:3] == last
    assert barriers(again, ".jp-OutputArea-output") == []
    keep(again, "reopened")
    again.close()


# Exports of the stored notebooks


@pytest.mark.parametrize("path", notebooks(), ids=lambda path: path.stem)
def test_exports_keep_nobody_out(browser, path):
    from nbconvert import HTMLExporter

    html, _ = HTMLExporter().from_filename(str(path))
    page = browser.new_page()
    page.route("**/*", lambda route: route.abort())  # no network is needed for pictures
    page.set_content(html, wait_until="domcontentloaded")
    stored = nbformat.read(path, as_version=4)
    panels = sum("pendlab-00000000" in str(cell.get("outputs")) for cell in stored.cells)
    assert page.locator("div[class^=pendlab-] img:visible").count() == panels
    ours = ".jp-OutputArea-output, .jp-MarkdownCell img"  # the rest is nbconvert's
    assert not page.locator(ours).count() or barriers(page, ours) == []
    page.close()


def test_a_moving_picture_can_be_halted(browser):
    rig = pl.load("double")
    page = browser.new_page()
    page.set_content(pl.animation(rig, [0.0, 8.0], np.zeros((2, 2))).data)
    drawing, button = page.locator("details svg"), page.locator("button")
    clock = "svg => svg.getCurrentTime()"
    page.wait_for_function("() => document.querySelector('details svg').getCurrentTime() > 0")
    button.click()
    halted = drawing.evaluate(clock)
    page.wait_for_timeout(200)
    assert drawing.evaluate(clock) == halted and button.inner_text() == "Go on"
    button.click()
    page.wait_for_timeout(200)
    assert drawing.evaluate(clock) > halted
    still = page.locator(".pendlab-rest img")
    assert not still.is_visible()
    page.click("summary")
    assert still.is_visible() and not drawing.is_visible()
    page.close()
