"""A pendulum of one's own: slightly different from the paper's, always stabilisable."""

import hashlib
import unicodedata
from dataclasses import replace

import numpy as np

from .._arguments import found, number
from ..parameters import load


def my_rig(who, base="double", spread=0.06):
    """The pendulum that belongs to a name or number, the same on every machine.

    Lengths, masses, inertias, centres of mass, friction and motors differ from those of `base` by
    up to `spread`, each by its own factor; filters and limits stay. A pendulum with a driven upper
    hinge stays stabilisable, and with the default spread the paper's weights balance all of the
    many that the tests try, filters included.

    Parameters
    ----------
    who : name or number, such as a student's
    base : "double", "triple" or the path of a rig file
    spread : largest relative change, from 0 to 0.2

    Returns
    -------
    Pendulum

    >>> my_rig("Ada") == my_rig(" ada ")
    True
    """
    if isinstance(who, bool) or not isinstance(who, (str, int, np.integer)):
        raise TypeError(f"who: expected a name or a whole number, {found(who)}.")
    # The same letters may be written composed or decomposed; they are one name.
    who = unicodedata.normalize("NFC", str(who)).strip().lower()
    if not who:
        raise ValueError("who: expected a name or a number, found nothing; write your own.")
    number("spread", spread, least=0, most=0.2)
    try:
        rig = load(base)
    except (TypeError, ValueError) as problem:
        raise type(problem)(f"base: {problem}") from None
    digest = hashlib.sha256(f"{who} {base}".encode()).digest()
    fraction = fractions(int.from_bytes(digest[:16], "big"))

    def vary(part, *fields):
        factors = {f: 1 + spread * (2 * next(fraction) - 1) for f in fields}
        return replace(
            part, **{f: float(f"{getattr(part, f) * k:.4g}") for f, k in factors.items()}
        )

    return replace(
        rig,
        links=[vary(link, "length", "mass", "inertia", "com", "friction") for link in rig.links],
        motors=[vary(motor, "damping", "inertia", "gain") for motor in rig.motors],
        name=f"{rig.name} of {who}",
    )


def fractions(seed):
    """Numbers from 0 to below 1 that follow from `seed`, the same on every machine."""
    # PCG64's raw stream is fixed for all NumPy versions; 53 bits of it make a number in [0, 1).
    stream = np.random.PCG64(seed)
    while True:
        yield (int(stream.random_raw()) >> 11) / 2**53
