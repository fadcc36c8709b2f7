"""Saturated granular matter: spheres in contact, coupled to the flow through their pores.

>>> import dempfv as dp
>>> packing = dp.pack(50, edge=0.01)
>>> round(packing.porosity, 1)
0.4
"""

from ._dempfv import (
    NONE,
    Contacts,
    Factor,
    Network,
    Packing,
    Pores,
    Simulation,
    Spheres,
    Throats,
    Walls,
    __version__,
    restore,
    set_threads,
)
from ._errors import DempfvError, InputError, SimulationError, StaleViewError
from ._pack import pack
from ._views import View

__all__ = [
    "NONE",
    "Contacts",
    "DempfvError",
    "Factor",
    "InputError",
    "Network",
    "Packing",
    "Pores",
    "Simulation",
    "SimulationError",
    "Spheres",
    "StaleViewError",
    "Throats",
    "View",
    "Walls",
    "__version__",
    "pack",
    "restore",
    "set_threads",
]

# They are of this package, whatever file they are written in.
for _name in ("pack", "restore", "set_threads"):
    try:
        globals()[_name].__module__ = __name__
    except AttributeError:
        pass
del _name
