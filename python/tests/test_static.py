"""Packings, networks and factors without a scene."""

import dempfv as dp
import numpy as np
import pytest

sparse = pytest.importorskip("scipy.sparse")
linalg = pytest.importorskip("scipy.sparse.linalg")


@pytest.fixture(scope="module")
def packing():
    return dp.pack(200, edge=0.01)


@pytest.fixture(scope="module")
def network(packing):
    return dp.Network(packing)


def test_packings_keep_every_digit(packing, tmp_path):
    packing.save(tmp_path / "p.txt", comment="mine")
    again = dp.Packing.load(tmp_path / "p.txt")
    assert np.array_equal(again.positions, packing.positions)
    assert np.array_equal(again.radii, packing.radii) and np.array_equal(again.box, packing.box)
    assert (tmp_path / "p.txt").read_text().startswith("# mine")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([[0.5, 0.5]], [0.1]), "no rows of x, y, z"),
        (([[0.5] * 3], [0.1, 0.2]), r"radii of shape \[2\] for 1 positions"),
        (([[0.5] * 3], [-0.1]), "sphere 0 has the radius -0.1"),
        (([[0.5] * 3], [float("nan")]), "sphere 0 has the radius NaN"),
        (([[float("inf")] * 3], [0.1]), "no finite sphere"),
        (([[0.5] * 3], [0.1], [[0] * 3]), "no two corners"),
        (([[1.5] * 3], [0.1], [[0] * 3, [1] * 3]), "sphere 0 "),
        (([[0.5] * 3, [0.5] * 3], [0.1, 0.1]), "sphere 1 is in the same place"),
        (([], []), "no rows"),
        (("x", "y"), "not an array of numbers"),
    ],
)
def test_packings_that_are_none(arguments, message):
    with pytest.raises(dp.InputError, match=message):
        dp.Packing(*arguments)


def test_a_network_solves_what_its_matrix_says(network):
    """G p = 0 in every pore without an imposed pressure, by scipy's matrix and our pressures."""
    pressure = network.solve({"y_min": 1.0, "y_max": 0.0})
    g = network.to_scipy()
    walls = network.to_openpnm()
    free = ~(walls["pore.y_min"] | walls["pore.y_max"])
    through = abs(g) @ np.ones(len(network))
    assert abs(g @ pressure)[free].max() < 1e-9 * through.max()
    at_bottom = walls["pore.y_min"] & ~walls["pore.y_max"]
    assert (pressure[at_bottom] == 1.0).all()
    # What enters at the bottom is the flux, and what pushes the spheres is what drives it: Δp A.
    flux = (g @ pressure)[at_bottom].sum()
    assert flux == pytest.approx(network.flux["y_min"], rel=1e-9)
    k = network.permeability("y")
    area, height = 1e-4, 1e-2
    assert k == pytest.approx(flux * 1e-3 * height / area, rel=0.2)
    assert 0.2 < k / network.kozeny_carman < 5.0


def test_scipy_finds_the_same_pressures(network):
    pressure = network.solve({"y_min": 1.0, "y_max": 0.0})
    walls = network.to_openpnm()
    known = walls["pore.y_min"] | walls["pore.y_max"]
    g = network.to_scipy().tocsc()
    # Pores that no throat joins to the others have no pressure of their own.
    free = ~known & (abs(g).sum(axis=0) > 0.0)
    a = g[free][:, free]
    expected = linalg.spsolve(a, -g[free][:, known] @ pressure[known])
    assert pressure[free] == pytest.approx(expected, abs=1e-9)
    factor = dp.Factor(a)
    assert factor.solve(-g[free][:, known] @ pressure[known]) == pytest.approx(expected, abs=1e-9)


def test_pressures_of_other_walls(network):
    first = network.solve({"y_min": 1.0, "y_max": 0.0})
    doubled = network.solve({"y_min": 2.0, "y_max": 0.0})
    assert doubled == pytest.approx(2 * first, abs=1e-12)
    across = network.solve({"x_min": 1.0, "x_max": 0.0})
    assert not np.array_equal(across, first)
    # Solves go on from the last pressures, to a tolerance of 1e-11.
    assert network.solve({"y_min": 1.0, "y_max": 0.0}) == pytest.approx(first, abs=1e-10)
    assert network.force.shape == (200, 3)


