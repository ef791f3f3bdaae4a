"""The bench as a widget: reference, pushes, every imperfection, traces and the moving pendulum."""

from functools import partial

import numpy as np

from ..bench.gearbox import bench_imperfections, bench_rig, bench_start
from ..bench.imperfections import Imperfections, Pulse
from ..bench.many import simulate_many
from ..bench.simulation import simulate
from ..figures.moving import animation
from ..figures.outcomes import angle_in_words
from ..figures.traces import bench_page
from ..paper.designs import paper_design
from .panel import Panel
from .parts import Choice, Slider, Switch, View

WINDOWS = {  # s, and the figure that shows them
    "double": [(0, 8, ""), (10, 18, " (Fig 17)"), (0, 37, "")],
    "triple": [(0, 7, " (Fig 15)"), (30, 37, " (Fig 16)"), (0, 37, "")],
}
HARDEST = 10.0  # N m, of the pushes tried


def bench_panel(name="triple"):
    """The paper's controller on the bench of ``data/gearbox.toml``, all of it within reach."""
    design = paper_design(name)
    rig, controller = design.rig, design.controller
    windows = {f"{a} to {b} s{fig}": (float(a), float(b)) for a, b, fig in WINDOWS[name]}
    controls = bench_controls(rig, windows)
    shown = []

    def run(values):
        # The time shown, and what comes of a push after it.
        push_ends = values["at"] + values["length"] + 5.0 if values["height"] else 0.0
        t_end = max(values["window"][1], push_ends)
        return simulate(bench_plant(rig, values), controller, t_end, **bench_case(rig, values))

    def update(**values):
        shown[:] = run(values), values["window"]
        return fig.update(*shown).caption

    def moving():
        run, (start, end) = shown
        inside = (run.t >= start) & (run.t <= end)
        if inside.sum() < 2:
            inside = slice(-2, None)
        about = dict(caption="The pendulum in real time", width=280, height=350)
        return animation(rig, run.t[inside], run.angles[inside], **about).data

    start = {c.name: c.value for group in controls.values() for c in group}
    fig = bench_page(run(start), start["window"])
    switches = [c.name for group in controls.values() for c in group if isinstance(c, Switch)]
    push = {"link": rig.n_links, "height": 0.05, "at": start["window"][0] + 3}
    return Panel(
        f"The {name} on the bench",
        controls,
        View(fig, update, fig.moving, moving, bench_idle),
        legend=(
            "Reference: of the relative angle θ2−θ1, from the start on. Start by hand: initial angles "
            "as a multiple of the bench's.",
            "Push: a torque on one link for a while. The button finds the largest one that the "
            "pendulum survives, with everything else as set.",
            "Each imperfection has a switch and its value; the bench's values come from the data file.",
            "A push after the time shown is simulated too: the verdict tells how it ends.",
            "Traces: what the computer reads and sends. Right: the pendulum in real time.",
        ),
        presets={
            "Bench": start,
            "Ideal rig": dict.fromkeys(switches, False),
            "A push": push,
        },
        actions={"How hard may the push be?": partial(hardest_push, rig, controller)},
        first=("height", "at", "window"),
    )


def bench_controls(rig, windows):
    """Controls by heading, at the values of the bench."""
    on, n, m = bench_imperfections(rig), rig.n_links, rig.n_motors
    outputs = [f"{angle_in_words(i + 1)}, rad" for i in range(n)] + ["rate, rad/s"]
    offsets = on.each("offset", n + 1)
    noise, steps = on.each("noise", n + 1), on.each("resolution", n + 1)

    def per_motor(name, label, low, high):
        return [
            Slider(f"{name}{j}", label.format(j), low, high, float(value), log=True, zero=True)
            for j, value in enumerate(on.each(name, m), 1)
        ]

    return {
        "Reference, push": [
            Slider("reference", "reference, rad", -0.3, 0.3, 0.0, step=0.01),
            Slider("start", "start, times", -3, 3, 1.0, step=0.1),
            Choice("window", "time shown", windows, next(iter(windows.values()))),
            Choice("link", "push on link", {str(i): i for i in range(1, n + 1)}, n),
            Slider("height", "push, N m", -2, 2, 0.0, step=0.01),
            Slider("at", "push at, s", 0, 36, 3.0, step=0.5),
            Slider("length", "push lasts, s", 0.01, 2, 0.1, log=True),
        ],
        "Signals": [
            Switch("filters", "filters", on.filters),
            Switch("saturation", "voltage limits", on.saturation),
            Switch("offset_on", "sensor offsets", bool(np.any(offsets))),
            *[
                Slider(f"offset{i + 1}", f"offset of {output}", -0.05, 0.05, float(value), step=1e-3)
                for i, (output, value) in enumerate(zip(outputs, offsets))
            ],
            Switch("delay_on", "computation delay", on.delay > 0),
            Slider("delay", "delay, ms", 0, 12, _3(1e3 * on.delay), step=0.1),
            Switch("resolution_on", "A/D converter", bool(np.any(steps))),
            Slider("resolution", "A/D step, rad", 1e-5, 0.1, _3(steps[0]), log=True),
            Switch("dac_on", "D/A converter", bool(np.any(on.voltage_resolution))),
            Slider("dac", "D/A step, V", 1e-4, 2, _3(np.max(on.voltage_resolution)), log=True),
            Switch("noise_on", "noise", bool(np.any(noise))),
            Slider("noise", "noise, rad", 1e-5, 0.1, _3(noise[0]) or 1e-3, log=True),
            Slider("rate_noise", "noise, rad/s", 1e-4, 1, _3(noise[-1]) or 1e-2, log=True),
        ],
        "Friction, gaps": [
            Switch("hinge_on", "dry friction, hinges", bool(np.any(on.hinge_friction))),
            Slider("hinge", "of each hinge, N m", 1e-4, 1,
                   _3(np.max(on.hinge_friction)) or 1e-2, log=True),
            Switch("gear_on", "dry friction, gears", bool(np.any(on.gear_friction))),
            *per_motor("gear_friction", "gearbox {}, N m", 1e-3, 10),
            Slider("presliding", "presliding, rad", 1e-4, 1e-2, on.presliding, log=True),
            Switch("damping_on", "damping of the bench's motors", True),
            Switch("gap_on", "backlash", bool(np.any(on.gap))),
            *per_motor("gap", "gap {}, rad", 1e-4, 0.5),
            *per_motor("contact_stiffness", "stiffness {}, N m/rad", 1, 1e4),
            *per_motor("contact_damping", "damping {}, s/rad", 1e-3, 10),
        ],
    }  # fmt: skip


