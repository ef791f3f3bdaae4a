"""Nonsense in every argument of every public callable: an answer, or one sentence of ours.

`GOOD` holds a call that works for each public function, class and method; a new one without an
entry fails. Each argument in turn is replaced by each kind of nonsense: allowed are an answer, or a
ValueError or TypeError that pendlab raises itself with one sentence that names an argument. Where
the value can have no meaning at all (an object of no kind, nan) an answer is wrong too.
"""

import faulthandler
import functools
import inspect
import linecache
import math
import signal
import warnings
from contextlib import contextmanager
from pathlib import Path
from types import FunctionType

import control
import numpy as np
import pytest

import pendlab as pl

PACKAGE = Path(pl.__file__).parent


class Thing:
    """An object of no use to anybody."""

    def __repr__(self):
        return "<a thing>"


KINDS = {
    "None": None,
    "text": "nonsense",
    "empty text": "",
    "True": True,
    "empty": [],
    "ragged": [[1.0], [1.0, 2.0]],
    "texts": ["a", "b"],
    "list of None": [None],
    "list of nan": [math.nan],
    "complex": 1 + 1j,
    "complex array": np.array([1 + 1j, 2.0]),
    "nan": math.nan,
    "inf": math.inf,
    "-inf": -math.inf,
    "-1": -1,
    "-0.5": -0.5,
    "0": 0,
    "2.5": 2.5,
    "1e300": 1e300,
    "1e-300": 1e-300,
    "10**400": 10**400,
    "10**9": 10**9,
    "shape": np.ones((2, 3, 4)),
    "dict": {"a": 1},
    "thing": Thing(),
    "list of things": [Thing()],
}
# Each number of the good value turned bad, its shape kept.
TURNS = {
    "all nan": lambda a: a * np.nan,
    "all huge": lambda a: a * 1e250,
    "all tiny": lambda a: a * 1e-250,
    "all zero": lambda a: a * 0.0,
    "all complex": lambda a: a + 1j,
    "reversed": lambda a: -a,
    "one more": lambda a: np.concatenate([a, a[:1]]),
}
# An answer to these is wrong, whatever the argument is.
MEANINGLESS = {"thing", "list of things", "nan", "list of nan", "all nan"}


def nonsense(value):
    """Kind -> nonsense for an argument whose good value is `value`."""
    kinds = dict(KINDS)
    if isinstance(value, control.StateSpace):
        A, B, C, D = value.A, value.B, value.C, value.D
        kinds["nan model"] = control.ss(A * np.nan, B, C, D, value.dt)
        kinds["huge model"] = control.ss(A * 1e250, B, C, D, value.dt)
        kinds["other time"] = control.ss(A, B, C, D, 0.5 if value.dt else 0.01)
        kinds["to continuous"] = control.ss(A, B, C, D, 0 if value.dt else 0.01)
        kinds["no time"] = control.ss(A, B, C, D, None)
        kinds["no states"] = control.ss([], [], [], D, value.dt)
        kinds["one input"] = control.ss(A, B[:, :1], C[:1], D[:1, :1], value.dt)
    elif isinstance(value, (list, tuple, np.ndarray)) and np.size(value):
        try:
            array = np.array(value, dtype=float)
        except (TypeError, ValueError):
            return kinds
        with np.errstate(all="ignore"):
            kinds |= {
                kind: turn(array)
                for kind, turn in TURNS.items()
                if array.ndim or kind != "one more"
            }
    return kinds


