"""Matrices of scipy as the library has them, and back."""

from __future__ import annotations

import numpy as np

from ._errors import InputError
from ._extras import need

# Entries of both triangles may differ by this share of the largest: round-off of whoever assembled them.
_ASYMMETRY = 1e-12


def lower_triangle(a):
    """Number of columns, column pointers, rows and values of the lower triangle."""
    sparse = need("scipy.sparse", "a sparse matrix")
    try:
        a = sparse.csc_array(a, dtype=np.float64)
    except (TypeError, ValueError) as error:
        _refuse(f"not a matrix: {error}", "give a sparse array of scipy")
    if a.shape[0] != a.shape[1]:
        _refuse(f"a matrix of shape {a.shape}", "give a square one")
    a.sum_duplicates()
    difference = abs(a - a.T)
    largest = abs(a).max() if a.nnz else 0.0
    if difference.nnz and difference.max() > _ASYMMETRY * largest:
        entry = difference.tocoo()
        k = int(entry.data.argmax())
        row, column = int(entry.row[k]), int(entry.col[k])
        _refuse(
            f"the matrix is not symmetric: its entries in ({row}, {column}) and ({column}, {row}) differ "
            f"by {entry.data[k]:.3e}",
            "give both triangles of a symmetric matrix",
        )
    lower = sparse.tril(a, format="csc")
    lower.sort_indices()
    return (
        a.shape[0],
        lower.indptr.astype(np.int64),
        lower.indices.astype(np.int64),
        np.ascontiguousarray(lower.data, dtype=np.float64),
    )


def operator(factor):
    """A factor as a linear operator."""
    linalg = need("scipy.sparse.linalg", "a preconditioner")
    return linalg.LinearOperator(
        factor.shape,
        matvec=lambda b: factor.solve(np.asarray(b).reshape(-1)),
        matmat=factor.solve,
        rmatvec=lambda b: factor.solve(np.asarray(b).reshape(-1)),
        dtype=np.float64,
    )


def _refuse(what, remedy):
    raise InputError(f"{what}; {remedy}", remedy=remedy)