def test_viscosity_only_scales_the_flux(packing, network):
    thick = dp.Network(packing, viscosity=1.0)
    pressure = {"x_min": 1.0, "x_max": 0.0}
    assert thick.solve(pressure) == pytest.approx(network.solve(pressure), abs=1e-9)
    assert thick.permeability("x") == pytest.approx(network.permeability("x"), rel=1e-9)
    sticky = dp.Network(packing, slip=False)
    assert sticky.permeability("x") < network.permeability("x")


def test_networks_for_others(network):
    pnm = network.to_openpnm()
    assert pnm["pore.coords"].shape == (len(network), 3)
    assert pnm["throat.conns"].shape == (len(pnm["throat.conductance"]), 2)
    inside = (pnm["pore.coords"] >= -1e-12) & (pnm["pore.coords"] <= 0.01 + 1e-12)
    assert inside.all()
    assert pnm["pore.volume"].sum() == pytest.approx(network.packing.porosity * 1e-6, rel=0.02)
    graph = pytest.importorskip("networkx") and network.to_networkx()
    assert graph.number_of_nodes() == len(network) and graph.number_of_edges() == len(network.throats)


def test_networks_that_are_none(packing, network):
    for refused, message in [
        (lambda: dp.Network(packing, viscosity=0.0), "viscosity 0 is not positive"),
        (lambda: dp.Network(packing, clamp="none at all"), "none at all"),
        (lambda: dp.Network(packing, solver="umfpack"), "unknown solver `umfpack`"),
        (lambda: network.solve({}), "no pressure is imposed"),
        (lambda: network.solve({"top": 1.0}), "unknown wall `top`"),
        (lambda: network.solve({"y_min": float("inf")}), "no finite number"),
        (lambda: network.permeability("w"), "no axis `w`"),
    ]:
        with pytest.raises(dp.InputError, match=message):
            refused()
    with pytest.raises(dp.SimulationError, match="no flow has been solved"):
        dp.Network(packing).flux  # noqa: B018


def laplacian(n):
    """Of an n by n grid, with the boundary held."""
    line = sparse.diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(n, n))
    eye = sparse.eye_array(n)
    return (sparse.kron(line, eye) + sparse.kron(eye, line)).tocsc()


@pytest.mark.parametrize("solver", ["auto", "cholmod", "frontal"])
def test_factors(solver):
    a = laplacian(30)
    factor = dp.Factor(a, solver)
    b = np.random.default_rng(3).normal(size=(900, 4))
    x = factor.solve(b)
    assert abs(a @ x - b).max() < 1e-12 * abs(a).max() * abs(x).max()
    assert all(np.array_equal(x[:, k], factor.solve(b[:, k])) for k in range(4))
    assert factor.shape == (900, 900) and factor.nnz > a.nnz / 2


def test_a_factor_preconditions():
    a = laplacian(30)
    near = (a + 0.1 * sparse.eye_array(900)).tocsc()
    count = [0, 0]

    def iterations(k):
        def counted(_):
            count[k] += 1

        return counted

    b = np.ones(900)
    linalg.cg(a, b, rtol=1e-10, callback=iterations(0))
    x, info = linalg.cg(a, b, rtol=1e-10, M=dp.Factor(near).aspreconditioner(), callback=iterations(1))
    assert info == 0 and count[1] < 0.5 * count[0]
    assert abs(a @ x - b).max() < 1e-8


def test_matrices_that_are_none():
    a = laplacian(3)
    for matrix, message in [
        (a[:2], "a matrix of shape"),
        (a + sparse.coo_array(([1.0], ([0], [1])), shape=(9, 9)), r"not symmetric: its entries in \(1, 0\)"),
        (-a, "not positive definite at unknown"),
        (sparse.coo_array(([np.nan], ([0], [0])), shape=(1, 1)), "is NaN"),
        ("a matrix", "not a matrix"),
    ]:
        with pytest.raises(dp.DempfvError, match=message):
            dp.Factor(matrix, "cholmod")
    with pytest.raises(dp.InputError, match=r"shape \[8\] for 9 unknowns"):
        dp.Factor(a).solve(np.ones(8))
    with pytest.raises(dp.InputError, match="unknown solver"):
        dp.Factor(a, "umfpack")
