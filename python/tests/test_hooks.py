"""What users do in each step."""

import gc
import threading
import weakref

import dempfv as dp
import numpy as np
import pytest

from conftest import scene_of


def far_apart(**tables):
    """Spheres that never touch, without gravity and damping."""
    particles = {"cloud": {"count": 20, "porosity": 0.99}, "density": 2600.0, "young": 1e6}
    return scene_of(particles=particles, dem={"dt": 1e-6, "damping": 0.0}, **tables)


def test_a_force_accelerates(tmp_path):
    """Constant F and T on free spheres at rest: v = F t / m and ω = T t / (2/5 m r²), the leapfrog's first
    velocities being those of half a step before."""
    sim = dp.Simulation(far_apart())
    force = np.random.default_rng(1).normal(size=(20, 3)) * 1e-6
    torque = np.random.default_rng(2).normal(size=(20, 3)) * 1e-10

    def constant(sim):
        # By the user's numbers, whatever the order of rows.
        return force[sim.spheres.number], torque[sim.spheres.number]

    sim.add_force(constant)
    sim.run(steps=50)
    spheres = sim.spheres
    m, r, row = spheres.mass[:, None].copy(), spheres.radius[:, None].copy(), spheres.number.copy()
    t = sim.time
    assert spheres.velocity == pytest.approx(force[row] * t / m, rel=1e-9)
    assert spheres.spin == pytest.approx(torque[row] * t / (0.4 * m * r * r), rel=1e-9)
    kinetic = sim.energy["translation"] + sim.energy["rotation"]
    assert sim.energy["external_work"] == pytest.approx(kinetic, rel=1e-2)
    # It goes on after a restore, and ends when it is removed.
    sim.save(tmp_path / "a.dempfv")
    sim.restore(tmp_path / "a.dempfv")
    sim.run(steps=50)
    t = sim.time
    assert sim.spheres.velocity == pytest.approx(force[row] * t / m, rel=1e-9)
    sim.remove_hooks()
    before = sim.spheres.velocity.copy()
    sim.run(steps=5)
    assert np.array_equal(sim.spheres.velocity, before)


def test_a_force_of_the_velocity_is_the_exact_recurrence():
    """F = -c v with the velocities of before the step: v_n+1 = v_n (1 - c Δt / m), once each step."""
    sim = dp.Simulation(far_apart())
    sim.run(steps=1, callback=lambda sim: sim.spheres.velocity.__setitem__(slice(None), 1e-3))
    c = 1e-3 * sim.spheres.mass[:, None] / sim.dt
    sim.add_force(lambda sim: -c * sim.spheres.velocity)
    sim.run(steps=30)
    assert sim.spheres.velocity == pytest.approx(np.full((20, 3), 1e-3 * (1 - 1e-3) ** 30), rel=1e-12)


def test_several_forces_add_up_and_none_is_none():
    sims = [dp.Simulation(far_apart()) for _ in range(2)]
    for force in (1e-7, 2e-7):
        sims[0].add_force(lambda sim, force=force: np.full((20, 3), force))
    sims[0].add_force(lambda sim: None)
    sims[1].add_force(lambda sim: (np.full((20, 3), 3e-7, dtype=np.float32).astype(float), None))
    for sim in sims:
        sim.run(steps=10)
    assert sims[0].spheres.velocity == pytest.approx(np.asarray(sims[1].spheres.velocity), rel=1e-6)


def test_a_force_that_is_added_in_a_hook_acts_at_once():
    sim = dp.Simulation(far_apart())

    def add(sim):
        if sim.steps == 3:
            sim.add_force(lambda sim: np.ones((20, 3)) * sim.spheres.mass[:, None])

    sim.run(steps=8, callback=add)
    assert sim.spheres.velocity == pytest.approx(np.full((20, 3), 5 * sim.dt), rel=1e-9)


@pytest.mark.parametrize("remesh", ["at once", "ahead", "background"])
def test_a_pressure_of_ones_own_is_that_of_the_scene(wet, remesh):
    """A function of time from Python and the same in the scene: the same bits, through remeshes."""
    ramp = {"ramp": [[0.0, 1.0], [1.0, 1001.0]]}
    wet["fluid"]["remesh"] = remesh
    wet["dem"]["dt"] = 1e-5
    wet["stage"][0]["steps"] = 60
    scene = dp.Simulation(wet | {"fluid": wet["fluid"] | {"pressure": {"y_min": ramp, "y_max": 0.0}}})
    hook = dp.Simulation(wet)
    constant = dp.Simulation(wet)

    def pressure(sim):
        # The pressure of a step is that at its end; the same operations as the scene's ramp.
        t = sim.time + 1e-5
        return 1.0 + (1001.0 - 1.0) * ((t - 0.0) / (1.0 - 0.0))

    hook.set_pressure("y_min", pressure)
    for sim in (scene, hook, constant):
        sim.run()
    assert scene.remeshes == hook.remeshes > 3
    assert scene.state_hash == hook.state_hash != constant.state_hash


