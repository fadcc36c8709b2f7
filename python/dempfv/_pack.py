"""Packings made by growth."""

from __future__ import annotations

from ._dempfv import Simulation


def pack(
    count=1000, *, spread=0.3, edge=1.0, stress=1e4, young=1e6, friction=3.0, seed=1, progress=None
):
    """Makes a settled packing in a cubical box, as ``dempfv pack`` does.

    Spheres are drawn at random and grow until the mean stress on the walls is that asked for.

    Parameters
    ----------
    count : int
        Number of spheres.
    spread : float
        Radii are uniform in mean (1 ± spread).
    edge : float
        Edge of the box (m).
    stress : float
        Isotropic stress (Pa).
    young : float
        Modulus of the contacts (Pa).
    friction : float
        Friction angle while packing (degrees): low packs densely.
    seed : int
        Of the random cloud.
    progress : bool, optional
        As for :meth:`Simulation.run`.

    Returns
    -------
    Packing

    Raises
    ------
    InputError
        For an argument that makes no packing.
    SimulationError
        Where the packing does not settle.

    Examples
    --------
    >>> import dempfv as dp
    >>> packing = dp.pack(50, edge=0.01)
    >>> len(packing), 0.3 < packing.porosity < 0.5
    (50, True)
    """
    sim = Simulation(
        {
            "title": "packing",
            "seed": seed,
            "box": {"min": [0, 0, 0], "max": [edge, edge, edge]},
            "particles": {"young": young, "cloud": {"count": count, "spread": spread, "porosity": 0.9}},
            "dem": {},
            "stage": [{"kind": "compact", "stress": stress, "friction_angle": friction}],
        }
    )
    sim.run(progress=progress)
    return sim.packing()
