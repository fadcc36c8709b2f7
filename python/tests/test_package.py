"""The package as a whole: every public name is documented, and its examples run."""

import doctest
import inspect

import dempfv as dp
import pytest

PUBLIC = [name for name in dp.__all__ if name not in ("NONE", "__version__")]


def members(name):
    """A class with its public members, or a function."""
    item = getattr(dp, name)
    yield name, item
    if inspect.isclass(item) and name != "View":
        for member, value in vars(item).items():
            if not member.startswith("_"):
                yield f"{name}.{member}", value


@pytest.mark.parametrize("name", PUBLIC)
def test_every_public_name_is_documented(name):
    missing = [path for path, item in members(name) if not (getattr(item, "__doc__", None) or "").strip()]
    assert not missing


@pytest.mark.parametrize("name", ["dempfv", *PUBLIC])
def test_examples_run(name):
    items = [(name, dp)] if name == "dempfv" else members(name)
    flags = doctest.ELLIPSIS | doctest.IGNORE_EXCEPTION_DETAIL
    runner = doctest.DocTestRunner(verbose=False, optionflags=flags)
    parser, ran = doctest.DocTestParser(), 0
    for path, item in items:
        text = inspect.getdoc(item) or ""
        test = parser.get_doctest(text, {}, path, None, None)
        if test.examples:
            ran += 1
            runner.run(test)
    assert runner.failures == 0
    # Every class and function shows how it is used; arrays of a simulation do so in their class.
    assert ran > 0 or name == "SimulationError"


def test_names_are_of_the_package():
    for name in PUBLIC:
        assert getattr(dp, name).__module__ in ("dempfv", "dempfv._dempfv"), name
    assert set(dp.__all__) == {name for name in vars(dp) if not name.startswith("_")} | {"__version__"}
