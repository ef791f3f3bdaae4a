"""Answers as plain data: how a value leaves a process that is not trusted.

`encode` turns numbers, arrays, containers, linear systems, SymPy expressions and the package's own
dataclasses into JSON; `decode` builds them anew from JSON alone. Nothing is pickled and no text is
evaluated, so that a decoded answer is a value and never code. What has no such form (a function, a
student's own controller) is left where it is and given a number.
"""

import sys
from dataclasses import fields, is_dataclass

import numpy as np

import pendlab as pl

NUMBERS = frozenset("biufc")


def encode(value, keep):
    """JSON form of a value; `keep(value)` gives the number of an object that has none."""
    if isinstance(value, (np.ndarray, np.generic)):  # first, as np.float64 is a float too
        return _encode_array(np.asarray(value), keep)
    if value is None or isinstance(value, (bool, int, float, str)):
        return _bare(value)
    if isinstance(value, complex):
        return {"complex": [value.real, value.imag]}
    if _is_named_tuple(value) and type(value).__module__ == "__main__":
        return {"remote": keep(value)}  # as a plain tuple it would have lost its names
    for kind in (list, tuple, set):
        if isinstance(value, kind) and not _is_made_here(value):
            return {kind.__name__: [encode(item, keep) for item in value]}
    if isinstance(value, dict):
        return {"dict": [[encode(k, keep), encode(v, keep)] for k, v in value.items()]}
    if _is_made_here(value):
        content = {name: encode(getattr(value, name), keep) for name in _field_names(value)}
        return {"made": type(value).__name__, "fields": content}
    if "control" in sys.modules and isinstance(value, sys.modules["control"].StateSpace):
        return _encode_system(value, keep)
    if "sympy" in sys.modules and isinstance(value, _symbolic()):
        try:
            return {"sympy": _encode_sympy(value)}
        except (ValueError, RecursionError):
            pass
    return {"remote": keep(value)}


def decode(data, remote):
    """The value of a JSON form; `remote(number)` stands for an object that stayed behind.

    Raises ValueError or TypeError for anything that `encode` does not make.
    """
    if data is None or isinstance(data, (bool, int, float, str)):
        return data
    if not isinstance(data, dict) or not data:
        raise ValueError("not an encoded answer")
    kind = next(iter(data))
    content = data[kind]
    if kind == "complex":
        return complex(*content)
    if kind in ("list", "tuple", "set"):
        maker = {"list": list, "tuple": tuple, "set": set}[kind]
        return maker(decode(item, remote) for item in content)
    if kind == "dict":
        return {decode(k, remote): decode(v, remote) for k, v in content}
    if kind == "array":
        return _decode_array(data, remote)
    if kind == "made":
        return _public_dataclass(content)(
            **{str(name): decode(item, remote) for name, item in data["fields"].items()}
        )
    if kind == "system":
        return _decode_system([decode(item, remote) for item in content])
    if kind == "sympy":
        return _decode_sympy(content)
    if kind == "remote":
        return remote(int(content))
    raise ValueError(f"not an encoded answer: {kind!r}")


def _bare(value):
    for kind in (bool, int, float, str):  # a subclass may print and compare as it likes
        if isinstance(value, kind):
            return kind(value)
    return None


def _encode_array(value, keep):
    if value.dtype.kind not in NUMBERS:
        flat = [encode(item, keep) for item in value.ravel().tolist()]
        return {"array": flat, "dtype": "object", "shape": value.shape}
    flat = value.ravel()
    if value.dtype.kind == "c":
        flat = np.stack([flat.real, flat.imag])
    return {"array": flat.tolist(), "dtype": value.dtype.name, "shape": value.shape}


