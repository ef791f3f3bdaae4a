"""Compile before the class comes."""

import os
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from .._arguments import found, instances
from ..parameters import Pendulum
from .cache import intact
from .generated import load_kernel
from .imperfections import Imperfections
from .plant import bench_tuples, fastest_rate, integration
from .tuples import Law, Memory, Rows


def warm(rigs, folder=None):
    """Compile what simulating these rigs needs, and keep it for all later sessions.

    Parameters
    ----------
    rigs : `Pendulum` or several; rigs with equal numbers of links and motors share their code
    folder : where to keep it; default the user's own cache. A folder filled so, readable by all, can
        be the PENDLAB_SEED of a class: each student's cache takes what it lacks from there

    Returns
    -------
    tuple of Path : the sources, beside which the compiled files lie; empty where nothing was kept

    Raises
    ------
    TypeError, ValueError : not rigs; a folder that cannot be written
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
    if not isinstance(folder, (str, os.PathLike)) or not str(folder).strip():
        raise TypeError(f"folder: expected the path of a folder, {found(folder)}.")
    target, before = Path(folder).expanduser().absolute(), os.environ.get("PENDLAB_CACHE")
    try:
        target.mkdir(parents=True, exist_ok=True)
        if not os.access(target, os.W_OK):
            raise PermissionError("no right to write")
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
    """Call each function of the kernel that a session calls, with nothing to do; the source's path."""
    n, m, ideal = rig.n_links, rig.n_motors, Imperfections()
    kernel = load_kernel(n, m)
    path = Path(kernel.constants.__code__.co_filename)
    if not kernel.COMPILED:
        return None
    fastest_rate.__wrapped__(rig, ideal)
    clock = integration(rig, ideal, 0.01, 1)
    loads = np.zeros((0, 4)), np.zeros((1, n))
    bench = bench_tuples(rig, ideal, np.zeros(2 * n), loads, clock, 1)
    square, flat = np.zeros((0, 0)), np.zeros(0)
    law = Law(*[square] * 6, np.zeros(0, dtype=np.int64), flat)
    none = bench.ports._replace(error=np.zeros((0, n + 1)))
    rows = Rows(*(np.zeros((0, k)) for k in (2 * n, n + 1, m, 2 * n)))
    kernel.run(bench.state, Memory(flat, flat, flat), law, square, clock, bench.plant, bench.held,
               none, bench.work, rows)  # fmt: skip
    kernel.read(bench.state.x, bench.ports.error[0], bench.ports.ad, bench.plant.w_out,
                np.zeros(n + 1))  # fmt: skip
    kernel.send(np.zeros(m), bench.state.sent, bench.ports.da, bench.plant.limit)
    kernel.hold(bench.state, 0.0, clock, bench.plant, bench.held[0], bench.work)
    return path if path.is_file() and intact(path) else None
