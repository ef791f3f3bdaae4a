"""Checks of arguments that the core has no use for, beside those of `_arguments`."""

import os
from pathlib import Path

from .._arguments import found, number, text


def one_of(name, value, known):
    """`value` if it is one of `known`; the kind counts, so that True is not 1."""
    if not any(type(value) is type(item) and value == item for item in known):
        listed = ", ".join(map(repr, known))
        raise ValueError(f"{name}: expected one of {listed}, {found(value)}.")
    return value


def function(name, value, expected="a function"):
    """`value` if it can be called."""
    if not callable(value):
        raise TypeError(f"{name}: expected {expected}, {found(value)}.")
    return value


def items(name, value, expected):
    """`value` as a list, if it is a list or tuple."""
    if not isinstance(value, (list, tuple)):
        raise TypeError(f"{name}: expected a list of {expected}, {found(value)}.")
    return list(value)


def mapping(name, value, example, least=1):
    """`value` if it is a dict with `least` entries; `example` shows one."""
    if not isinstance(value, dict) or len(value) < least:
        raise TypeError(f"{name}: expected a dict such as {example}, {found(value)}.")
    return value


def interval(name, value, free=False):
    """`value` as (low, high); either may be None where `free`."""
    try:
        low, high = value
    except (TypeError, ValueError):
        raise ValueError(f"{name}: expected two ends (low, high), {found(value)}.") from None
    low, high = (
        end if free and end is None else number(name, end, least=-1e100, most=1e100)
        for end in (low, high)
    )
    if None not in (low, high) and not high - low > 1e-9 * max(abs(low), abs(high)):
        raise ValueError(f"{name}: expected the lower end first, {found(value)}.")
    return low, high


def path(name, value):
    """`value` as a `Path`."""
    if not isinstance(value, (str, os.PathLike)):
        raise TypeError(f"{name}: expected the path of a file or folder, {found(value)}.")
    return Path(text(name, os.fspath(value)))
