"""The live rig in headless Chromium: frames a second, and the share of one core it takes.

    python tests/benchmarks/live.py

The share is what Chromium's main thread was busy; `script` is the part that simulates and writes
the picture, the rest is drawing (in software here, on a graphics card elsewhere).
"""

import shutil
import tempfile
from pathlib import Path

from playwright.sync_api import sync_playwright

import pendlab as pl

SECONDS = 5


def busy(session):
    metrics = session.send("Performance.getMetrics")["metrics"]
    return {entry["name"]: entry["value"] for entry in metrics}


def measure(page):
    session = page.context.new_cdp_session(page)
    session.send("Performance.enable")
    before, frames = busy(session), page.evaluate("frames")
    page.wait_for_timeout(1000 * SECONDS)
    after, more = busy(session), page.evaluate("frames")
    passed = after["Timestamp"] - before["Timestamp"]
    share = {key: (after[key] - before[key]) / passed for key in ("TaskDuration", "ScriptDuration")}
    return (more - frames) / passed, share["TaskDuration"], share["ScriptDuration"]


def main():
    path = shutil.which("chromium") or shutil.which("google-chrome")
    with sync_playwright() as play, tempfile.TemporaryDirectory() as folder:
        browser = play.chromium.launch(
            executable_path=path, args=["--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"]
        )
        for name in ("double", "triple"):
            file = Path(folder) / f"{name}.html"
            file.write_text(str(pl.live_rig(name)), encoding="utf-8")
            page = browser.new_page(viewport={"width": 1366, "height": 768})
            page.goto(file.as_uri())
            page.wait_for_timeout(1000)
            rate, share, script = measure(page)
            print(
                f"{name}: {rate:.0f} frames a second, {share:.2f} of a core (script {script:.2f})"
            )
            took = page.evaluate(
                "() => { const t = performance.now(); simulate(rig.start, 10, BENCH, rig.inner);"
                " return performance.now() - t; }"
            )
            print(f"{name}: {took / 10:.2f} ms of script for a simulated second of the bench")
        browser.close()


if __name__ == "__main__":
    main()
