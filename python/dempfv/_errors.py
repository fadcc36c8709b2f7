"""Exceptions, each with what it is about as attributes."""

from __future__ import annotations


class DempfvError(Exception):
    """Base of all exceptions of dempfv.

    Attributes are ``None`` where nothing is known of them.

    Attributes
    ----------
    file : str
        File that is wrong.
    line : int
        Line in it, from 1.
    remedy : str
        What would be right; part of the message too.
    step : int
        Step at which the simulation failed, from 0.
    sphere : int
        The user's number of the sphere.
    pore : int
        The pore, in the network of that step.

    Examples
    --------
    >>> import dempfv as dp
    >>> try:
    ...     dp.Simulation({"sede": 1})
    ... except dp.DempfvError as error:
    ...     print(error.remedy)
    did you mean `seed`?
    """

    def __init__(self, message, *, file=None, line=None, remedy=None, step=None, sphere=None, pore=None):
        super().__init__(message)
        self.file = file
        self.line = line
        self.remedy = remedy
        self.step = step
        self.sphere = sphere
        self.pore = pore

    def __reduce__(self):
        return _restored, (type(self), self.args[0], self.__dict__)


class InputError(DempfvError, ValueError):
    """What was given is wrong; nothing was computed or written.

    Examples
    --------
    >>> import dempfv as dp
    >>> dp.Packing([[0.5, 0.5, 0.5]], [-1.0], [[0, 0, 0], [1, 1, 1]])
    Traceback (most recent call last):
    dempfv.InputError: sphere 0 has the radius -1; radii are positive
    """


class SimulationError(DempfvError, RuntimeError):
    """The simulation cannot go on, or cannot do this as it stands.

    Examples
    --------
    >>> import dempfv as dp
    >>> issubclass(dp.SimulationError, RuntimeError)
    True
    """


class StaleViewError(DempfvError, RuntimeError):
    """An array of a state that is gone was used: of a network that has been replaced, of a simulation
    that has been restored, of spheres that have been put in another order.

    Take the array anew from the simulation; ``array.copy()`` keeps values.

    Examples
    --------
    >>> import dempfv as dp
    >>> issubclass(dp.StaleViewError, dp.DempfvError)
    True
    """


def _restored(kind, message, attributes):
    error = kind(message)
    error.__dict__.update(attributes)
    return error


for _kind in (DempfvError, InputError, SimulationError, StaleViewError):
    _kind.__module__ = "dempfv"