@functools.cache
def made(name):
    """What the calls below work on, made once."""
    design = pl.paper_design("double")
    triple = pl.paper_design("triple")
    return {
        "rig": lambda: design.rig,
        "triple": lambda: triple.rig,
        "design": lambda: design,
        "design3": lambda: triple,
        "plant": lambda: design.plant,
        "plant3": lambda: triple.plant,
        "model": lambda: design.model,
        "model3": lambda: triple.model,
        "controller": lambda: design.controller,
        "controller3": lambda: triple.controller,
        "loop": lambda: design.nominal_loop,
        "loop3": lambda: triple.filtered_loop,
        "observer": lambda: design.observer,
        "family": lambda: design.family,
        "closed": lambda: pl.closed_loop(design),
        "run": lambda: pl.simulate(design.rig, design.controller, 0.1),
        "run3": lambda: pl.simulate(triple.rig, triple.controller, 0.1),
        "motion": lambda: pl.derive(2, 1),
        "axes": lambda: pl.new_figure().subplots(),
        "study": lambda: pl.bar_study(design.rig, [0.01, 0.1]),
        "pushes": lambda: pl.largest_pulses(design.rig, design.controller, [0.1], accuracy=0.5),
        "runs": lambda: pl.bench_ensemble("double", 1),
        "runs3": lambda: pl.bench_ensemble("triple", 1),
        "cycles": lambda: pl.limit_cycles(triple, pl.bench_imperfections(triple.rig)),
        "state": lambda: design.controller.start(),
        "score": lambda: pl.Score(50.0, ()),
        "panel": lambda: pl.Panel(
            "t", [slider()], view(), actions={"go": lambda values, progress: "."}
        ),
    }[name]()


def slider():
    return pl.Slider("k_p", "k_p, V/rad", 0.0, 1.0, 0.5)


def view():
    return pl.View(pl.new_figure(), lambda **values: "caption")


class Still:
    """A controller that sends nothing."""

    def step(self, state, y, y_ref):
        return [0.0], state