def _decode_array(data, remote):
    name, shape = str(data["dtype"]), [int(size) for size in data["shape"]]
    if name == "object":
        flat = np.empty(len(data["array"]), dtype=object)
        flat[:] = [decode(item, remote) for item in data["array"]]
        return flat.reshape(shape)
    dtype = np.dtype(name)
    if dtype.kind not in NUMBERS:
        raise ValueError(f"not numbers: {name!r}")
    if dtype.kind == "c":
        real, imaginary = data["array"]
        flat = np.array(real, dtype=float) + 1j * np.array(imaginary, dtype=float)
    else:
        flat = np.array(data["array"], dtype=dtype)
    return flat.astype(dtype).reshape(shape)[()]


def _is_made_here(value):
    kind = type(value)
    known = is_dataclass(kind) or _is_named_tuple(value)
    return known and kind.__name__ in pl.__all__ and kind.__module__[:8] == "pendlab."


def _is_named_tuple(value):
    return isinstance(value, tuple) and hasattr(type(value), "_fields")


def _field_names(value):
    if _is_named_tuple(value):
        return value._fields
    return [field.name for field in fields(value) if field.init]


def _public_dataclass(name):
    kind = getattr(pl, name) if name in pl.__all__ else None
    if not (isinstance(kind, type) and (is_dataclass(kind) or hasattr(kind, "_fields"))):
        raise ValueError(f"not one of the package's dataclasses: {name!r}")
    return kind


def _encode_system(value, keep):
    matrices = [value.A, value.B, value.C, value.D]
    labels = [value.state_labels, value.input_labels, value.output_labels]
    return {"system": [encode(item, keep) for item in (*matrices, value.dt, *labels)]}


def _decode_system(content):
    from control import ss

    A, B, C, D, dt, states, inputs, outputs = content
    return ss(A, B, C, D, dt, states=states, inputs=inputs, outputs=outputs)


def _symbolic():
    sympy = sys.modules["sympy"]
    return (sympy.Basic, sympy.MatrixBase)


def _constants():
    import sympy

    named = "Exp1 Pi ImaginaryUnit Infinity NegativeInfinity ComplexInfinity NaN true false"
    return {name: getattr(sympy.S, name) for name in named.split()}


def _encode_sympy(value):
    """A tree of [name, ...] lists."""
    import sympy

    for name, constant in _constants().items():
        if value is constant:
            return ["constant", name]
    if isinstance(value, sympy.MatrixBase):
        return ["matrix", *value.shape, [_encode_sympy(entry) for entry in value]]
    if type(value) is sympy.Symbol:
        return ["symbol", value.name, value.assumptions0]
    if isinstance(value, sympy.Rational):
        return ["rational", int(value.p), int(value.q)]
    if isinstance(value, sympy.Float):
        return ["float", float(value)]
    if isinstance(value, sympy.core.symbol.Str):
        return ["text", value.name]
    if isinstance(value, sympy.core.function.AppliedUndef):
        return ["unknown", value.func.__name__, *map(_encode_sympy, value.args)]
    if getattr(sympy, type(value).__name__, None) is not type(value) or not value.args:
        raise ValueError(f"no form for {type(value).__name__}")
    return ["apply", type(value).__name__, *map(_encode_sympy, value.args)]


def _decode_sympy(tree):
    import sympy

    kind, *content = tree
    if kind == "constant":
        return _constants()[content[0]]
    if kind == "matrix":
        rows, columns, entries = content
        return sympy.Matrix(int(rows), int(columns), [_decode_sympy(entry) for entry in entries])
    if kind == "symbol":
        name, assumptions = content
        return sympy.Symbol(str(name), **{str(k): bool(v) for k, v in assumptions.items()})
    if kind == "rational":
        return sympy.Rational(int(content[0]), int(content[1]))
    if kind == "float":
        return sympy.Float(float(content[0]))
    if kind == "text":
        return sympy.core.symbol.Str(str(content[0]))
    name, *parts = content
    arguments = [_decode_sympy(part) for part in parts]
    if kind == "unknown":
        return sympy.Function(str(name))(*arguments)
    maker = getattr(sympy, str(name), None)
    if kind != "apply" or not (isinstance(maker, type) and issubclass(maker, sympy.Basic)):
        raise ValueError(f"no form for {name!r}")
    return maker(*arguments)
