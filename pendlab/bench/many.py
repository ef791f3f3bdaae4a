"""Many simulations at once: disturbance maps, basins, spreads of parameters."""

import os
import sys
from collections.abc import Iterable, Sequence
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from dataclasses import dataclass

from .._arguments import found, whole
from .simulation import simulate


@dataclass(frozen=True)
class Runs(Sequence):
    """Results in the order of the cases: a `Run`, or None where stopped before its turn.

    Attributes
    ----------
    runs : tuple of Run or None
    stopped : True where the user interrupted
    """

    runs: tuple
    stopped: bool = False

    def __len__(self):
        return len(self.runs)

    def __getitem__(self, index):
        return self.runs[index]

    @property
    def done(self):
        """How many of the cases were simulated."""
        return sum(run is not None for run in self.runs)


def simulate_many(rig, controller, t_end, cases, *, progress=None, workers=None, **common):
    """`simulate` for each of many cases, on all cores; equal to a loop of `simulate`, in order.

    Parameters
    ----------
    rig, controller, t_end : as for `simulate`, for the cases that do not name their own
    cases : dicts of arguments of `simulate`, such as ``dict(initial=(0.1, 0))``
    progress : function of (done, all), called in this thread, or True for a bar on stderr, or
        False; by default a bar where stderr is a terminal
    workers : number of threads; default one per core. The compiled loop runs beside others; a
        controller in Python takes turns
    common : arguments of `simulate` for all cases

    Returns
    -------
    Runs : interrupting (Ctrl-C, or the notebook's stop button) returns what is done, marked
    """
    jobs = []
    if not isinstance(cases, Iterable):
        raise TypeError(f"cases: expected dicts of arguments of pl.simulate, {found(cases)}.")
    for k, case in enumerate(cases):
        if not isinstance(case, dict):
            raise TypeError(
                f"cases[{k}]: expected a dict of arguments of pl.simulate, {found(case)}."
            )
        jobs.append(dict(rig=rig, controller=controller, t_end=t_end) | common | case)
    show = _progress(progress)
    results, stopped = [None] * len(jobs), False
    if jobs:
        show(0, len(jobs))
    workers = whole("workers", workers, least=1) if workers is not None else os.cpu_count() or 1
    pool = ThreadPoolExecutor(workers)
    try:
        pending = {pool.submit(simulate, **job): k for k, job in enumerate(jobs)}
        while pending:
            ready, _ = wait(pending, timeout=0.5, return_when=FIRST_COMPLETED)
            for future in ready:
                k = pending.pop(future)
                try:
                    results[k] = future.result()
                except (ValueError, TypeError) as problem:
                    raise type(problem)(f"cases[{k}]: {problem}") from problem
            if ready:
                show(len(jobs) - len(pending), len(jobs))
    except KeyboardInterrupt:
        stopped = True
    finally:
        pool.shutdown(wait=True, cancel_futures=True)
    if stopped:  # what was under way when the interrupt came is finished by now
        for future, k in pending.items():
            if not future.cancelled() and future.exception() is None:
                results[k] = future.result()
    return Runs(tuple(results), stopped)


def _progress(progress):
    if callable(progress):
        return progress
    if progress is None:
        progress = sys.stderr is not None and sys.stderr.isatty()
    return _bar if progress else lambda done, total: None


def _bar(done, total):
    filled = 40 * done // total
    end = "\n" if done == total else ""
    sys.stderr.write(f"\r[{'#' * filled}{'.' * (40 - filled)}] {done}/{total}{end}")
    sys.stderr.flush()
