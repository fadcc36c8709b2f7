"""Runs: the same as the program's, ended when asked for, and usable afterwards."""

import json
import os
import signal
import subprocess
import threading
import time

import dempfv as dp
import pytest

TOML = """
title = "a test"
[box]
min = [0, 0, 0]
max = [0.01, 0.01, 0.01]
[particles]
cloud = { count = 200, porosity = 0.8 }
density = 2600.0
young = 1e6
[dem]
gravity = [0, -9.81, 0]
[fluid]
viscosity = 1e-3
pressure = { y_min = 1.0, y_max = 0.0 }
remesh_interval = 10
[[stage]]
kind = "run"
steps = 400
"""


@pytest.fixture
def scene_file(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(TOML)
    return path


def test_a_dict_is_the_same_scene_as_a_file(scene_file, wet):
    one, other = dp.Simulation(scene_file), dp.Simulation(wet)
    assert one.run(steps=50) == other.run(steps=50) == 50
    assert one.state_hash == other.state_hash
    assert one.scene == other.scene


def test_the_program_gives_the_same_hash(scene_file, tmp_path):
    program = os.environ.get("DEMPFV_PROGRAM")
    if program is None:
        pytest.skip("DEMPFV_PROGRAM names no program to compare with; make python-test does")
    out = tmp_path / "out"
    subprocess.run([program, "run", scene_file, "--out", out], check=True, capture_output=True)
    summary = json.loads((out / "summary.json").read_text())
    sim = dp.Simulation(scene_file)
    sim.run()
    assert sim.state_hash == summary["state_hash"]
    ours = sim.summary()
    for key in ("particles", "pores", "unknowns", "contacts", "steps", "model_time_s", "remeshes", "effects"):
        assert ours[key] == summary[key], key
    assert ours["energy"] == summary["energy"]
    assert [stage["name"] for stage in ours["stages"]] == [stage["name"] for stage in summary["stages"]]
    # And the program goes on from ours.
    half = dp.Simulation(scene_file)
    half.run(steps=130)
    half.save(tmp_path / "half.dempfv")
    onward = [program, "run", scene_file, "--restart", tmp_path / "half.dempfv", "--out", tmp_path / "onward"]
    subprocess.run(onward, check=True, capture_output=True)
    assert json.loads((tmp_path / "onward" / "summary.json").read_text())["state_hash"] == sim.state_hash


def test_what_ends_a_run(dry):
    sim = dp.Simulation(dry)
    assert sim.run(steps=7) == 7 and sim.steps == 7
    assert sim.run(steps=0) == 0
    assert sim.step() is True and sim.steps == 8
    until = sim.time + 10.5 * sim.dt
    assert sim.run(until=until) == 11 and sim.time >= until
    calls = []
    assert sim.run(steps=20, callback=lambda sim: calls.append(sim.steps), every=6) == 20
    assert calls == [25, 31, 37]
    assert sim.run(steps=0, callback=print, every=2**64 - 1) == 0
    assert sim.run(callback=lambda sim: sim.steps >= 50) == 11
    assert sim.run() == 350
    assert sim.finished and sim.stage is None and sim.run() == 0 and sim.step() is False


def test_stretches_change_no_bit(wet):
    whole = dp.Simulation(wet)
    whole.run()
    steps = dp.Simulation(wet)
    while steps.step():
        pass
    called = dp.Simulation(wet)
    called.run(callback=lambda sim: None)
    assert whole.state_hash == steps.state_hash == called.state_hash


def test_checkpoints(wet, tmp_path):
    whole = dp.Simulation(wet)
    whole.run()
    sim = dp.Simulation(wet)
    sim.run(steps=133)
    sim.save(tmp_path / "a.dempfv")
    sim.run(steps=50)
    sim.restore(tmp_path / "a.dempfv")
    sim.run()
    other = dp.restore(tmp_path / "a.dempfv")
    assert other.steps == 133
    other.run()
    changed = dp.restore(tmp_path / "a.dempfv", wet | {"dem": {"gravity": [0, 9.81, 0]}})
    changed.run()
    assert whole.state_hash == sim.state_hash == other.state_hash != changed.state_hash
    with pytest.raises(dp.InputError, match="no such checkpoint") as caught:
        sim.restore(tmp_path / "b.dempfv")
    assert caught.value.file.endswith("b.dempfv")
    # As if nobody had tried.
    assert sim.state_hash == whole.state_hash


def test_ctrl_c_ends_between_two_steps(dry):
    dry["stage"][0]["steps"] = 300_000
    sim = dp.Simulation(dry)
    sim.step()
    threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT)).start()
    with pytest.raises(KeyboardInterrupt):
        sim.run()
    steps = sim.steps
    assert 1 < steps < 300_000
    sim.run(steps=10)
    other = dp.Simulation(dry)
    other.run(steps=steps + 10)
    assert other.state_hash == sim.state_hash


