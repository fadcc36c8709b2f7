"""Arrays in the memory of a simulation: nothing is copied, nothing is freed under one, and one of a
state that is gone raises."""

import copy
import gc
import pickle
import threading

import dempfv as dp
import numpy as np
import pytest

OF_SPHERES = ("position", "velocity", "spin", "radius", "mass", "force", "torque", "number")
OF_PORES = ("pressure", "center", "volume", "vertices", "neighbors")


def address(array):
    return np.asarray(array).__array_interface__["data"][0]


def of_network(sim):
    views = {name: getattr(sim.pores, name) for name in OF_PORES}
    views["throats"] = sim.throats.pores
    views["conductance"] = sim.throats.conductance
    return views


def uses(view):
    """Ways to look at an array, each of which must notice that its state is gone."""
    return {
        "item": lambda: view[0],
        "slice": lambda: view[1:3],
        "length": lambda: len(view),
        "iteration": lambda: list(view),
        "repr": lambda: repr(view),
        "str": lambda: str(view),
        "sum": lambda: view.sum(),
        "np.sum": lambda: np.sum(view),
        "np.concatenate": lambda: np.concatenate([view, view]),
        "operator": lambda: view + 1,
        "comparison": lambda: view == 1,
        "reflected": lambda: 1 - view,
        "copy": lambda: view.copy(),
        "deepcopy": lambda: copy.deepcopy(view),
        "pickle": lambda: pickle.dumps(view),
        "tolist": lambda: view.tolist(),
        "transpose": lambda: view.T,
        "shape": lambda: view.shape,
        "in": lambda: 1 in view,
        "astype": lambda: view.astype(float),
    }


def assert_stale(view):
    for way, use in uses(view).items():
        with pytest.raises(dp.StaleViewError):
            use()
            pytest.fail(f"{way} saw a state that is gone")


def test_spheres_are_not_copied_and_live(dry):
    sim = dp.Simulation(dry)
    views = {name: getattr(sim.spheres, name) for name in OF_SPHERES}
    before = {name: (address(view), view.copy()) for name, view in views.items()}
    sim.run(steps=100)
    for name, view in views.items():
        assert address(getattr(sim.spheres, name)) == before[name][0] == address(view), name
        assert np.array_equal(view, getattr(sim.spheres, name)), name
    # Gravity moves them: the old views show it.
    assert (views["velocity"][:, 1] < before["velocity"][1][:, 1]).any()
    assert np.array_equal(views["radius"], before["radius"][1])


def test_shapes_and_types(wet):
    sim = dp.Simulation(wet)
    sim.run(steps=2)
    n, pores, throats = len(sim.spheres), len(sim.pores), len(sim.throats)
    assert sim.spheres.position.shape == sim.spheres.torque.shape == (n, 3)
    assert sim.spheres.radius.shape == sim.spheres.group.shape == (n,)
    assert sim.pores.vertices.shape == sim.pores.neighbors.shape == (pores, 4)
    assert sim.pores.pressure.shape == sim.pores.volume.shape == (pores,)
    assert sim.throats.pores.shape == (throats, 2) and sim.throats.conductance.shape == (throats,)
    assert sim.pores.vertices.max() == n + 5 and sim.pores.neighbors.max() == dp.NONE
    # Pores fill the box: 10 mm along each axis.
    assert sim.pores.volume.sum() == pytest.approx(1e-6, rel=1e-9)
    # Each facet between two pores is a throat of both.
    inner = np.count_nonzero(sim.pores.neighbors != dp.NONE)
    assert inner == 2 * throats


def test_rows_and_numbers(dry, tmp_path):
    positions = [[0.3, 0.5, 0.5], [0.8, 0.1, 0.9], [0.1, 0.9, 0.1]]
    packing = dp.Packing(positions, [0.1, 0.05, 0.08], [[0] * 3, [1] * 3])
    packing.save(tmp_path / "three.txt")
    del dry["box"]
    sim = dp.Simulation(dry | {"particles": {"packing": tmp_path / "three.txt"}})
    assert np.array_equal(sim.spheres.by_number(sim.spheres.position), packing.positions)
    assert np.array_equal(sim.spheres.radius[sim.spheres.row], packing.radii)
    with pytest.raises(dp.InputError, match="2 rows for 3 spheres"):
        sim.spheres.by_number([1, 2])


