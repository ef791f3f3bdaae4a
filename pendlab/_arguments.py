"""Checks of arguments: one sentence that names the argument, what was expected and what came."""

import math
from numbers import Real

import numpy as np


def found(value):
    """What came, in a few words."""
    if isinstance(value, np.ndarray):
        return f"found an array of shape {value.shape}"
    text = repr(value)
    return f"found {text if len(text) <= 60 else text[:57] + '...'}"


def number(name, value, above=None, least=None, finite=True):
    """`value` as a float, or a sentence on why not."""
    if isinstance(value, bool) or not isinstance(value, (Real, np.number)):
        raise TypeError(f"{name}: expected a number, {found(value)}.")
    value = float(value)
    if math.isnan(value) or (finite and math.isinf(value)):
        raise ValueError(f"{name}: expected a finite number, {found(value)}.")
    if above is not None and not value > above:
        raise ValueError(f"{name}: expected a number above {above:g}, {found(value)}.")
    if least is not None and not value >= least:
        raise ValueError(f"{name}: expected a number of at least {least:g}, {found(value)}.")
    return value


def numbers(name, values, above=None, least=None, count=None, finite=True):
    """`values` as a tuple of floats; a single number counts as one."""
    if isinstance(values, (Real, np.number)) and not isinstance(values, bool):
        values = (values,)
    try:
        if isinstance(values, str):  # would count as a list of letters
            raise TypeError
        items = list(values)
    except TypeError:
        raise TypeError(f"{name}: expected numbers, {found(values)}.") from None
    if count is not None and len(items) != count:
        raise ValueError(f"{name}: expected {count} numbers, found {len(items)}.")
    return tuple(
        number(f"{name}[{i}]", item, above=above, least=least, finite=finite)
        for i, item in enumerate(items)
    )


def array(name, value, shape=None, finite=True):
    """`value` as a float array; None in `shape` stands for any size."""
    try:
        result = np.array(value)
        # NumPy would turn these into numbers without a word.
        if value is None or result.dtype.kind in "bcSU":
            raise TypeError
        result = result.astype(float)
    except (TypeError, ValueError):
        raise TypeError(f"{name}: expected an array of real numbers, {found(value)}.") from None
    if shape is not None and (
        result.ndim != len(shape)
        or any(want is not None and want != got for want, got in zip(shape, result.shape))
    ):
        wanted = " x ".join("any" if size is None else str(size) for size in shape)
        raise ValueError(f"{name}: expected shape {wanted}, found shape {result.shape}.")
    if finite and not np.all(np.isfinite(result)):
        raise ValueError(f"{name}: every entry must be finite, found nan or inf.")
    return result


def state_space(name, model):
    """`model` if it is a control.StateSpace."""
    from control import StateSpace  # here, so that rigs load without it

    if not isinstance(model, StateSpace):
        raise TypeError(f"{name}: expected a control.StateSpace, {found(model)}.")
    return model


def whole(name, value, least=0):
    """`value` as an int of at least `least`."""
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < least:
        raise ValueError(f"{name}: expected a whole number of at least {least}, {found(value)}.")
    return int(value)
