"""A scene in dictionaries as the text of a scene file."""

from __future__ import annotations

import os

from ._errors import InputError


def to_toml(tables):
    """The scene as TOML: the reader of scene files checks it."""
    return "".join(f"{_key(key)} = {_value(value, str(key))}\n" for key, value in tables.items())


def _key(key):
    if not isinstance(key, str):
        _refuse(f"the key {key!r} of the scene is no text", "keys are those of a scene file")
    return _text(key)


def _value(value, where):
    if hasattr(value, "tolist") and not isinstance(value, (str, bytes)):
        # A number or an array of numpy's.
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        # Shortest digits that read back to the same bits; TOML writes infinities as Python does.
        return repr(value)
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, os.PathLike):
        return _text(os.fspath(value))
    if isinstance(value, dict):
        pairs = (f"{_key(key)} = {_value(entry, f'{where}.{key}')}" for key, entry in value.items())
        return "{ " + ", ".join(pairs) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_value(entry, f"{where}[{k}]") for k, entry in enumerate(value)) + "]"
    kind = type(value).__name__
    _refuse(f"`{where}` of the scene is of the type {kind}", "give a number, a text, a list or a dict")


def _text(text):
    escaped = {'"': '\\"', "\\": "\\\\"}
    plain = (escaped.get(c) or (f"\\u{ord(c):04x}" if ord(c) < 32 or ord(c) == 127 else c) for c in text)
    return '"' + "".join(plain) + '"'


def _refuse(what, remedy):
    raise InputError(f"{what}; {remedy}", remedy=remedy)
