"""What Python gives as arrays, as arrays of double precision."""

from __future__ import annotations

import numpy as np

from ._errors import InputError


def numbers(values):
    """An array of float64 of any shape."""
    try:
        return np.array(values, dtype=np.float64, ndmin=1)
    except (TypeError, ValueError) as error:
        remedy = "give a list or an array of numbers"
        raise InputError(f"not an array of numbers: {error}; {remedy}", remedy=remedy) from None


def vectors(values):
    """An array of float64 with two dimensions, its rows one after the other in memory."""
    try:
        values = np.ascontiguousarray(np.asarray(values), dtype=np.float64)
    except (TypeError, ValueError) as error:
        remedy = "return an array of shape (n, 3)"
        raise InputError(f"a force that is no array of numbers: {error}; {remedy}", remedy=remedy) from None
    if values.ndim != 2:
        remedy = "return an array of shape (n, 3)"
        raise InputError(f"a force of shape {values.shape}; {remedy}", remedy=remedy)
    return values
