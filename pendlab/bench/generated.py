"""The simulator's compiled code: `kernel.py` with the equations of motion generated in front of it.

The text for each number of links and motors is kept in a cache folder of the user, so that numba's
compiled result is found again in the next session. Without numba the same text runs as Python.
"""

import hashlib
import importlib.util
import os
import sys
import tempfile
import types
import warnings
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path

HERE = Path(__file__).parent
COMPILED = (
    "accelerate",
    "derivative",
    "drag",
    "mean_load",
    "advance",
    "read",
    "send",
    "hold",
    "record",
    "run",
)
INLINED = ("accelerate", "derivative")  # where the time goes: worth a factor of two


@lru_cache
def load_kernel(n_links, n_motors):
    """Module with the functions of `kernel.py` for this pendulum, compiled where numba is present.

    Its `COMPILED` is True where numba compiled it; arrays then, lists otherwise.
    """
    paths = (
        HERE.parent / "lagrange.py",
        *(HERE / f"{name}.py" for name in ("equations", "kernel", "tuples", "generated")),
    )
    sources = [path.read_text(encoding="utf-8") for path in paths]
    key = "\n".join([*sources, version("sympy"), str((n_links, n_motors))])
    name = f"pendulum_{n_links}_{n_motors}_{hashlib.sha256(key.encode()).hexdigest()[:16]}"
    path = _cached(name, lambda: kernel_text(n_links, n_motors))
    if path is None:
        module = types.ModuleType(name)
        exec(kernel_text(n_links, n_motors), module.__dict__)
    else:
        specification = importlib.util.spec_from_file_location(f"pendlab_{name}", path)
        module = importlib.util.module_from_spec(specification)
        sys.modules[specification.name] = module  # numba's cache looks the module up by its name
        specification.loader.exec_module(module)
    module.COMPILED = _compile(module, cache=path is not None)
    return module


def kernel_text(n_links, n_motors):
    """The whole source: sizes, generated equations, loop."""
    from .equations import acceleration_source

    equations, count = acceleration_source(n_links, n_motors)
    return "\n".join(
        [
            "from math import cos, exp, floor, sin",
            "",
            f"N, M, CONSTANTS = {n_links}, {n_motors}, {count}",
            "",
            "",
            equations,
            "",
            (HERE / "kernel.py").read_text(encoding="utf-8"),
        ]
    )


def cache_folders():
    """Where generated code may be kept, best first; PENDLAB_CACHE names another folder.

    No shared temporary folder: what another user could write must not be run.
    """
    if "PENDLAB_CACHE" in os.environ:
        yield Path(os.environ["PENDLAB_CACHE"])
    base = os.environ.get("LOCALAPPDATA") or os.environ.get("XDG_CACHE_HOME")
    try:
        yield (Path(base) if base else Path.home() / ".cache") / "pendlab"
    except RuntimeError:  # no home folder
        pass


def _cached(name, write):
    """Path of the module `name`, written once; None where no folder can be written."""
    for folder in cache_folders():
        path = folder / f"{name}.py"
        try:
            if not path.exists():
                folder.mkdir(parents=True, exist_ok=True)
                handle, draft = tempfile.mkstemp(dir=folder, suffix=".draft")
                with os.fdopen(handle, "w", encoding="utf-8") as file:
                    file.write(write())
                os.replace(draft, path)  # two sessions at once never see half a file
            return path
        except OSError:
            continue
    return None


def _compile(module, cache):
    """Replace the module's functions by compiled ones; False where numba is absent."""
    if os.environ.get("PENDLAB_NUMBA", "1") == "0":
        _say_once("PENDLAB_NUMBA=0")
        return False
    try:
        from numba import config, njit
    except ImportError as problem:
        _say_once(str(problem))
        return False
    if config.DISABLE_JIT:
        _say_once("NUMBA_DISABLE_JIT is set")
        return False
    for name in COMPILED:
        function = getattr(module, name)
        options = dict(nogil=True, error_model="numpy", forceinline=name in INLINED)
        try:
            compiled = njit(cache=cache, **options)(function)
        except RuntimeError:  # numba finds no folder for its cache
            compiled = njit(**options)(function)
        setattr(module, name, compiled)
    return True


@lru_cache
def _say_once(reason):
    warnings.warn(
        f"pendlab simulates without numba ({reason}): same results, more slowly.",
        stacklevel=2,
    )
