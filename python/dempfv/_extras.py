"""Packages that are used where they are installed."""

from __future__ import annotations

import importlib

from ._errors import InputError


def need(module, what):
    """The module; one message where it is not installed."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        package = module.partition(".")[0]
        remedy = f"install it (pip install {package})"
        raise InputError(f"{what} needs {package}: {error}; {remedy}", remedy=remedy) from None
