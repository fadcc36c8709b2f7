"""Arrays that lie in the memory of a simulation."""

from __future__ import annotations

import numpy as np

# Asked for by numpy and Python itself, whatever becomes of the array.
_UNCHECKED = frozenset(
    (
        "_memory",
        "__class__",
        "__dict__",
        "__doc__",
        "__array_finalize__",
        "__array_priority__",
        "__array_wrap__",
    )
)
_ADDRESS = np.ndarray.__dict__["__array_interface__"]


class View(np.ndarray):
    """A numpy array that lies in the memory of a simulation, without a copy.

    After a step it shows the values of that step. It raises :class:`StaleViewError` where the state that
    it is of is gone, and :class:`SimulationError` while another thread runs the simulation. It is
    read-only, but for velocities and spins in hooks. What is computed from it is an ordinary
    array; ``view.copy()`` keeps values.

    ``numpy.asarray(view)`` is an ordinary array in the same memory, which is never freed under it, but
    which nobody warns when its state is gone. It shows numbers of a step under way to whoever reads it in
    another thread meanwhile, as does an operation of numpy's on large views that began before the run.

    Examples
    --------
    >>> import dempfv as dp
    >>> sim = dp.Simulation({
    ...     "box": {"min": [0, 0, 0], "max": [1, 1, 1]},
    ...     "particles": {"cloud": {"count": 10, "porosity": 0.9}},
    ...     "dem": {"gravity": [0, -9.81, 0]},
    ...     "stage": [{"kind": "run", "steps": 100}],
    ... })
    >>> velocity = sim.spheres.velocity
    >>> bool(velocity[:, 1].max() < 0.0)
    False
    >>> sim.run(steps=1)
    1
    >>> bool(velocity[:, 1].max() < 0.0)
    True
    """

    _memory = None

    def __array_finalize__(self, obj):
        memory = getattr(obj, "_memory", None)
        if memory is not None and memory.covers(_ADDRESS.__get__(self)["data"][0]):
            self._memory = memory

    def __getattribute__(self, name):
        if name not in _UNCHECKED:
            _check(self)
        return super().__getattribute__(name)

    def __getitem__(self, key):
        _check(self)
        return super().__getitem__(key)

    def __setitem__(self, key, value):
        _writable(self)[key] = _plain(value)

    def __iter__(self):
        _check(self)
        return super().__iter__()

    def __len__(self):
        _check(self)
        return super().__len__()

    def __contains__(self, value):
        return value in _plain(self)

    def __repr__(self):
        return repr(_plain(self))

    def __str__(self):
        return str(_plain(self))

    def __format__(self, spec):
        return format(_plain(self), spec)

    def __bool__(self):
        return bool(_plain(self))

    def __int__(self):
        return int(_plain(self))

    def __float__(self):
        return float(_plain(self))

    def __index__(self):
        return _plain(self).__index__()

    def __copy__(self):
        return _plain(self).copy()

    def __deepcopy__(self, memo):
        return _plain(self).copy()

    def __reduce__(self):
        return _plain(self).copy().__reduce__()

    def __reduce_ex__(self, protocol):
        return _plain(self).copy().__reduce_ex__(protocol)

    def copy(self, order="C"):
        """An ordinary array with the values of the moment."""
        return _plain(self).copy(order)

    def __array_ufunc__(self, ufunc, method, *inputs, out=(), **keys):
        inputs = [_plain(value) for value in inputs]
        if method == "at":
            inputs[0] = _writable(self)
        if "where" in keys:
            keys["where"] = _plain(keys["where"])
        if out:
            keys["out"] = tuple(_writable(x) if isinstance(x, View) else x for x in out)
        result = getattr(ufunc, method)(*inputs, **keys)
        return out[0] if len(out) == 1 else result

    def __array_function__(self, function, types, arguments, keys):
        if function is np.copyto or function is np.put or function is np.place or function is np.putmask:
            first, *others = arguments
            first = _writable(first) if isinstance(first, View) else first
            return function(first, *_plain_all(others), **_plain_all(keys))
        return function(*_plain_all(arguments), **_plain_all(keys))


def wrap(array, memory):
    """The array as a view of this memory."""
    view = array.view(View)
    view._memory = memory
    return view


def _check(view):
    memory = np.ndarray.__getattribute__(view, "_memory")
    if memory is not None:
        memory.check()


def _plain(value):
    """The same values without the class, checked."""
    if not isinstance(value, View):
        return value
    _check(value)
    return np.ndarray.view(value, np.ndarray)


def _plain_all(values):
    """The same in lists, tuples and dictionaries."""
    if isinstance(values, View):
        return _plain(values)
    if isinstance(values, (list, tuple)) and type(values) in (list, tuple):
        return type(values)(_plain_all(value) for value in values)
    if type(values) is dict:
        return {key: _plain_all(value) for key, value in values.items()}
    return values


def _writable(view):
    """The same memory as an ordinary array that can be written to."""
    memory = np.ndarray.__getattribute__(view, "_memory")
    if memory is None:
        return np.ndarray.view(view, np.ndarray)
    root, first = memory.writable()
    plain = _plain(view)
    offset = plain.__array_interface__["data"][0] - first
    return np.ndarray(plain.shape, plain.dtype, root, offset, plain.strides)


View.__module__ = "dempfv"
