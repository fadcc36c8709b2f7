"""Networks as other packages have them."""

from __future__ import annotations

import numpy as np

from ._errors import SimulationError
from ._extras import need

_WALLS = ("x_min", "x_max", "y_min", "y_max", "z_min", "z_max")


def to_openpnm(network):
    """A dict with the names of OpenPNM."""
    spheres = len(network.packing)
    vertices = network.vertices
    conductance = network.conductance
    pores = {
        "pore.coords": network.centroid,
        "pore.center": network.center,
        "pore.volume": network.void_volume,
        "pore.all": np.ones(len(network), dtype=bool),
        "throat.conns": network.throats.astype(np.int64),
        "throat.conductance": conductance,
        "throat.hydraulic_conductance": conductance.copy(),
        "throat.all": np.ones(len(conductance), dtype=bool),
    }
    for k, wall in enumerate(_WALLS):
        pores[f"pore.{wall}"] = (vertices == spheres + k).any(axis=1)
    return pores


def to_scipy(network):
    """The matrix of the balance of all pores."""
    sparse = need("scipy.sparse", "to_scipy")
    a, b = network.throats.T.astype(np.int64)
    g = network.conductance
    size = len(network)
    rows = np.concatenate([a, b, a, b])
    columns = np.concatenate([b, a, a, b])
    return sparse.coo_array((np.concatenate([-g, -g, g, g]), (rows, columns)), shape=(size, size)).tocsr()


def to_networkx(network):
    """A graph of pores and throats."""
    networkx = need("networkx", "to_networkx")
    graph = networkx.Graph()
    nodes = zip(network.centroid.tolist(), network.void_volume.tolist())
    graph.add_nodes_from((k, {"center": tuple(x), "volume": v}) for k, (x, v) in enumerate(nodes))
    edges = zip(network.throats.tolist(), network.conductance.tolist())
    graph.add_edges_from((i, j, {"conductance": g}) for (i, j), g in edges)
    return graph


def to_pyvista(network):
    """Points and lines."""
    pyvista = need("pyvista", "to_pyvista")
    throats = network.throats
    lines = np.column_stack([np.full(len(throats), 2), throats])
    mesh = pyvista.PolyData(network.centroid, lines=lines)
    mesh.point_data["volume"] = network.void_volume
    mesh.cell_data["conductance"] = network.conductance
    try:
        mesh.point_data["pressure"] = network.pressure
    except SimulationError:
        # Nothing has flowed yet.
        pass
    return mesh
