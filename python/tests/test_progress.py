"""A bar where somebody sees it, and none elsewhere."""

import sys
import time
import types

import dempfv as dp
import pytest


class Recorder:
    """What a run asks of tqdm."""

    made = []

    def __init__(self, total, unit, leave):
        self.total, self.n, self.closed, self.said = total, 0, False, []
        Recorder.made.append(self)

    def set_description(self, text, refresh):
        self.said.append(text)

    def update(self, steps):
        assert steps >= 0
        self.n += steps

    def close(self):
        self.closed = True


@pytest.fixture
def tqdm(monkeypatch):
    auto = types.ModuleType("tqdm.auto")
    auto.tqdm = Recorder
    monkeypatch.setitem(sys.modules, "tqdm", types.ModuleType("tqdm"))
    monkeypatch.setitem(sys.modules, "tqdm.auto", auto)
    Recorder.made = []
    return Recorder


def run_until(sim, condition, **keys):
    """Runs until the condition holds: as long as a bar takes to come, however fast the machine is."""
    return sim.run(callback=lambda sim: condition(), every=100, **keys)


def test_a_bar_that_is_asked_for(dry, tqdm):
    dry["stage"][0]["steps"] = 10_000_000
    sim = dp.Simulation(dry)
    seen = lambda: bool(tqdm.made) and tqdm.made[0].n > 0  # noqa: E731
    done = run_until(sim, seen, steps=9_000_000, progress=True)
    (bar,) = tqdm.made
    assert bar.total == 9_000_000 and 0 < bar.n <= done and bar.closed
    assert bar.said[0].startswith("run")


def test_no_bar_where_nobody_sees_it(dry, tqdm, capfd):
    dry["stage"][0]["steps"] = 10_000_000
    sim = dp.Simulation(dry)
    # Longer than a bar takes to come.
    end = time.monotonic() + 1.5
    run_until(sim, lambda: time.monotonic() > end)
    run_until(sim, lambda: True, progress=False)
    assert not tqdm.made
    assert capfd.readouterr() == ("", "")


def test_a_bar_without_tqdm_is_told(dry, monkeypatch):
    monkeypatch.setitem(sys.modules, "tqdm", None)
    dry["stage"][0]["steps"] = 10_000_000
    sim = dp.Simulation(dry)
    with pytest.raises(dp.InputError, match=r"a bar needs tqdm; install it \(pip install tqdm\)"):
        sim.run(progress=True)
    # Not asked for, it is not missed.
    sim.run(steps=10)
