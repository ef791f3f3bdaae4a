"""JupyterLab in headless Chromium: every widget answers to the keyboard, in the page a student sees.

One server, one notebook with a cell for each widget. PENDLAB_SCREENSHOTS=folder keeps the pictures.
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
from pathlib import Path

import nbformat
import numpy as np
import pytest
from PIL import Image

import pendlab as pl

pytestmark = pytest.mark.browser

CHROMIUM = next(
    filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None
)
if CHROMIUM is None and os.environ.get("CI") != "true":
    pytest.skip("no Chromium or Chrome found on PATH", allow_module_level=True)

# A cell for each widget, and a field with a value that cannot work (None where every value can).
WIDGETS = {
    "kp_panel()": None,
    'weights_panel("double")': ("weight of w", "0"),
    'weights_panel("triple")': ("weight of w", "0"),
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
        page = browser.new_page(viewport=LAB_PC)
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
    # The launcher's card says that Lab knows its kernels; opened earlier, a notebook asks for one.
    page.wait_for_selector(".jp-LauncherCard[data-category='Notebook']")
    page.dblclick(f".jp-DirListing-item:has-text('{name}.ipynb')")
    page.wait_for_selector(".jp-Notebook-ExecutionIndicator[data-status='idle']")
    if page.locator(".jp-Dialog").count():
        page.locator(".jp-Dialog .jp-mod-accept").first.click()
    for _ in range(3):
        page.click(".lm-MenuBar-itemLabel:text-is('Run')")
        page.click(".lm-Menu-itemLabel:text-is('Run All Cells')")
        page.wait_for_timeout(4000)
        prompts = page.locator(".jp-CodeCell .jp-InputPrompt").all_inner_texts()
        if any(character in "*123456789" for prompt in prompts for character in prompt):
            return True
    return False


def settled(page):
    """Wait until the kernel has nothing left to do."""
    page.wait_for_timeout(1500)  # Lab moves the focus after Run All
    page.wait_for_selector(".jp-Notebook-ExecutionIndicator[data-status='idle']", timeout=120_000)
    assert page.locator(".jp-RenderedText[data-mime-type*=stderr]").count() == 0
    assert page.locator(".jp-RenderedText:has-text('Traceback')").count() == 0


def test_start_page_runs(browser, lab):
    complaints = []
    page = opened(browser, lab, "start", complaints)
    keep(page, "start")
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
        "n => document.querySelectorAll('.widget-image').length >= n",
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


@pytest.mark.parametrize("call", WIDGETS)
def test_slider_moves_the_picture_to_what_the_panel_computes(widgets, call):
    page, _ = widgets
    cell = page.locator(".jp-CodeCell").nth(list(WIDGETS).index(call))
    image = cell.locator(".widget-image").first
    image.scroll_into_view_if_needed()
    panel = eval(f"pl.{call}", {"pl": pl})
    before = image.get_attribute("src")
    assert np.array_equal(pixels(image), decoded(panel))
    handle = cell.locator(".widget-slider [role=slider]").first
    handle.focus()
    page.keyboard.press("PageUp")
    page.wait_for_function(
        "([image, before]) => image.getAttribute('src') !== before",
        arg=[image.element_handle(), before],
        timeout=30_000,
    )
    settled(page)
    name = next(n for n, control in panel.controls.items() if isinstance(control, pl.Slider))
    value = float(cell.locator("input[type=number]").first.input_value())
    assert value != panel.values[name]
    caption = panel.at(**{name: value})
    assert np.array_equal(pixels(image), decoded(panel))
    assert cell.locator("[role=status]").first.inner_text().split() == caption.split()
    keep(page, call.split("(")[0] + ("_triple" if "triple" in call else ""))
    panel.close()


def decoded(panel):
    return np.asarray(Image.open(io.BytesIO(panel.picture)).convert("RGB"))


@pytest.mark.parametrize("call", [call for call, bad in WIDGETS.items() if bad])
def test_impossible_value_shows_its_sentence(widgets, call):
    page, _ = widgets
    label, value = WIDGETS[call]
    cell = page.locator(".jp-CodeCell").nth(list(WIDGETS).index(call))
    row = cell.locator(".widget-hbox", has=page.locator(f".widget-label:has-text('{label}')")).last
    field = row.locator("input[type=number]").first
    good = field.input_value()
    field.fill(value)
    field.press("Enter")
    sentence = cell.locator("[role=status]:has-text('cannot work')")
    sentence.wait_for(timeout=30_000)
    keep(page, f"{call.split('(')[0]}_impossible")
    field.fill(good)
    field.press("Enter")
    sentence.wait_for(state="detached", timeout=30_000)


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
    for box in page.locator(".widget-image").all():
        assert box.bounding_box()["width"] <= room


def test_browser_has_nothing_to_complain_about(widgets):
    _, complaints = widgets
    assert complaints == []
