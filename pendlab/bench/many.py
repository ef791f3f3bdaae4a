"""Many simulations at once: disturbance maps, basins, spreads of parameters."""

import inspect
import os
import sys
from collections.abc import Iterable, Sequence
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from dataclasses import dataclass
from functools import partial
from pickle import PicklingError

from .._arguments import found, whole
from .simulation import simulate

ARGUMENTS = tuple(inspect.signature(simulate).parameters)


@dataclass(frozen=True)
class Runs(Sequence):
    """Results in the order of the cases: a `Run` each; None for those before which it `stopped`."""

    runs: tuple
    stopped: bool = False  # True where the user interrupted

    def __len__(self):
        return len(self.runs)

    def __getitem__(self, index):
        return self.runs[index]

    @property
    def done(self):
        """How many of the cases were simulated."""
        return sum(run is not None for run in self.runs)


def simulate_many(
    rig, controller, t_end, cases, *, progress=None, workers=None, executor=None, **common
):
    """`simulate` for each of many cases, on all cores or more; equal to a loop of `simulate`, in order.

    Parameters
    ----------
    rig, controller, t_end : as for `simulate`, for the cases that do not name their own
    cases : dicts of arguments of `simulate`, such as ``dict(initial=(0.1, 0))``
    progress : function of (done, all), called in this thread, or True for a bar on stderr, or
        False; by default a bar where stderr is a terminal
    workers : number of threads; default one per core. The compiled loop runs beside others; a
        controller in Python takes turns
    executor : any `concurrent.futures.Executor` instead of threads: a ProcessPoolExecutor, which lets
        controllers in Python run side by side, or that of a cluster. It stays open. Its processes must
        be able to import what the cases hold: controllers and functions from modules, no lambdas
    common : arguments of `simulate` for all cases

    Interrupting (Ctrl-C, or the notebook's stop button) returns the `Runs` that are done, marked.
    ValueError and TypeError of `simulate` come with the number of the case; an executor that fails
    is a ValueError too.

    >>> design = pl.paper_design("double")
    >>> cases = [dict(initial=(lean, 0)) for lean in (0.05, 0.1)]
    >>> runs = pl.simulate_many(design.rig, design.controller, 5.0, cases, progress=False)
    >>> [run.fell for run in runs]
    [False, True]
    """
    jobs = _jobs(cases, dict(rig=rig, controller=controller, t_end=t_end) | common)
    show = _progress(progress)
    if workers is not None:
        whole("workers", workers, least=1)
    if executor is not None and not callable(getattr(executor, "submit", None)):
        raise TypeError(
            f"executor: expected a concurrent.futures executor, {found(executor)}; leave it out "
            "for threads."
        )
    if jobs:
        show(0, len(jobs))
    pool = executor or ThreadPoolExecutor(workers or os.cpu_count() or 1)
    results, stopped = [None] * len(jobs), False
    pending = {}
    try:
        for k, job in enumerate(jobs):
            pending[_submitted(pool, k, job)] = k
        while pending:
            ready, _ = wait(pending, timeout=0.5, return_when=FIRST_COMPLETED)
            for future in ready:
                k = pending.pop(future)
                results[k] = _result(future, k)
            if ready:
                show(len(jobs) - len(pending), len(jobs))
    except KeyboardInterrupt:
        stopped = True
    finally:
        for future in pending:
            future.cancel()
        if executor is None:
            pool.shutdown(wait=True)
    if stopped:  # what was under way when the interrupt came is finished by now
        for future, k in pending.items():
            if future.done() and not future.cancelled() and future.exception() is None:
                results[k] = future.result()
    return Runs(tuple(results), stopped)


def _jobs(cases, common):
    if isinstance(cases, dict) or not isinstance(cases, Iterable):
        raise TypeError(f"cases: expected dicts of arguments of pl.simulate, {found(cases)}.")
    jobs = []
    for k, case in enumerate(cases):
        if not isinstance(case, dict):
            raise TypeError(
                f"cases[{k}]: expected a dict of arguments of pl.simulate, {found(case)}."
            )
        unknown = [name for name in common | case if name not in ARGUMENTS]
        if unknown:
            raise TypeError(
                f"cases[{k}]: expected arguments of pl.simulate ({', '.join(ARGUMENTS)}), "
                f"found {unknown[0]!r}."
            )
        jobs.append(common | case)
    return jobs


def _submitted(pool, k, job):
    try:
        return pool.submit(simulate, **job)
    except Exception as problem:
        raise ValueError(f"executor: took no case {k} ({_said(problem)}).") from problem


def _result(future, k):
    try:
        return future.result()
    except Exception as problem:
        kind, why = ValueError, f"cases[{k}]: {problem}"
        if _unsendable(problem):
            why = (
                f"cases[{k}]: cannot be sent to another process ({_said(problem)}); use functions "
                "and controllers that a module defines, or leave executor out."
            )
        elif isinstance(problem, TypeError):
            kind = TypeError
        elif not isinstance(problem, ValueError):  # a broken pool, a lost machine
            why = f"executor: failed at cases[{k}] ({_said(problem)})."
        raise kind(why) from problem


def _unsendable(problem):
    pickling = isinstance(problem, TypeError) and "pickle" in str(problem)
    return pickling or isinstance(problem, (PicklingError, AttributeError))


def _said(problem):
    return f"{type(problem).__name__}: {problem}"


def _progress(progress):
    if callable(progress):
        return partial(_told, progress)
    if progress is None:
        progress = sys.stderr is not None and sys.stderr.isatty()
    if not isinstance(progress, bool):
        raise TypeError(f"progress: expected a function, True or False, {found(progress)}.")
    return _bar if progress else _silence


def _told(progress, done, total):
    try:
        progress(done, total)
    except Exception as problem:
        raise ValueError(f"progress: failed at {done} of {total} ({_said(problem)}).") from problem


def _silence(done, total):
    pass


def _bar(done, total):
    filled = 40 * done // total
    end = "\n" if done == total else ""
    sys.stderr.write(f"\r[{'#' * filled}{'.' * (40 - filled)}] {done}/{total}{end}")
    sys.stderr.flush()