def good():
    """Name -> one or more calls that work, as arguments by name."""
    m = made
    AB = dict(A=[[0.0, 1.0], [2.0, 0.0]], B=[[0.0], [1.0]])
    y, u, t = np.full(3, 0.01), np.zeros(1), np.linspace(0, 1, 20)
    sim = dict(rig=m("rig"), controller=m("controller"), t_end=0.05)
    link = dict(length=0.3, mass=1.0, inertia=0.01, com=0.2, friction=0.01)
    Pulse = dict(link=1, start=0.0, length=0.1, height=0.1)
    return {
        "Link": link,
        "Motor": dict(damping=1.0, inertia=0.01, gain=1.0, ratio=100.0),
        "Filters": dict(input_hz=(10.0,), output_hz=(20.0, 20.0, 20.0)),
        "Pendulum": dict(
            links=m("rig").links,
            motors=m("rig").motors,
            filters=m("rig").filters,
            u_max=(10.0,),
            g=9.81,
            name="mine",
        ),
        "load": dict(name="double"),
        "rigs": {},
        "EquationsOfMotion": None,
        "EquationsOfMotion.values": dict(rig=m("rig")),
        "derive": dict(n_links=2, n_motors=1),
        "linearize": dict(rig=m("rig")),
        "nonlinear": dict(rig=m("rig")),
        "energy": dict(rig=m("rig"), x=np.zeros(4)),
        "with_filters": dict(plant=m("plant"), filters=m("rig").filters),
        "sample": dict(plant=m("plant"), dt=0.01, delay=0.005),
        "align": dict(model=m("model3"), kp=10.0),
        "alignment_interval": dict(model=m("model3")),
        "add_integrator": dict(model=m("model"), output=1),
        "controllability_ratio": AB,
        "distance_to_uncontrollability": dict(AB, tolerance=0.01),
        "in_units": dict(plant=m("plant"), angle=0.1, second=0.2, volts=10.0),
        "with_bar": dict(rig=m("rig"), link=1, inertia=0.01, mass=0.1, height=0.1),
        "least_effort": dict(rig=m("rig"), x0=[0.1, 0.0, 0.0, 0.0]),
        "recoverable_tilt": dict(rig=m("rig"), direction=[1.0, 0.0, 0.0, 0.0]),
        "controllability_measures": dict(rig=m("rig"), angle=0.1, second=0.2),
        "lqr": dict(model=m("model"), Q=[1.0, 1.0, 1.0, 1.0], R=3.0),
        "Observer": {k: getattr(m("observer"), k) for k in ("E", "H", "T", "K", "L1", "L2")},
        "Observer.residuals": dict(model=m("model")),
        "Observer.noise_gain": dict(F=m("design").F[:, :4]),
        "ObserverFamily": None,
        "ObserverFamily.split": dict(alpha=m("family").basis[0]),
        "ObserverFamily.member": dict(coefficients=[1.0, 0.5]),
        "ObserverFamily.project": dict(T=m("observer").T, K=m("observer").K),
        "ObserverFamily.distance": dict(T=m("observer").T, K=m("observer").K),
        "ObserverFamily.condition": dict(coefficients=[1.0, 0.5]),
        "ObserverFamily.best": {},
        "observer": dict(model=m("model"), E=0.9, T=m("observer").T, K=m("observer").K),
        "observer_family": dict(model=m("model"), E=0.9),
        "luenberger": dict(model=m("model"), E=0.9, K=[[1.0, 2.0, 3.0]]),
        "Controller": dict(
            F=m("controller").F, observer=m("observer"), dt=0.01, tracked=(1,), u_max=(10.0,)
        ),
        "Controller.start": dict(x0=np.zeros(4)),
        "Controller.estimate": dict(state=m("state"), y=y),
        "Controller.control": dict(state=m("state"), y=y),
        "Controller.update": dict(state=m("state"), y=y, u=u, y_ref=0.1),
        "Controller.step": dict(state=m("state"), y=y, y_ref=0.1),
        "ControllerState": None,
        "controller": dict(
            F=m("design").F, observer=m("observer"), dt=0.01, tracked=1, kp=None, u_max=(10.0,)
        ),
        "frequency_response": dict(system=m("model"), omega=[1.0, 2.0]),
        "frequency_grid": dict(dt=0.01, points=100, lowest=0.01),
        "open_loop": dict(controller=m("controller"), plant=m("model")),
        "broken_at": dict(loop=m("loop3"), index=0),
        "state_feedback_loop": dict(model=m("design").augmented, F=m("design").F),
        "closed_loop_eigenvalues": dict(loop=m("loop")),
        "loop_gain": dict(controller=m("controller"), plant=m("model"), omega=[1.0]),
        "return_differences": dict(controller=m("controller3"), plant=m("model3"), omega=[1.0]),
        "margins": dict(loop=m("loop"), points=200),
        "encirclements": dict(loop=m("loop")),
        "time_constant": dict(loop=m("loop")),
        "StructuredMargin": None,
        "structured_margin": dict(loop=m("loop3"), points=200),
        "Design": dict(
            rig=m("rig"), Q=m("design").Q, R=m("design").R, E=m("design").E, kp=None,
            coefficients=None, dt=0.01, tracked=1,
        ),
        "Design.changed": dict(
            rig=m("rig"), Q=m("design").Q, R=m("design").R, E=m("design").E, kp=None,
            coefficients=None, dt=0.01, tracked=1,
        ),
        "Design.loop": dict(index=0, filters=True),
        "with_torques": dict(plant=m("plant"), rig=m("rig")),
        "closed_loop": dict(design=m("design"), filters=True),
        "rms": dict(system=m("closed"), deviations=1.0),
        "peak_gain": dict(system=m("closed"), points=200),
        "published": dict(key="sec4.double.R"),
        "paper_design": dict(name="double", observer=1),
        "scoreboard": dict(keys=["sec4.double.R"]),
        "Imperfections": dict(
            filters=True, saturation=True, resolution=1e-3, voltage_resolution=0.1, delay=0.001,
            offset=0.001, noise=0.001, seed=1, hinge_friction=0.01, gear_friction=0.1, gap=0.01,
            contact_stiffness=1000.0, contact_damping=1.0, presliding=1e-3,
        ),
        "Imperfections.each": dict(name="gap", count=1),
        "Pulse": Pulse,
        "bench_imperfections": dict(rig=m("rig"), foreign=False),
        "bench_start": dict(rig=m("rig")),
        "Run": None,
        "simulate": [
            dict(
                sim, initial=(0.01, 0.0), reference=0.0, imperfections=pl.Imperfections(),
                disturbance=pl.Pulse(**Pulse), dt=0.01, inner_step=0.001,
            ),
            dict(sim, controller=Still(), reference=0.0, dt=0.01),
        ],
        "Runs": None,
        "simulate_many": dict(
            sim, cases=[dict(initial=(0.01, 0.0))], progress=False, workers=1, reference=0.0,
            dt=0.01,
        ),
        "to_c": dict(controller=m("controller"), path="controller.c", single=False, name="mine"),
        "bench_run": dict(name="double", t_end=0.1),
        "signals": dict(run=m("run")),
        "bench_rig": dict(rig=m("rig"), foreign=False),
        "bench_ensemble": dict(
            name="double", count=1, spread=1e-3, seed=0, rig=m("rig"), initial=[0.01, 0.0],
            imperfections=pl.Imperfections(),
        ),
        "tick_hits": dict(name="double", runs=m("runs")),
        "tick_intervals": dict(name="double"),
        "changed": dict(name="double", part="gap 1", factor=0.5),
        "hits_without": dict(count=1),
        "exponents": dict(name="double", count=1, by=1.5),
        "limit_cycles": dict(
            design=m("design"), imperfections=pl.bench_imperfections(m("rig")), between=(1.0, 2.0),
            rig=m("rig"),
        ),
        "before_after": dict(ensembles={"now": {"double": m("runs"), "triple": m("runs3")}}),
        "ablation": dict(table={"the bench": {"15a min": 1.0}, "gap 1": {"15a min": 0.0}}),
        "what_sets_what": dict(table={"gap 1": {"voltage 1": 1.0}}),
        "pushed": dict(table={"one": pl.tick_hits("triple", m("runs3"))}),
        "cycles_figure": dict(predicted={"both": m("cycles")}, seen={"both": m("runs3")}),
        "unknown_input_observer": dict(model=m("model"), noise=[0.01, 0.01, 0.1]),
        "step_times": dict(controller=m("controller"), repeat=3),
        "largest_pulses": dict(
            rig=m("rig"), controller=m("controller"), lengths=[0.1], imperfections=None,
            initial=None, levers=[[0.0, 1.0]], start=0.1, recovery=0.5, accuracy=0.5,
        ),
        "force_levers": dict(rig=m("rig")),
        "figure": [
            dict(number=5),
            *(dict(number=k, design=m("design")) for k in (7, 8)),
            *(dict(number=k, design=m("design3")) for k in (6, 10, 11, 12, 13, 14)),
            dict(number=2, design=m("rig"), angles=[0.1, 0.1]),
            dict(number=6, design=m("design3"), kps=[0.0, 10.0]),
            dict(number=8, design=m("design"), other=m("design")),
 dict(number=3, design=m("triple")),
            *(dict(number=k, design=m("run3")) for k in (15, 16)), dict(number=17, design=m("run")),
        ],
        "show": dict(fig=pl.new_figure()),
        "save": dict(fig=pl.new_figure(), folder="pictures", name="one"),
        "styled": {},
        "look": dict(name="theta1"),
        "describe": dict(fig=pl.new_figure(), caption="A frame.", alt="Two axes."),
        "lines": dict(
            panels={"angle, rad": {"theta1": (t, t, {})}}, x_label="time, s", caption="A line.",
            alt="A line.", log="", width=9.0, height=3.4, sharey=False, frame=((0, 1), (0, 1)),
        ),
        "animation": dict(
            rig=m("rig"), t=t, angles=np.zeros((20, 2)), caption="A rest.", width=360, height=320,
            speed=1.0, title="Rest",
        ),
        "compare": dict(
            runs={"ideal": m("run")}, panel="a", window=(0.0, 0.1), frame=(-1.0, 1.0), own_axes=False
        ),
        "draw_traces": dict(
            ax=m("axes"), run=m("run"), panel="a", window=(0.0, 0.1), frame=(-1.0, 1.0)
        ),
        "pushes_figure": dict(maps={"ideal": m("pushes")}),
        "root_locus": dict(model=m("model3"), kps=np.linspace(0.0, 10.0, 5), kp=10.0),
        "transmission_figure": dict(designs={"paper": m("design")}, points=10),
        "gain_region_figure": dict(designs={"paper": m("design3")}, points=5, reach=10.0),
        "bar_study": dict(rig=m("rig"), inertias=[0.01, 0.1]),
        "bars": dict(study=m("study"), added=[0.0, 0.1], width=9.6, height=4.0),
        "biped": {},
        "strobe": dict(rig=m("rig"), t=t, angles=np.zeros((20, 2)), every=0.09, count=7),
        "modes": dict(rig=m("rig"), lean=0.4),
        "block_chains": dict(rows=[[("$-F$", "$u_r$")]], caption="A block.", alt="A block."),
        "series_map": {},
        "parameter_table": dict(name="double"),
        "bench_table": {},
        "bench_notes": {},
        "new_figure": dict(width=3.0, height=2.0, layout="constrained"),
        "check": dict(exercise="02.1", answer=(1.0,), rig=m("rig")),
        "Verdict": None,
        "skip_unanswered": None,
        "LiveRig": None,
        "live_rig": dict(design="double"),
        "my_rig": dict(who="Ada", base="double", spread=0.05),
        "contest": dict(make=lambda rig: Still(), rig=m("rig"), season=1, plant=m("rig")),
        "Score": None,
        "write_leaderboard": dict(path="board.json", name="Ada", score=m("score"), season=1),
        "doctor": {},
        "Slider": dict(
            name="k_p", label="k_p, V/rad", low=0.1, high=1.0, value=0.5, log=True, zero=False, step=0.1
        ),
        "Slider.checked": dict(value=0.5),
        "Slider.read": dict(text="0,5"),
        "Slider.spoken": dict(value=0.5),
        "Slider.value_at": dict(position=0.5),
        "Slider.position_of": dict(value=0.5),
        "Switch": dict(name="steep", label="steep", value=False),
        "Switch.checked": dict(value=True),
        "Choice": dict(name="way", label="way", options={"one": 1, "two": 2}, value=1),
        "Choice.checked": dict(value=1),
        "View": dict(figure=pl.new_figure(), update=lambda **v: "", moving=(), beside=None, idle=None),
        "Panel": dict(
            title="t", controls=[slider()], view=view(), legend=("A line.",), presets={"one": {"k_p": 1.0}},
            actions={}, continuous=True, first=("k_p",),
        ),
        "Panel.at": dict(k_p=0.5),
        "Panel.tell": dict(k_p=0.5),
        "Panel.act": dict(name="go"),
        "Panel.still": {},
        "Panel.close": {},
        "bench_panel": dict(name="double"),
        "kp_panel": {},
        "observer_panel": dict(name="double"),
        "triple_panel": {},
        "weights_panel": dict(name="double"),
        "bar_panel": dict(name="double", study=m("study")),
        "sampling_panel": {},
    }  # fmt: skip


