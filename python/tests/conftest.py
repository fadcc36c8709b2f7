"""What the tests share. They run against the installed package, never the source tree."""

from pathlib import Path

import dempfv
import pytest

SOURCES = Path(__file__).resolve().parents[1]


def pytest_sessionstart(session):
    installed = Path(dempfv.__file__).resolve()
    assert SOURCES not in installed.parents, f"{installed} is of the source tree: install the wheel"


def scene_of(**tables):
    """A scene of 200 loose spheres in a box of 10 mm."""
    scene = {
        "title": "a test",
        "box": {"min": [0, 0, 0], "max": [0.01, 0.01, 0.01]},
        "particles": {"cloud": {"count": 200, "porosity": 0.8}, "density": 2600.0, "young": 1e6},
        "dem": {},
        "stage": [{"kind": "run", "steps": 400}],
    }
    scene.update(tables)
    return scene


@pytest.fixture
def dry():
    """Spheres that fall."""
    return scene_of(dem={"gravity": [0, -9.81, 0]})


@pytest.fixture
def wet():
    """Spheres in water that leaves through the top, with a new network every 10 steps."""
    fluid = {"viscosity": 1e-3, "pressure": {"y_min": 1.0, "y_max": 0.0}, "remesh_interval": 10}
    return scene_of(dem={"gravity": [0, -9.81, 0]}, fluid=fluid)
