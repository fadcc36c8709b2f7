"""A bar that shows how far a run has come."""

from __future__ import annotations

import sys

from ._errors import InputError


def bar(total, asked_for):
    """A bar; None where tqdm is not installed, or nobody would see it and nobody asked."""
    if not (asked_for or sys.stderr.isatty() or _in_notebook()):
        return None
    try:
        from tqdm.auto import tqdm  # type: ignore[import-untyped]
    except ImportError:
        if asked_for:
            remedy = "install it (pip install tqdm), or leave out progress=True"
            raise InputError(f"a bar needs tqdm; {remedy}", remedy=remedy) from None
        return None
    return _Bar(tqdm(total=total, unit="step", leave=False))


def _in_notebook():
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython is not None else None
    return shell is not None and "IPKernelApp" in shell.config


class _Bar:
    def __init__(self, tqdm):
        self.tqdm = tqdm

    def show(self, steps, stage, share):
        if stage is not None:
            percent = "" if share is None else f" {100 * share:.0f} %"
            self.tqdm.set_description(f"{stage}{percent}", refresh=False)
        self.tqdm.update(steps - self.tqdm.n)

    def close(self):
        self.tqdm.close()