# Switch -> the beginnings of the names of what moves nothing while it is off, and its name.
NEEDS = {
    "offset_on": (("offset",), "sensor offsets"),
    "delay_on": (("delay",), "computation delay"),
    "resolution_on": (("resolution",), "A/D converter"),
    "dac_on": (("dac",), "D/A converter"),
    "noise_on": (("noise", "rate_noise"), "noise"),
    "hinge_on": (("hinge",), "dry friction, hinges"),
    "gear_on": (("gear_friction",), "dry friction, gears"),
    "gap_on": (("gap", "contact_stiffness", "contact_damping"), "backlash"),
}


def bench_idle(values):
    """Controls that move nothing at these values, and why."""
    idle = {}
    for switch, (beginnings, label) in NEEDS.items():
        for name in values:
            if not values[switch] and name.rstrip("123456") in beginnings:
                idle[name] = f"needs the switch {label}"
    if not values["hinge_on"] and not values["gear_on"]:
        idle["presliding"] = "needs dry friction"
    if not values["height"]:
        idle |= dict.fromkeys(("link", "at", "length"), "needs a push other than 0 N m")
    return idle


def bench_plant(rig, values):
    """The rig that is simulated: with the damping of the bench's motors, or of their data sheets."""
    return bench_rig(rig) if values["damping_on"] else rig


def bench_case(rig, values):
    """Arguments of `simulate` from the values of `bench_controls`."""
    n, m = rig.n_links, rig.n_motors
    on = bench_imperfections(rig)

    def each(name, count):
        return tuple(values[f"{name}{i + 1}"] for i in range(count))

    def if_on(switch, value):
        return value if values[switch] else 0.0

    steps = on.each("resolution", n + 1)
    imperfections = Imperfections(
        filters=values["filters"],
        saturation=values["saturation"],
        resolution=if_on("resolution_on", tuple(steps * values["resolution"] / steps[0])),
        voltage_resolution=if_on("dac_on", values["dac"]),
        delay=if_on("delay_on", values["delay"] / 1e3),
        offset=if_on("offset_on", each("offset", n + 1)),
        noise=if_on("noise_on", (values["noise"],) * n + (values["rate_noise"],)),
        hinge_friction=if_on("hinge_on", values["hinge"]),
        gear_friction=if_on("gear_on", each("gear_friction", m)),
        gap=if_on("gap_on", each("gap", m)),
        contact_stiffness=each("contact_stiffness", m),
        contact_damping=each("contact_damping", m),
        presliding=values["presliding"],
    )
    push = Pulse(values["link"], values["at"], values["length"], values["height"])
    return dict(
        initial=values["start"] * np.array(bench_start(rig)),
        reference=values["reference"],
        imperfections=imperfections,
        disturbance=push if values["height"] else None,
    )


def hardest_push(rig, controller, values, progress):
    """The largest push each way that the pendulum survives for 5 s, as a sentence.

    The smallest of 40 heights up to 10 N m at which it falls is looked for each way, so the answer
    is good to a step of the grid (an eighth).
    """
    case, plant = bench_case(rig, values), bench_plant(rig, values)
    heights = np.geomspace(0.1, HARDEST, 40)
    cases = [
        {**case, "disturbance": Pulse(values["link"], values["at"], values["length"], height)}
        for height in (*heights, *-heights)
    ]
    t_end = values["at"] + values["length"] + 5.0
    runs = simulate_many(plant, controller, t_end, cases, progress=progress)
    ways = []
    for way, half in (("+", runs[:40]), ("-", runs[40:])):
        fell = [run is None or run.fell for run in half]
        first = [*fell, True].index(True)
        ways.append(f"{way}{heights[first - 1]:.2g}" if first else f"less than {way}{heights[0]:g}")
    return (
        f"A push of {values['length']:g} s on link {values['link']} may reach {' and '.join(ways)} N m; "
        "the next step of the search fells the pendulum within 5 s."
    )


def _3(value):
    return float(f"{value:.3g}")