def test_other_threads_go_on(dry):
    """A thread that counts gets its share of the time of a run: the interpreter is free."""
    dry["stage"][0]["steps"] = 1_000_000
    sim = dp.Simulation(dry)
    counted, stop = [0], threading.Event()

    def count():
        while not stop.is_set():
            counted[0] += 1
            time.sleep(0.0005)

    thread = threading.Thread(target=count)
    thread.start()
    sim.run(until=0.0, steps=1)
    before = counted[0]
    sim.run(callback=lambda sim: counted[0] > before + 50, every=10_000)
    stop.set()
    thread.join()
    assert counted[0] > before + 50


def test_two_simulations_in_two_threads(dry):
    dry["stage"][0]["steps"] = 2000
    sims = [dp.Simulation(dry) for _ in range(3)]
    threads = [threading.Thread(target=sim.run) for sim in sims[:2]]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    sims[2].run()
    assert sims[0].state_hash == sims[1].state_hash == sims[2].state_hash


def test_what_it_says_of_itself(wet):
    sim = dp.Simulation(wet)
    assert repr(sim).startswith("<dempfv.Simulation 'a test': 200 spheres, no pore network yet; step 0, ")
    sim.run(steps=10)
    assert f"{len(sim.pores)} pores" in repr(sim) and "stage 'run'" in repr(sim)
    html = sim._repr_html_()
    assert html.startswith("<table>") and len(html) < 500
    seen = sim.observe()
    assert seen["step"] == 10 and seen["time_s"] == sim.time and seen["stage"] == "run"
    assert "pore flow" in sim.effects
    assert set(sim.energy) >= {"translation", "friction", "elastic"}
    assert "steps = 400" in sim.scene


def test_walls_and_contacts():
    sim = dp.Simulation(
        {
            "box": {"min": [0, 0, 0], "max": [1, 1, 1]},
            "particles": {"cloud": {"count": 100, "porosity": 0.9}},
            "dem": {},
            "stage": [{"kind": "compact", "stress": 1e4}],
        }
    )
    sim.run()
    walls, contacts = sim.walls, sim.contacts
    n = len(sim.spheres)
    assert walls.names == ["x_min", "x_max", "y_min", "y_max", "z_min", "z_max"]
    # The stage ends within 1 % of its stress, as the mean of six walls.
    assert walls.stress.mean() == pytest.approx(1e4, rel=0.02)
    assert len(contacts) == sim.summary()["contacts"]
    # Forces of contacts on spheres are those of the steps: the sum over a sphere's contacts.
    total = 0.0 * sim.spheres.position
    for (i, j), force in zip(contacts.pairs, contacts.force):
        total[i] -= force
        if j < n:
            total[j] += force
    assert abs(total - sim.spheres.force).max() < 1e-6 * abs(contacts.force).max()
    on_walls = contacts.pairs[:, 1] >= n
    for k in range(6):
        of_wall = contacts.force[on_walls & (contacts.pairs[:, 1] == n + k)].sum(axis=0)
        assert of_wall == pytest.approx(walls.force[k], rel=1e-6, abs=1e-6 * abs(walls.force).max())
    # Overlaps are those of the positions.
    x, r = sim.spheres.position, sim.spheres.radius
    i, j = contacts.pairs[~on_walls].T
    gap = ((x[i] - x[j]) ** 2).sum(axis=1) ** 0.5 - r[i] - r[j]
    assert contacts.overlap[~on_walls] == pytest.approx(-gap, abs=1e-12)
