"""The simulator's compiled code: `kernel.py` with the equations of motion generated in front of it.

The text for each number of links and motors is kept in a cache folder of the user, so that numba's
compiled result is found again in the next session. Without numba the same text runs as Python.
"""

import hashlib
import os
import sys
import types
import warnings
from functools import lru_cache, partial
from importlib.metadata import version
from pathlib import Path

from .cache import keep

HERE = Path(__file__).parent
COMPILED = "accelerate derivative drag mean_load advance read send hold record run".split()
INLINED = ("accelerate", "derivative")  # where the time goes: worth a factor of two


@lru_cache
def load_kernel(n_links, n_motors):
    """Module with the functions of `kernel.py` for this pendulum, compiled where numba is present.

    Its `COMPILED` is True where numba compiled it; arrays then, lists otherwise.
    """
    names = ("../lagrange", "equations", "kernel", "tuples", "generated")
    sources = [(HERE / f"{name}.py").read_text(encoding="utf-8") for name in names]
    key = "\n".join([*sources, version("sympy"), str((n_links, n_motors))])
    name = f"kernel_{n_links}_{n_motors}_{hashlib.sha256(key.encode()).hexdigest()[:16]}"
    path = keep(name, partial(kernel_text, n_links, n_motors))
    text = kernel_text(n_links, n_motors) if path is None else path.read_text(encoding="utf-8")
    module = types.ModuleType(f"pendlab_{name}")
    sys.modules[module.__name__] = module  # numba's cache looks the module up by its name
    # Not by import, which would keep one more compiled file that can be damaged.
    exec(compile(text, str(path or f"<{name}>"), "exec"), module.__dict__)
    module.COMPILED = _compile(module, cache=path is not None)
    return module


def kernel_text(n_links, n_motors):
    """The whole source: sizes, generated equations, loop."""
    from .equations import acceleration_source

    equations, count = acceleration_source(n_links, n_motors)
    head = "from math import cos, exp, floor, sin\n"
    sizes = f"N, M, CONSTANTS = {n_links}, {n_motors}, {count}\n\n"
    loop = (HERE / "kernel.py").read_text(encoding="utf-8")
    return "\n".join([head, sizes, equations, "", loop])


def _compile(module, cache):
    """Replace the module's functions by compiled ones; False where numba is absent."""
    if os.environ.get("PENDLAB_NUMBA", "1") == "0":
        _say_once("PENDLAB_NUMBA=0")
        return False
    try:
        from numba import config

        from .compiled import compiled
    except ImportError as problem:
        _say_once(str(problem))
        return False
    if config.DISABLE_JIT:
        _say_once("NUMBA_DISABLE_JIT is set")
        return False
    for name in COMPILED:
        setattr(module, name, compiled(getattr(module, name), cache, name in INLINED))
    return True


@lru_cache
def _say_once(reason):
    message = f"pendlab simulates without numba ({reason}): same results, more slowly."
    warnings.warn(message, stacklevel=2)
