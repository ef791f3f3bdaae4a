"""The controller as a C99 file, for a microcontroller or a PC on the bench."""

from pathlib import Path
from string import Template

import numpy as np

from .._arguments import flag, found, instance
from ..bench import arguments
from ..controllers import Controller


def to_c(controller, path=None, single=False, name="pendulum"):
    """The text of a self-contained C99 source file with the arithmetic of `Controller.step`.

    It holds prototypes, a state struct, ``<name>_init``, ``<name>_step`` (and its halves
    ``_output`` and ``_update``), the limits, and no allocation. What `Controller.step` does not
    meet on a simulated bench: a reading that is no number gives u = 0 and leaves the state alone.

    Parameters
    ----------
    controller : Controller with n >= 1 observer states and at least one integrator
    path : where to write the file, or None
    single : floats instead of doubles
    name : prefix of everything in the file, a C identifier

    >>> print(pl.to_c(pl.paper_design("double").controller).splitlines()[0])
    /* Sampled controller for an inverted pendulum, sampling time 0.01 s.
    """
    instance("controller", controller, Controller, "design.controller")
    if not controller.tracked:
        raise ValueError(
            "controller: expected at least one integrator, found none; C has no empty arrays."
        )
    if not (isinstance(name, str) and name.isidentifier() and name.isascii()):
        raise ValueError(f"name: expected a C identifier such as 'pendulum', {found(name)}.")
    flag("single", single)
    file = None if path is None else arguments.path("path", path)
    o = controller.observer
    template = (Path(__file__).parent / "controller.c").read_text(encoding="utf-8")
    matrices = dict(E=o.E, H=o.H, K=o.K, L1=o.L1, L2=o.L2, T=o.T, F=controller.F)
    if controller.u_max is None:
        kept = [line for line in template.splitlines(keepends=True) if "u_max" not in line]
        template = "".join(kept)
    else:
        matrices["u_max"] = np.array(controller.u_max)
    source = Template(template).substitute(
        real="float" if single else "double",
        dt=_literal(controller.dt, single),
        angles=o.K.shape[1] - 1,
        states=o.T.shape[1],
        outputs=o.K.shape[1],
        motors=len(controller.F),
        observer=len(o.E),
        tracked=len(controller.tracked),
        indices=", ".join(map(str, controller.tracked)),
        matrices="\n".join(_table(key, values, single) for key, values in matrices.items()),
    )
    source = source.replace("PENDULUM_", f"{name.upper()}_").replace("pendulum_", f"{name}_")
    if file is not None:
        try:
            file.write_text(source, encoding="ascii")
        except (OSError, ValueError) as problem:
            raise ValueError(f"path: {str(file)!r} cannot be written ({problem}).") from None
    return source


def _table(label, values, single):
    """A constant array of one or two dimensions."""
    size = "".join(f"[{count}]" for count in values.shape)
    rows = [", ".join(_literal(value, single) for value in row) for row in np.atleast_2d(values)]
    if values.ndim == 1:
        body = f"{{{rows[0]}}}"
    else:
        body = "{\n" + ",\n".join(f"    {{{row}}}" for row in rows) + "\n}"
    return f"static const pendulum_real pendulum_{label}{size} = {body};"


def _literal(value, single):
    """A C constant that reads back as the same number (as the nearest float where single)."""
    if np.isinf(value):  # an amplifier without limit: larger than any voltage
        text = "1e30" if value > 0 else "-1e30"
    else:
        if single and abs(value) > np.finfo(np.float32).max:
            raise ValueError(f"single: {value:g} is too large for a float; use doubles.")
        text = str(np.float32(value)) if single else repr(float(value))
    return text + "f" if single else text
