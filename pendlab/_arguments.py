"""Checks of arguments: one sentence that names the argument, what was expected and what came."""

import math
from numbers import Real

import numpy as np


def found(value):
    """What came, in a few words."""
    if isinstance(value, np.ndarray):
        return f"found an array of shape {value.shape}"
    if isinstance(value, type):
        return f"found the class {value.__name__}"
    try:
        text = " ".join(repr(value).split())
    except Exception:  # of somebody else's class, or a whole number of thousands of digits
        text = "<"
    if text.startswith("<"):  # an address
        text = f"an object of type {type(value).__name__}"
    return f"found {text if len(text) <= 60 else text[:57] + '...'}"


def number(name, value, above=None, least=None, finite=True, most=None):
    """`value` as a float, or a sentence on why not."""
    if isinstance(value, bool) or not isinstance(value, Real):
        raise TypeError(f"{name}: expected a number, {found(value)}.")
    try:
        value = float(value)
    except OverflowError:
        raise ValueError(f"{name}: expected a number up to 1e308, {found(value)}.") from None
    if math.isnan(value) or (finite and math.isinf(value)):
        raise ValueError(f"{name}: expected a finite number, {found(value)}.")
    if above is not None and not value > above:
        raise ValueError(f"{name}: expected a number above {above:g}, {found(value)}.")
    if least is not None and not value >= least:
        raise ValueError(f"{name}: expected a number of at least {least:g}, {found(value)}.")
    if most is not None and value > most:
        raise ValueError(f"{name}: expected a number of at most {most:g}, {found(value)}.")
    return value


def numbers(name, values, count=None, **bounds):
    """`values` as a tuple of floats within `bounds` of `number`; a single number counts as one."""
    if isinstance(values, Real) and not isinstance(values, bool):
        values = (values,)
    try:
        if isinstance(values, str):  # would count as a list of letters
            raise TypeError
        items = list(values)
    except Exception:  # python-control's systems raise OSError
        raise TypeError(f"{name}: expected numbers, {found(values)}.") from None
    if count is not None and len(items) != count:
        raise ValueError(f"{name}: expected {count} numbers, found {len(items)}.")
    return tuple(number(f"{name}[{i}]", item, **bounds) for i, item in enumerate(items))


def array(name, value, shape=None, finite=True):
    """`value` as a float array of as many dimensions as `shape`, where None stands for any size."""
    try:
        result = np.array(value)
        if value is None or result.dtype.kind not in "iufO":  # NumPy would take them for numbers
            raise TypeError
        result = result.astype(float)
    except (TypeError, ValueError, OverflowError):
        raise TypeError(f"{name}: expected an array of real numbers, {found(value)}.") from None
    result = result.reshape((1,) * (len(shape or ()) - result.ndim) + result.shape)
    sizes = zip(shape or (), result.shape)
    if shape and result.shape != tuple(got if want is None else want for want, got in sizes):
        wanted = " x ".join("any" if size is None else str(size) for size in shape)
        raise ValueError(f"{name}: expected shape {wanted}, found shape {result.shape}.")
    if finite and not np.all(np.isfinite(result)):
        raise ValueError(f"{name}: every entry must be finite, found nan or inf.")
    return result


def instance(name, value, kind, example=""):
    """`value` if it is a `kind`; `example` says where to get one."""
    if not isinstance(value, kind):
        example = example and f" such as {example}"
        home = kind.__module__.partition(".")[0].replace("pendlab", "pl")
        raise TypeError(f"{name}: expected a {home}.{kind.__name__}{example}, {found(value)}.")
    return value


def instances(name, value, kind, other=""):
    """One `kind` or several as a tuple; `other` says what else would have done."""
    try:
        value = (value,) if isinstance(value, (kind, str)) else tuple(value)
    except Exception:
        expected = f"a list of pl.{kind.__name__}{other}"
        raise TypeError(f"{name}: expected {expected}, {found(value)}.") from None
    return tuple(instance(f"{name}: entry {i}", one, kind) for i, one in enumerate(value, 1))


def state_space(name, model, sampled=None):
    """`model` if it is a control.StateSpace with states; `sampled` True or False asks for a kind."""
    from control import StateSpace  # here, so that rigs load without it

    if not isinstance(model, StateSpace):
        raise TypeError(f"{name}: expected a control.StateSpace, {found(model)}.")
    if not all((np.abs(part) < 1e100).all() for part in (model.A, model.B, model.C, model.D)):
        raise ValueError(f"{name}: every entry of A, B, C and D must be finite and below 1e100.")
    if 0 in (model.nstates, model.ninputs, model.noutputs) or model.dt is None or model.dt is True:
        raise ValueError(
            f"{name}: expected states, inputs, outputs and a sampling time (0: continuous), found "
            f"{model.nstates}, {model.ninputs}, {model.noutputs} and dt = {model.dt}."
        )
    if sampled and not model.dt:
        raise ValueError(f"{name}: expected a sampled one, found a continuous one; use pl.sample.")
    if sampled is False and model.dt:
        raise ValueError(
            f"{name}: expected a continuous model, found one already sampled at {model.dt} s; "
            "use pl.linearize, pl.with_filters if wanted, then pl.sample once."
        )
    return model


def whole(name, value, least=0, most=None):
    """`value` as an int from `least` to `most`."""
    is_whole = isinstance(value, (int, np.integer)) and not isinstance(value, bool)
    if not is_whole or not least <= value <= (math.inf if most is None else most):
        span = f"of at least {least}" if most is None else f"from {least} to {most}"
        raise ValueError(f"{name}: expected a whole number {span}, {found(value)}.")
    return int(value)


def flag(name, value):
    """`value` if it is True or False."""
    if not isinstance(value, (bool, np.bool_)):
        raise TypeError(f"{name}: expected True or False, {found(value)}.")
    return bool(value)


def text(name, value, empty=False):
    """`value` if it is text, one that says something unless `empty` is allowed."""
    if not isinstance(value, str):
        raise TypeError(f"{name}: expected text in quotes, {found(value)}.")
    if not empty and not value.strip():
        raise ValueError(f"{name}: expected text, found none; write your own.")
    return value


def plain(value, digits=4):
    """A number as text; one that is real is written as real, whatever type it came in.

    >>> plain(0.5 + 0j), plain(1j)
    ('0.5', '0+1j')
    """
    return f"{value:.{digits}g}" if np.imag(value) else f"{np.real(value):.{digits}g}"
