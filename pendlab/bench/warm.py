"""Compile before the class comes."""

import os
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from .._arguments import instances
from ..controllers import Controller
from ..observers import Observer
from ..parameters import Pendulum
from . import arguments
from .cache import intact, make_writable
from .generated import load_kernel
from .imperfections import Imperfections
from .plant import fastest_rate
from .simulation import simulate


def warm(rigs, folder=None):
    """Compile what simulating these rigs needs, and keep it for all later sessions: its sources.

    Parameters
    ----------
    rigs : `Pendulum` or several; rigs with equal numbers of links and motors share their code
    folder : where to keep it; default the user's own cache. A folder filled so, readable by all, can
        be the PENDLAB_SEED of a class: each student's cache takes what it lacks from there

    The compiled files lie beside the sources; an empty tuple where nothing was kept.
    """
    by_size = {(r.n_links, r.n_motors): r for r in instances("rigs", rigs, Pendulum)}
    with _cache(folder):
        return tuple(path for rig in by_size.values() if (path := _compile(rig)) is not None)


@contextmanager
def _cache(folder):
    """PENDLAB_CACHE names `folder` for a while."""
    if folder is None:
        yield
        return
    target = arguments.path("folder", folder).expanduser().absolute()
    before = os.environ.get("PENDLAB_CACHE")
    try:
        make_writable(target)
    except OSError as problem:
        raise ValueError(f"folder: {target} cannot be written ({problem}).") from problem
    os.environ["PENDLAB_CACHE"] = str(target)
    load_kernel.cache_clear()
    try:
        yield
    finally:
        load_kernel.cache_clear()
        os.environ.pop("PENDLAB_CACHE")
        if before is not None:
            os.environ["PENDLAB_CACHE"] = before


def _compile(rig):
    """Call each function of the kernel that a session calls, by two short runs; the source's path."""
    n, m = rig.n_links, rig.n_motors
    kernel = load_kernel(n, m)
    if not kernel.COMPILED:
        return None
    path = Path(kernel.constants.__code__.co_filename)
    fastest_rate.__wrapped__(rig, Imperfections())
    sizes = (1, 1), (1, m), (1, 2 * n), (1, n + 1), (2 * n, n + 1), (2 * n, 1)
    idle = Controller(np.zeros((m, 2 * n + 1)), Observer(*map(np.zeros, sizes)), 0.01)
    simulate(rig, idle, 0.0)
    in_python = SimpleNamespace(step=lambda state, y, y_ref: (np.zeros(m), state))
    simulate(rig, in_python, 0.01)
    return path if intact(path) else None