def test_a_pressure_of_a_region(wet, tmp_path):
    region = {"center": [0.005, 0.005, 0.005], "radius": 0.002, "pressure": 5.0}
    wet["fluid"]["imposed"] = [region]
    sim = dp.Simulation(wet)
    sim.set_pressure(0, 9.0)
    sim.run(steps=25)
    imposed = sim.pores.pressure[sim.pores.imposed]
    assert set(np.unique(imposed)) == {0.0, 1.0, 9.0}
    # Also after a restore.
    sim.save(tmp_path / "a.dempfv")
    sim.restore(tmp_path / "a.dempfv")
    sim.run(steps=1)
    assert 9.0 in sim.pores.pressure and 5.0 not in sim.pores.pressure


@pytest.mark.parametrize("remesh", ["at once", "ahead", "background"])
def test_conductances_of_ones_own_are_those_of_the_scene(wet, remesh):
    """Pores blocked and widened by a function, and by regions of the scene: the same bits."""
    low = {"min": [0, 0, 0], "max": [0.003, 0.01, 0.01]}
    high = {"min": [0.007, 0, 0], "max": [0.01, 0.01, 0.01]}
    wet["fluid"]["remesh"] = remesh
    wet["stage"][0]["steps"] = 60
    regions = {"blocked": [low], "conductance_regions": [high | {"factor": 3.0}]}
    scene = dp.Simulation(wet | {"fluid": wet["fluid"] | regions})
    hook, plain = dp.Simulation(wet), dp.Simulation(wet)

    def factors(pores):
        x = pores.centroid[:, 0]
        return np.where(x <= 0.003, 0.0, np.where(x >= 0.007, 3.0, 1.0))

    hook.set_conductance(factors)
    for sim in (scene, hook, plain):
        sim.run()
    assert scene.remeshes == hook.remeshes > 3
    assert scene.state_hash == hook.state_hash != plain.state_hash


@pytest.mark.parametrize("remesh", ["at once", "background"])
def test_a_choice_of_conductances_that_fails(wet, tmp_path, remesh):
    wet["fluid"]["remesh"] = remesh
    sim = dp.Simulation(wet, out=tmp_path)
    error = Mine("wrong")
    calls = []

    def fail(pores):
        calls.append(len(pores.volume))
        if len(calls) > 2:
            raise error

    sim.set_conductance(fail)
    with pytest.raises(Mine) as caught:
        sim.run()
    assert caught.value is error and len(calls) == 3
    sim.set_conductance(lambda pores: pores.volume * 0.0 - 1.0)
    with pytest.raises(dp.InputError, match="the factor of pore 0 is -1"):
        sim.run()
    sim.set_conductance(None)
    assert sim.run(steps=5) == 5
    assert dp.restore(tmp_path / "checkpoint.dempfv").steps < sim.steps


def test_a_simulation_with_a_choice_under_way_can_be_dropped(wet):
    """The background may wait for the interpreter while the simulation waits for it."""
    wet["fluid"]["remesh"] = "background"
    for _ in range(10):
        sim = dp.Simulation(wet)
        sim.set_conductance(lambda pores: np.ones(len(pores.volume)))
        sim.run(steps=7)
        del sim
        gc.collect()


class Mine(Exception):
    """An error of a user's own."""


@pytest.mark.parametrize("kind", ["callback", "force", "pressure"])
def test_what_a_hook_raises_comes_out(wet, tmp_path, kind):
    """The same object, with its own traceback; the simulation can be saved, and a checkpoint is there."""
    sim = dp.Simulation(wet, out=tmp_path / "out")
    error = Mine("wrong")

    def fail(sim):
        if sim.steps >= 12:
            raise error
        return 1.0 if kind == "pressure" else None

    if kind == "force":
        sim.add_force(fail)
    elif kind == "pressure":
        sim.set_pressure("y_min", fail)
    with pytest.raises(Mine) as caught:
        sim.run(callback=fail if kind == "callback" else None)
    assert caught.value is error
    assert caught.traceback[-1].name == "fail"
    assert sim.steps == 12
    kept = dp.restore(tmp_path / "out" / "checkpoint.dempfv")
    assert kept.state_hash == sim.state_hash
    sim.save(tmp_path / "saved.dempfv")
    sim.remove_hooks()
    assert sim.run(steps=5) == 5
    again = dp.restore(tmp_path / "saved.dempfv")
    again.run(steps=5)
    assert again.state_hash == sim.state_hash


