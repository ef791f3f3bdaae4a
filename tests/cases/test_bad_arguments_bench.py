"""Nonsense in every argument of the simulator, and from the functions and controllers it calls."""

import dataclasses

import numpy as np
import pytest
from test_bad_arguments import NONSENSE, ours

import pendlab as pl

DESIGN = pl.paper_design("double")
RIG = DESIGN.rig
EVERYTHING = dict(gap=0.02, gear_friction=0.1, hinge_friction=0.01, start_torque=0.01, noise=1e-4)


class Answers:
    """A controller, or a function of time, that answers as told from the third sample on."""

    def __init__(self, u=0.0, state=None, estimate=None, **own):
        self.u, self.state, self.count = u, state, 0
        if estimate is not None:
            self.estimate = lambda state, y: estimate
        vars(self).update(own)

    def step(self, state, y, y_ref):
        return self.u, self.state

    def __call__(self, t):
        return self.u if t > 0.015 else [0.0, 0.0]


def simulate(**changes):
    return pl.simulate(**dict(rig=RIG, controller=DESIGN.controller, t_end=0.05) | changes)


def with_own_controller(**changes):
    return simulate(**dict(controller=Answers()) | changes)


def with_imperfections(**entries):
    return simulate(imperfections=pl.Imperfections(**EVERYTHING | entries))


def with_pulse(**entries):
    pulse = pl.Pulse(**dict(link=1, start=0.0, length=0.02, height=0.1) | entries)
    return simulate(disturbance=pulse)


def with_filters(**entries):
    rig = dataclasses.replace(RIG, filters=pl.Filters(**entries))
    return simulate(rig=rig, imperfections=pl.Imperfections(filters=True))


def many(**changes):
    good = dict(rig=RIG, controller=DESIGN.controller, t_end=0.02, cases=[{}], progress=False)
    return pl.simulate_many(**good | changes)


def answering(**answer):
    return simulate(controller=Answers(**answer))


def torques(function):
    return simulate(disturbance=Answers(function))


def references(function):
    return simulate(reference=Answers(function))


ARGUMENTS = "rig controller t_end initial reference imperfections disturbance dt inner_step".split()
CALLS = {
    simulate: ARGUMENTS,
    with_own_controller: ARGUMENTS,
    with_imperfections: [field.name for field in dataclasses.fields(pl.Imperfections)],
    with_pulse: ["link", "start", "length", "height"],
    many: ["rig", "controller", "t_end", "cases", "progress", "workers", "executor", "unknown"],
    answering: ["u", "estimate", "dt"],
    torques: ["function"],
    references: ["function"],
    pl.bench_imperfections: ["rig"],
    pl.bench_start: ["rig"],
}


@pytest.mark.parametrize("call", CALLS, ids=lambda call: call.__name__)
def test_nonsense_gets_a_sentence(call):
    wrong, named = [], 0
    for argument in CALLS[call]:
        for kind, nonsense in NONSENSE.items():
            try:
                call(**{argument: nonsense})
            except (ValueError, TypeError) as problem:
                named += 1
                if not ours(problem, str(problem)):
                    wrong.append(f"{argument} = {kind}: {str(problem)[:150]}")
            except BaseException as problem:
                wrong.append(f"{argument} = {kind}: {type(problem).__name__}: {problem}")
    assert not wrong, "\n" + "\n".join(wrong)
    assert named > len(NONSENSE) / 2  # most of it is not taken


@pytest.mark.parametrize("nonsense", [1j, "0.1", [1, 2, 3], [[0.0], [0.0, 0.0]], True, np.nan])
def test_what_answers_nonsense_is_named_with_its_time(nonsense):
    with pytest.raises(ValueError, match=r"controller: step at t = 0 s "):
        answering(u=nonsense)
    for call, name in ((torques, "disturbance"), (references, "reference")):
        with pytest.raises((ValueError, TypeError), match=rf"{name} at t = 0\.02 s: "):
            call(function=nonsense)


@pytest.mark.parametrize("name", ["reference", "disturbance"])
def test_a_function_that_fails_is_named_with_its_time(name):
    def breaks(t):
        return [0.0, 0.0 / (0.03 - t if t > 0.025 else 1.0) if t != 0.03 else {}["torque"]]

    with pytest.raises(ValueError, match=rf"{name}: the function failed at t = 0\.03 s \(KeyError"):
        simulate(**{name: breaks})


def test_a_controller_is_an_object_and_cases_are_a_list():
    with pytest.raises(TypeError, match=r"controller: expected an object, found the class Answers"):
        simulate(controller=Answers)
    with pytest.raises(TypeError, match="cases: expected dicts"):
        many(cases=dict(initial=(0.1, 0.0)))


def test_the_papers_gearboxes_are_not_given_to_others_without_a_word():
    foreign = dataclasses.replace(RIG, motors=[dataclasses.replace(RIG.motors[0], ratio=50)])
    with pytest.raises(ValueError, match=r"rig: .* ratio of 236, found 50; .* foreign=True"):
        pl.bench_imperfections(foreign)
    assert pl.bench_imperfections(foreign, foreign=True) == pl.bench_imperfections(RIG)
    assert pl.bench_imperfections(pl.my_rig("Ada")) == pl.bench_imperfections(RIG)  # its gearboxes
    with pytest.raises(TypeError, match="foreign: expected True or False"):
        pl.bench_imperfections(RIG, foreign="yes")
