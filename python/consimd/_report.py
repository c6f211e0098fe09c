"""How a study that was called from Python is repeated."""

from __future__ import annotations

import inspect
import os
from collections.abc import Callable, Mapping


def call_text(function: Callable[..., object], arguments: Mapping[str, object]) -> str:
    """The call of a function of this package with these arguments, those left out that are its defaults."""
    parameters = inspect.signature(function).parameters
    given = (name for name in parameters if name in arguments and arguments[name] is not parameters[name].default)
    texts = [f"{name}={_shown(arguments[name])}" for name in given if not callable(arguments[name])]
    return f"consimd.{function.__name__}({', '.join(texts)})"


def _shown(value: object) -> str:
    """As it is written in Python; of functions the name, of what can be gone through once only that it was there."""
    if isinstance(value, (str, int, float)):
        return repr(value)
    if isinstance(value, os.PathLike):
        return repr(os.fspath(value))
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key!r}: {_shown(of)}" for key, of in value.items()) + "}"
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(_shown, value)) + "]"
    if callable(value):
        return getattr(value, "__name__", type(value).__name__)
    return "None" if value is None else "..."