def test_a_failure_keeps_the_last_sound_state(dry, tmp_path):
    dry["dem"]["dt"] = 1e-5
    sim = dp.Simulation(dry, out=tmp_path)

    def hurl(sim):
        if sim.steps == 20:
            sim.spheres.velocity[7] = 1e7

    with pytest.raises(dp.SimulationError, match="has gone through the wall") as caught:
        sim.run(callback=hurl)
    assert caught.value.sphere == sim.spheres.number[7] and caught.value.step >= 20
    assert dp.restore(tmp_path / "checkpoint.dempfv").steps == 0


def test_no_checkpoint_is_said(dry, tmp_path):
    """Where it cannot be written, the user's error is the one that comes out, with a note."""
    (tmp_path / "file").write_text("")
    sim = dp.Simulation(dry, out=tmp_path / "file" / "out")
    with pytest.raises(Mine) as caught:
        sim.run(callback=lambda sim: (_ for _ in ()).throw(Mine()))
    assert any("no checkpoint was kept" in note for note in caught.value.__notes__)


@pytest.mark.parametrize(
    ("returned", "message"),
    [
        (np.zeros((19, 3)), r"shape \[19, 3\] for 20 spheres"),
        (np.zeros((20, 2)), r"shape \[20, 2\] for 20 spheres"),
        (np.zeros(20), r"shape \(20,\)"),
        ("a force", "no array of numbers"),
        ((np.zeros((20, 3)), np.zeros(3)), r"shape \(3,\)"),
        (np.full((20, 3), np.nan), "the force or torque of `.*` is not finite"),
    ],
)
def test_forces_that_are_none(returned, message):
    sim = dp.Simulation(far_apart())
    sim.add_force(lambda sim: returned)
    with pytest.raises(dp.DempfvError, match=message):
        sim.run(steps=1)
    assert sim.steps == 0
    sim.remove_hooks()
    sim.run(steps=1)


def test_what_makes_no_sense_is_refused(wet):
    sim = dp.Simulation(wet)
    for refused, message in [
        (lambda: sim.add_force(3), "cannot be called"),
        (lambda: sim.set_pressure("top", 1.0), "unknown wall `top`"),
        (lambda: sim.set_pressure(-1, 1.0), "no wall and no number"),
        (lambda: sim.set_pressure("y_min", float("nan")), "no finite number"),
        (lambda: sim.set_pressure("y_min", "1"), "no finite number"),
        (lambda: sim.run(every=0), "every = 0"),
        (lambda: sim.run(until=float("nan")), "not a number"),
        (lambda: sim.run(callback=1), "cannot be called"),
    ]:
        with pytest.raises(dp.InputError, match=message):
            refused()
    sim.set_pressure("x_min", 1.0)
    with pytest.raises(dp.SimulationError, match="imposes none"):
        sim.run(steps=1)


def test_a_hook_cannot_run_nor_restore(dry, tmp_path):
    sim = dp.Simulation(dry)
    sim.save(tmp_path / "a.dempfv")

    def nested(sim):
        restore = lambda: sim.restore(tmp_path / "a.dempfv")  # noqa: E731
        for refused in (lambda: sim.run(steps=1), sim.step, restore):
            with pytest.raises(dp.SimulationError, match="running"):
                refused()
        sim.save(tmp_path / "b.dempfv")

    sim.run(steps=3, callback=nested)
    assert dp.restore(tmp_path / "b.dempfv").steps == 3


def test_a_simulation_that_its_hooks_know_is_collected(dry):
    sim = dp.Simulation(dry)
    sim.add_force(lambda _: 0.0 * sim.spheres.velocity)
    sim.run(steps=2)
    gone = weakref.ref(sim)
    del sim
    gc.collect()
    assert gone() is None


def test_ten_thousand_steps_with_hooks_leave_memory_flat():
    scene = far_apart(stage=[{"kind": "run", "steps": 30_000}])
    sim = dp.Simulation(scene)
    sim.add_force(lambda sim: -1e-9 * sim.spheres.velocity)
    looked = []

    def look(sim):
        sim.spheres.position[0].sum()
        looked[:] = [sim.time]

    sim.run(steps=5_000, callback=look, progress=False)
    gc.collect()
    before = resident_bytes()
    sim.run(steps=10_000, callback=look, progress=False)
    gc.collect()
    # A leak of one small array a step would be 1 MB at least.
    assert resident_bytes() - before < 5e5


def test_callbacks_are_called_in_the_thread_of_the_run(dry):
    sim = dp.Simulation(dry)
    threads = set()
    run = lambda: sim.run(steps=20, callback=lambda sim: threads.add(threading.get_ident()))  # noqa: E731
    thread = threading.Thread(target=run)
    thread.start()
    thread.join()
    assert threads == {thread.ident}


def resident_bytes():
    with open("/proc/self/statm", encoding="ascii") as file:
        return int(file.read().split()[1]) * 4096