def test_views_are_read_only_outside_of_hooks(dry):
    sim = dp.Simulation(dry)
    for name in ("velocity", "position"):
        view = getattr(sim.spheres, name)
        for change in (
            lambda: view.__setitem__(0, 1.0),
            lambda: np.add(view, 1.0, out=view),
            lambda: np.copyto(view, 1.0),
            lambda: np.add.at(view, 0, 1.0),
        ):
            with pytest.raises(dp.SimulationError, match="read-only"):
                change()
        with pytest.raises(ValueError, match="read-only"):
            np.asarray(view)[0] = 1.0


def test_hooks_change_velocities_and_nothing_else(dry):
    sim = dp.Simulation(dry)

    def stop(sim):
        sim.spheres.velocity[:] = 0.0
        sim.spheres.velocity[3:5, 1] += 2.0
        spin = sim.spheres.spin
        np.add(spin, [1.0, 0.0, 0.0], out=spin)
        with pytest.raises(dp.SimulationError, match="read-only; of spheres, velocity and spin"):
            sim.spheres.position[0] = 0.0

    sim.run(steps=1, callback=stop)
    expected = np.zeros((200, 3))
    expected[3:5, 1] = 2.0
    assert np.array_equal(sim.spheres.velocity, expected)
    assert (sim.spheres.spin[:, 0] >= 1.0).all()


def test_what_is_computed_from_views_is_ordinary(dry):
    sim = dp.Simulation(dry)
    position = sim.spheres.position
    for made in (position + 1, position.copy(), np.sort(position), position[[0, 1]], copy.copy(position)):
        assert getattr(made, "_memory", None) is None
    assert type(position + 1) is type(position.copy()) is np.ndarray
    row = position[0]
    assert row.base is not None and row._memory is not None
    kept = position[[0, 1]]
    sim2 = pickle.loads(pickle.dumps(position))
    assert np.array_equal(sim2, position) and np.array_equal(kept, position[:2])


def test_a_network_that_is_replaced_goes_stale(wet):
    sim = dp.Simulation(wet)
    sim.run(steps=1)
    old = of_network(sim)
    first = {name: view.copy() for name, view in old.items()}
    row = old["center"][0]
    plain = {name: np.asarray(view) for name, view in old.items()}
    assert sim.remeshes == 1
    sim.run(steps=5)
    # No remesh yet: the same arrays, with the pressures of the moment.
    assert not np.array_equal(old["pressure"], first["pressure"])
    assert address(sim.pores.pressure) == address(old["pressure"])
    last = {name: view.copy() for name, view in old.items()}
    sim.run(steps=20)
    assert sim.remeshes > 1
    for view in (*old.values(), row):
        assert_stale(view)
    # What is past all guards sees old values: the memory is that of the old network still.
    sim.run(steps=50)
    gc.collect()
    for name, array in plain.items():
        if name != "pressure":
            assert np.array_equal(array, last[name]), name
    assert np.isfinite(plain["pressure"]).all()
    for name, view in of_network(sim).items():
        assert address(view) != address(plain[name])
        len(view)


@pytest.mark.parametrize("remesh", ["at once", "ahead", "background"])
def test_views_through_every_kind_of_remesh(wet, remesh):
    """Views that are dropped, kept, and taken anew while networks come and go; the same bits as without."""
    wet["fluid"]["remesh"] = remesh
    alone = dp.Simulation(wet)
    alone.run()
    sim = dp.Simulation(wet)
    kept, values = [], []

    def look(sim):
        views = of_network(sim)
        if sim.steps % 30 == 0:
            kept.append(np.asarray(views["vertices"]))
            values.append(views["vertices"].copy())

    sim.run(callback=look, every=3)
    assert sim.state_hash == alone.state_hash
    assert len(kept) > 10
    del sim
    gc.collect()
    assert all(np.array_equal(array, value) for array, value in zip(kept, values))


