"""Every argument of every public core function replaced by nonsense: our sentence, and soon.

Nonsense may also be accepted where it makes sense (a list for an array); what it may not do is
raise anything but ValueError and TypeError, raise them without naming an argument, warn, or hang.
"""

import inspect
import signal
from importlib import import_module

import control
import numpy as np
import pytest

import pendlab as pl

CORE = "parameters lagrange models sampled gain observers controllers loop nyquist design".split()
DOUBLE, TRIPLE = pl.paper_design("double"), pl.paper_design("triple")
LINK = dict(length=0.5, mass=0.4, inertia=0.01, com=0.25, friction=0.02)
MOTOR = dict(damping=7.0, inertia=0.03, gain=2.0, ratio=200.0)
OBSERVER = {name: getattr(DOUBLE.observer, name) for name in ("E", "H", "T", "K", "L1", "L2")}

# A good call of each function; the test below sees to it that none is missing.
GOOD = {
    "Link": LINK,
    "Motor": MOTOR,
    "Filters": dict(input_hz=(6.0,), output_hz=(9.0, 9.0, 9.0)),
    "Pendulum": vars(DOUBLE.rig),
    "load": dict(name="double"),
    "rigs": {},
    "derive": dict(n_links=2, n_motors=1),
    "linearize": dict(rig=DOUBLE.rig),
    "nonlinear": dict(rig=DOUBLE.rig),
    "energy": dict(rig=DOUBLE.rig, x=np.zeros(4)),
    "with_filters": dict(plant=DOUBLE.plant, filters=DOUBLE.rig.filters),
    "sample": dict(plant=DOUBLE.plant, dt=0.01, delay=0.001),
    "align": dict(model=TRIPLE.model, kp=10.0),
    "add_integrator": dict(model=DOUBLE.model, output=1),
    "lqr": dict(model=DOUBLE.augmented, Q=DOUBLE.Q, R=DOUBLE.R),
    "Observer": OBSERVER,
    "observer": dict(model=DOUBLE.model, **{n: OBSERVER[n] for n in "ETK"}),
    "observer_family": dict(model=DOUBLE.model, E=0.9),
    "luenberger": dict(model=DOUBLE.model, E=0.9, K=[[1.0, 2.0, 3.0]]),
    "Controller": dict(F=DOUBLE.F, observer=DOUBLE.observer, dt=0.01, tracked=(1,), u_max=(9.0,)),
    "controller": dict(F=TRIPLE.F, observer=TRIPLE.observer, dt=0.01, tracked=1, kp=10.0),
    "frequency_response": dict(system=DOUBLE.model, omega=[1.0, 2.0]),
    "frequency_grid": dict(dt=0.01, points=100, lowest=0.1),
    "open_loop": dict(controller=DOUBLE.controller, plant=DOUBLE.model),
    "broken_at": dict(loop=TRIPLE.nominal_loop, index=0),
    "state_feedback_loop": dict(model=DOUBLE.augmented, F=DOUBLE.F),
    "closed_loop_eigenvalues": dict(loop=DOUBLE.nominal_loop),
    "loop_gain": dict(controller=DOUBLE.controller, plant=DOUBLE.model, omega=[1.0]),
    "return_differences": dict(controller=TRIPLE.controller, plant=TRIPLE.model, omega=[1.0]),
    "time_constant": dict(loop=DOUBLE.nominal_loop),
    "margins": dict(loop=DOUBLE.nominal_loop, points=200),
    "encirclements": dict(loop=DOUBLE.nominal_loop),
    "Design.loop": dict(index=0, filters=True),
    "Controller.start": dict(x0=np.zeros(4)),
    "Controller.step": dict(state=DOUBLE.controller.start(), y=np.zeros(3), y_ref=0.1),
    "ObserverFamily.member": dict(coefficients=[1.0, 2.0]),
    "ObserverFamily.project": dict(T=OBSERVER["T"], K=OBSERVER["K"]),
}
BESIDE_THE_CORE = {"time_constant"}  # tried here with its kind
# Results, and what is built by the calls above.
NOT_CALLED = {"EquationsOfMotion", "ObserverFamily", "ControllerState", "Design"}
NONSENSE = {
    "None": None,
    "text": "nonsense",
    "empty text": "",
    "True": True,
    "nan": np.nan,
    "inf": np.inf,
    "minus": -3,
    "zero": 0,
    "huge": 1e200,
    "tiny": 1e-200,
    "huge whole": 10**400,
    "complex": 1 + 2j,
    "complex array": np.ones(3) * 1j,
    "bytes": b"abc",
    "empty": [],
    "ragged": [[1, 2], [3]],
    "array of text": np.array(["a", "b"]),
    "nan array": np.full((2, 2), np.nan),
    "cube": np.zeros((2, 2, 2)),
    "many": np.zeros(77),
    "dict": {},
    "set": {1.5},
    "object": object(),
    "function": len,
    "rig": DOUBLE.rig,
    "continuous": DOUBLE.plant,
    "sampled": TRIPLE.model,
    "loop of two": TRIPLE.nominal_loop,
    "static": control.ss([], [], [], [[1.0]], 0.01),
    "tf": control.tf([1], [1, 1]),
    "unknown dt": control.ss([[0.5]], [[1.0]], [[1.0]], 0, True),
    "nan model": control.ss([[np.nan]], [[1.0]], [[1.0]], 0, 0.01),
    "huge model": control.ss([[1e300, 1], [1, 1e300]], [[1e300], [1]], np.eye(2), 0, 0.01),
    "huge continuous": control.ss([[1e300, 1], [1, 1e300]], [[1e300], [1]], np.eye(2), 0),
    "huge loop": control.ss([[0.5, 1e200], [1e200, 1]], [[1e200], [1]], [[1e200, 1]], 0, 0.01),
}