def target(name):
    """The function, class or bound method that an entry of `GOOD` stands for."""
    head, _, method = name.partition(".")
    thing = getattr(pl, head)
    return getattr(receiver(head), method) if method else thing


@functools.cache
def receiver(name):
    """The object whose methods are called."""
    return {
        "EquationsOfMotion": lambda: made("motion"),
        "Observer": lambda: made("observer"),
        "ObserverFamily": lambda: made("family"),
        "Controller": lambda: made("controller"),
        "Design": lambda: made("design"),
        "Imperfections": pl.Imperfections,
        "Panel": lambda: made("panel"),
        "Slider": slider,
        "Switch": lambda: pl.Switch("steep", "steep"),
        "Choice": lambda: pl.Choice("way", "way", {"one": 1, "two": 2}, 1),
    }[name]()


def public():
    """Names of all public callables: functions, classes, and the methods of public classes."""
    for name in pl.__all__:
        thing = getattr(pl, name)
        if callable(thing):
            yield name
        if inspect.isclass(thing):
            yield from (
                f"{name}.{key}"
                for key, value in vars(thing).items()
                if isinstance(value, (FunctionType, staticmethod)) and not key.startswith("_")
            )


class TooLong(BaseException):
    """The call was stopped."""


@contextmanager
def stopped_after(seconds):
    """Stop what runs longer in processor time (so that a busy machine does not matter)."""
    if not hasattr(signal, "setitimer"):
        yield
        return

    def stop(*_):
        raise TooLong(f"stopped after {seconds} s")

    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


