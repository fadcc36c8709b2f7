"""Errors are exceptions with what they are about as attributes; nothing else crosses."""

import pickle

import dempfv as dp
import pytest


def test_a_scene_that_is_wrong(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text("title = 'x'\nsede = 1\n")
    with pytest.raises(dp.InputError) as caught:
        dp.Simulation(path)
    error = caught.value
    assert error.file == str(path) and error.line == 2
    assert error.remedy == "did you mean `seed`?" and error.remedy in str(error)
    assert error.step is error.sphere is error.pore is None
    assert isinstance(error, ValueError) and isinstance(error, dp.DempfvError)
    with pytest.raises(dp.InputError) as caught:
        dp.Simulation({"title": "x", "sede": 1})
    assert caught.value.file is None and caught.value.line is None
    assert caught.value.remedy == "did you mean `seed`?"


def test_keys_of_a_dict_are_named(dry):
    dry["particles"]["young"] = -1.0
    with pytest.raises(dp.InputError, match=r"`young` in \[particles\] is -1.0; give a number above 0 in Pa"):
        dp.Simulation(dry)
    dry["particles"]["young"] = object()
    with pytest.raises(dp.InputError, match="`particles.young` of the scene is of the type object"):
        dp.Simulation(dry)
    with pytest.raises(dp.InputError, match="of the scene is no text"):
        dp.Simulation({1: 2})
    with pytest.raises(dp.InputError, match="a scene of the type int"):
        dp.Simulation(7)


def test_texts_of_a_dict_arrive_as_they_are(dry):
    title = 'quotes " and \\ and \n and \x7f and é and 砂'
    sim = dp.Simulation(dry | {"title": title})
    assert sim.summary()["title"] == title


def test_a_step_that_fails_says_where(wet):
    """A fixed time step a thousand times too long throws spheres out of their box."""
    wet["dem"]["dt"] = 0.05
    sim = dp.Simulation(wet)
    with pytest.raises(dp.SimulationError) as caught:
        sim.run()
    error = caught.value
    assert error.step == sim.steps and f"step {error.step}" in str(error)
    assert error.sphere is None or 0 <= error.sphere < 200
    assert isinstance(error, RuntimeError)


def test_errors_can_be_pickled():
    with pytest.raises(dp.InputError) as caught:
        dp.Simulation({"sede": 1})
    error = pickle.loads(pickle.dumps(caught.value))
    assert str(error) == str(caught.value) and error.remedy == caught.value.remedy


def test_no_network_is_said(dry):
    sim = dp.Simulation(dry)
    sim.run(steps=1)
    assert len(sim.pores) == len(sim.throats) == 0
    with pytest.raises(dp.SimulationError, match="no pore network"):
        sim.pores.pressure  # noqa: B018


def test_threads_are_started_once(dry):
    dp.Simulation(dry).step()
    with pytest.raises(dp.SimulationError, match="have been started"):
        dp.set_threads(1)