def test_networks_that_nobody_looks_at_are_freed(wet):
    """Views of one network keep one network, not those after it."""
    wet["stage"][0]["steps"] = 3000
    sim = dp.Simulation(wet)
    sim.run(steps=1)
    old = np.asarray(sim.pores.vertices)
    sim.run(steps=200)
    before = resident_bytes()
    sim.run(steps=2000)
    # 200 networks of some 1,300 pores have gone by, more than 100 MB.
    assert sim.remeshes > 200
    assert resident_bytes() - before < 20e6
    assert old.max() == 205


def test_every_step_geometry(wet):
    """Where the network follows the spheres, so do its arrays."""
    wet["fluid"] |= {"update": "every step", "remesh_interval": 50}
    sim = dp.Simulation(wet)
    sim.run(steps=2)
    center = sim.pores.center
    before = center.copy()
    sim.run(steps=20)
    assert sim.remeshes == 1 and not np.array_equal(center, before)
    kept = np.asarray(center)
    sim.run(steps=60)
    assert_stale(center)
    assert np.isfinite(kept).all()


def test_restore_makes_views_stale(wet, tmp_path):
    sim = dp.Simulation(wet)
    sim.run(steps=5)
    sim.save(tmp_path / "five.dempfv")
    views = [getattr(sim.spheres, name) for name in OF_SPHERES] + list(of_network(sim).values())
    plain = [np.asarray(view) for view in views]
    sim.run(steps=3)
    values = [array.copy() for array in plain]
    sim.restore(tmp_path / "five.dempfv")
    assert sim.steps == 5
    for view in views:
        assert_stale(view)
    sim.run(steps=100)
    assert all(np.array_equal(array, value) for array, value in zip(plain, values))


def test_another_order_of_spheres_makes_views_stale():
    sim = dp.Simulation(
        {
            "box": {"min": [0, 0, 0], "max": [1, 1, 1]},
            "particles": {"cloud": {"count": 50, "porosity": 0.9}},
            "dem": {},
            "stage": [{"kind": "compact", "stress": 1e4}, {"kind": "run", "steps": 10}],
        }
    )
    position = sim.spheres.position
    where = address(position)
    sim.run(callback=lambda sim: sim.stage == "run")
    assert_stale(position)
    # The memory is the same: what lies there are the same spheres in another order.
    assert address(sim.spheres.position) == where


def test_views_outlive_their_simulation(wet):
    sim = dp.Simulation(wet)
    sim.run(steps=15)
    views = [sim.spheres.position, sim.pores.pressure, sim.throats.pores[1:]]
    values = [view.copy() for view in views]
    del sim
    gc.collect()
    rubbish = [np.full(100_000, 7.0) for _ in range(50)]
    assert all(np.array_equal(view, value) for view, value in zip(views, values))
    assert len(rubbish) == 50


def test_no_other_thread_looks_while_a_run_computes(dry):
    """Nor while its hooks are called: every look is refused until the run has ended."""
    dry["stage"][0]["steps"] = 1_000_000
    sim = dp.Simulation(dry)
    position = sim.spheres.position
    ways = {
        "a view": lambda: position[0],
        "a new view": lambda: sim.spheres.radius,
        "a number": lambda: sim.time,
        "a copy": lambda: sim.contacts,
        "a run": lambda: sim.run(steps=1),
        "a force": lambda: sim.add_force(print),
    }
    accepted, said, rounds = [], set(), []

    def look():
        for _ in range(40):
            for way, use in ways.items():
                try:
                    use()
                    accepted.append(way)
                except dp.SimulationError as error:
                    said.add(str(error))
            rounds.append(1)

    thread = threading.Thread(target=look)

    def begin(sim):
        if not thread.ident:
            thread.start()
        return not thread.is_alive()

    sim.run(callback=begin, every=50)
    assert len(rounds) == 40 and not accepted
    assert all("is running" in text for text in said)
    for use in ways.values():
        use()


def resident_bytes():
    with open("/proc/self/statm", encoding="ascii") as file:
        return int(file.read().split()[1]) * 4096