def call(function, arguments):
    """Call by name; the entry of a ``*`` parameter is spread behind those before it."""
    arguments, first = dict(arguments), []
    parameters = list(inspect.signature(function).parameters.values())
    names = [p.name for p in parameters]
    spread = [p.name for p in parameters if p.kind is inspect.Parameter.VAR_POSITIONAL]
    if spread:
        before = names[: names.index(spread[0])]
        first = [*(arguments.pop(name) for name in before), *arguments.pop(spread[0])]
    return function(*first, **arguments)


def fault(function, arguments, changed, value, meaningless=False):
    """What is wrong with the call, or None."""
    try:
        with warnings.catch_warnings(), stopped_after(4):
            warnings.simplefilter("ignore")  # what a dependency says of itself is not ours
            warnings.filterwarnings("error", module="pendlab")
            answer = call(function, {**arguments, changed: value})
    except (ValueError, TypeError) as problem:
        # A control goes by its own name: that of the argument which it stands for.
        control = getattr(getattr(function, "__self__", None), "name", changed)
        return _fault_of(problem, {*arguments, changed, str(control)})
    except TooLong as problem:
        return f"HANG {problem}"
    except Exception as problem:
        return f"FOREIGN {type(problem).__name__}: {problem}"
    refused = isinstance(answer, pl.Verdict) and not answer  # a check answers with a hint
    return "SILENT" if meaningless and not refused else None


