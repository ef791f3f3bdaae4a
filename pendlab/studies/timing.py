"""How long one control step takes on this machine, beside the 386 of the paper."""

import timeit
from dataclasses import dataclass
from functools import partial

import numpy as np

from .._arguments import instance, whole
from ..controllers import Controller


@dataclass(frozen=True)
class StepTimes:
    """Median seconds for steps 1 to 5 (until the voltage is known) and 1 to 6 (with the update)."""

    to_send: float
    to_end: float


def step_times(controller, repeat=500):
    """Time `Controller.control` and `Controller.step` in Python, A/D and D/A conversion left out.

    The paper's times for the double are 0.42 and 0.76 ms, for the triple 0.56 and 1.0 ms.

    Parameters
    ----------
    controller : Controller
    repeat : how many steps the medians are taken of, up to 100000

    >>> times = pl.step_times(pl.paper_design("double").controller, repeat=20)
    >>> min(times.to_send, times.to_end) > 0
    True
    """
    instance("controller", controller, Controller)
    whole("repeat", repeat, least=1, most=100_000)
    state, y = controller.start(), np.full(controller.observer.K.shape[1], 0.01)
    stages = [partial(stage, state, y) for stage in (controller.control, controller.step)]
    medians = [np.median(timeit.repeat(stage, number=1, repeat=repeat)) for stage in stages]
    return StepTimes(*map(float, medians))
