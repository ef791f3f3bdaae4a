"""The rig that one can touch: the simulator itself, running in the browser, with a hand on the links."""

import base64
import json
from dataclasses import replace
from html import escape
from itertools import pairwise
from pathlib import Path

import numpy as np

from .._arguments import found
from ..bench.arguments import one_of
from ..bench.gearbox import bench_imperfections, bench_rig, bench_start
from ..bench.generated import kernel_text
from ..bench.plant import ACCURATE, LARGEST_STEP, bench_tuples, fastest_rate, integration
from ..bench.tuples import Law, Memory
from ..design import Design
from ..figures.moving import draw_pendulum, link_color
from ..figures.style import describe, image_html, look, new_figure, small_png, styled
from ..paper.designs import paper_design
from .javascript import to_javascript

HERE = Path(__file__).parent
GAINS = (1, 1.5, 2, 3, 4, 5, 7, 10, 14, 20, 30, 40, 50, 60, 70)  # V/rad: a design for each


# Where a notebook is not trusted, frame and style are both taken out, and the picture is seen.
FRAMED = """<style>.pendlab-live + .pendlab-still {{ display: none }}</style>
<iframe class="pendlab-live" title="Live rig: {name}" srcdoc="{page}" \
style="width: 100%; height: 640px; border: 0"></iframe>
<div class="pendlab-still">{picture}<p>{words}</p></div>"""
WORDS = "The live rig moves once this notebook is trusted, or its cell is run."


class LiveRig:
    """A page that shows itself in a notebook; ``str(live)`` is its HTML, which needs no network."""

    def __init__(self, page, design):
        self._page, self._design = page, design
        self._name = f"{design.rig.name} inverted pendulum"

    def __str__(self):
        return self._page

    def __repr__(self):
        return f"Live rig: {self._name}. Without a picture here, run this cell."

    def _repr_html_(self):
        picture = still(self._design)
        return FRAMED.format(
            name=escape(self._name),
            page=escape(self._page),
            picture=image_html(small_png(picture), picture.alt),
            words=WORDS,
        )


@styled()
def still(design):
    """The rig as its hand lets it go, for where the page cannot be shown."""
    fig, start = new_figure(4.0, 3.4), bench_start(design.rig)
    draw_pendulum(fig.subplots(), design.rig, start)
    lean = ", ".join(f"{angle:g}" for angle in start)
    alt = f"The {design.rig.name} pendulum held nearly upright, at relative angles of {lean} rad."
    return describe(fig, WORDS, alt)


def live_rig(design="triple"):
    """The pendulum under the paper's controller, live: pushed with mouse, finger or keys.

    The browser runs the kernel of `simulate` itself, statement by statement, with gears, friction,
    filters, converters and delay, at the rig's own pace. Sliders change them and, where the design
    has one, k_p, whose gains are computed here for each position.

    Parameters
    ----------
    design : "double" or "triple", the paper's; or a `Design` of your own for such a rig

    Returns
    -------
    LiveRig : shows itself in a notebook; `str` gives the page, which works by itself

    >>> page = str(live_rig("double"))
    >>> "http" in page.replace("http://www.w3.org/2000/svg", "")
    False
    """
    if isinstance(design, str):
        design = paper_design(one_of("design", design, ("double", "triple")))
    if not isinstance(design, Design):
        raise TypeError(f'design: expected "double", "triple" or a pl.Design, {found(design)}.')
    kernel = kernel_text(design.rig.n_links, design.rig.n_motors)
    # JSON has no infinity.
    payload = json.dumps(packed(design), default=np.ndarray.tolist).replace("Infinity", '"inf"')
    parts = {
        "TITLE": f"{design.rig.name} inverted pendulum".capitalize(),
        "KERNEL": to_javascript(kernel, skip=("constants",)),
        "SCRIPT": (HERE / "live.js").read_text(encoding="utf-8"),
        "PAYLOAD": base64.b64encode(payload.encode()).decode(),
    }
    page = (HERE / "live.html").read_text(encoding="utf-8")
    for mark, text in parts.items():
        page = page.replace(mark, text)
    return LiveRig(page, design)


def packed(design):
    """All that the script needs of a design on the bench: lists and numbers for JSON."""
    rig, controller = bench_rig(design.rig), design.controller
    bench, o = bench_imperfections(rig), design.observer
    start, n, m = np.array(bench_start(rig)), rig.n_links, rig.n_motors
    x0, loads = np.concatenate([start, np.zeros(n)]), (np.zeros((0, 4)), np.zeros((1, n)))
    clock = integration(rig, bench, design.dt, 1)
    parts, stiff = (
        bench_tuples(rig, on, x0, loads, clock, 1) for on in (bench, replace(bench, gap=0.0))
    )
    u_max = np.full(m, np.inf) if controller.u_max is None else np.array(controller.u_max)
    law = Law(o.E, o.H, o.K, o.L1, o.L2, controller.F, np.array(controller.tracked), u_max)
    memory = Memory(*(np.zeros(count) for count in (len(o.E), len(controller.tracked), len(o.E))))
    gains = [
        {"kp": kp, "F": design.changed(kp=float(kp)).controller.F}
        for kp in (sorted({*GAINS, design.kp}) if design.kp is not None else ())
    ]
    return {
        "names": ["θ₁", *(f"θ{b}−θ{a}" for a, b in pairwise("₁₂₃₄₅₆"[:n]))],
        "colors": [link_color(i) for i in range(1, n + 1)],
        "volt_colors": [look(f"u{j}")["color"] for j in range(1, m + 1)],
        "lengths": [link.length for link in rig.links],
        "u_max": rig.u_max,
        "dt": design.dt,
        "delay": bench.delay,
        "inner": min(LARGEST_STEP, ACCURATE / fastest_rate(rig, bench), design.dt),
        "start": start,
        "T": o.T,
        "law": law._asdict(),
        "memory": memory._asdict(),
        "plant": parts.plant._asdict(),
        "stiff": stiff.plant.c,
        "ports": parts.ports._asdict(),
        "offset": bench.each("offset", n + 1),
        "gains": gains,
        "kp_at": next((i for i, g in enumerate(gains) if g["kp"] == design.kp), 0),
    }