def _fault_of(problem, names):
    """What is wrong with a ValueError or TypeError: not ours, no name, no sentence."""
    frames = problem.__traceback__
    while frames.tb_next:
        frames = frames.tb_next
    path, line = frames.tb_frame.f_code.co_filename, frames.tb_lineno
    ours = PACKAGE in Path(path).parents and linecache.getline(path, line).strip().startswith(
        "raise"
    )
    text = str(problem)
    if not ours:
        return f"FOREIGN {type(problem).__name__}: {text} [{Path(path).name}:{line}]"
    head = text.partition(":")[0]
    if not any(name in head for name in names):
        return f"UNNAMED {type(problem).__name__}: {text} [{Path(path).name}:{line}]"
    if not text.endswith("."):
        return f"NOSENTENCE {type(problem).__name__}: {text} [{Path(path).name}:{line}]"
    return None


@pytest.fixture(autouse=True)
def guarded(tmp_path, monkeypatch):
    """Files land in a folder of the test's own; a call that nothing can stop ends the process."""
    monkeypatch.chdir(tmp_path)
    faulthandler.dump_traceback_later(120, exit=True)
    yield
    faulthandler.cancel_dump_traceback_later()


def test_every_public_callable_has_a_good_call():
    assert set(public()) == set(good())


CALLS = {
    name: calls if isinstance(calls, list) else [calls]
    for name, calls in good().items()
    if calls is not None
}


@pytest.mark.parametrize("name", CALLS)
def test_nonsense_in_each_argument_gives_an_answer_or_a_sentence(name):
    function, faults = target(name), []
    for arguments in CALLS[name]:
        call(function, arguments)
        for changed, value in arguments.items():
            for kind, wrong in nonsense(value).items():
                wrong = (wrong,) if changed == "answer" else wrong
                what = fault(function, arguments, changed, wrong, kind in MEANINGLESS)
                if what:
                    faults.append(f"{changed} = {kind}: {what}")
    assert not faults, "\n".join([f"{len(faults)} faults of pl.{name}", *faults])