def function(name):
    if name.startswith("Design."):
        return getattr(DOUBLE, name.split(".")[1])
    if name.startswith("Controller."):
        return getattr(DOUBLE.controller, name.split(".")[1])
    if name.startswith("ObserverFamily."):
        return getattr(DOUBLE.family, name.split(".")[1])
    return getattr(pl, name)


def test_every_public_name_of_the_core_is_tried():
    names = {name for name, home in pl._HOME.items() if home in CORE}
    assert names == {name for name in GOOD if "." not in name} - BESIDE_THE_CORE | NOT_CALLED


@pytest.mark.parametrize("name", GOOD)
def test_good_calls_work(name):
    function(name)(**GOOD[name])


def too_slow(*_):
    raise AssertionError("not answered within five seconds")


@pytest.mark.parametrize("name", [name for name in GOOD if GOOD[name]])
def test_nonsense_gets_a_sentence(name):
    call, good, wrong = function(name), GOOD[name], []
    previous = signal.signal(signal.SIGALRM, too_slow) if hasattr(signal, "SIGALRM") else None
    for argument, (kind, nonsense) in [(a, item) for a in good for item in NONSENSE.items()]:
        if previous is not None:
            signal.alarm(5)
        try:
            call(**good | {argument: nonsense})
        except (ValueError, TypeError) as problem:
            text = str(problem)
            if type(problem) not in (ValueError, TypeError) or not ours(problem, text):
                wrong.append(f"{argument} = {kind}: {type(problem).__name__}: {text[:150]}")
        except BaseException as problem:
            wrong.append(f"{argument} = {kind}: {type(problem).__name__}: {str(problem)[:150]}")
        finally:
            if previous is not None:
                signal.alarm(0)
    assert not wrong, "\n" + "\n".join(wrong)


def ours(problem, text):
    """Raised in pendlab itself, and a sentence that names an argument first."""
    frame = problem.__traceback__
    while frame.tb_next:
        frame = frame.tb_next
    return (
        ": " in text
        and text.endswith((".", "?"))
        and "pendlab" in frame.tb_frame.f_code.co_filename
    )


@pytest.mark.parametrize("module", CORE)
def test_no_long_lists_of_arguments(module):
    """At most nine parameters, and none beyond the fifth by position only (fields excepted)."""
    for name, value in vars(import_module(f"pendlab.{module}")).items():
        if inspect.isfunction(value) and value.__module__ == f"pendlab.{module}":
            parameters = inspect.signature(value).parameters.values()
            assert len(parameters) <= 9, name
            by_place = [p for p in parameters if p.kind is not p.KEYWORD_ONLY]
            assert len(by_place) <= 5, name
