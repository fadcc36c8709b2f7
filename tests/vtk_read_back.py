"""Reads the program's VTK files with the reader that ParaView uses.

    vtk_read_back.py SAMPLE [RESULT ...]

SAMPLE holds the frames of `cargo run --example vtk_sample`: every number in
them follows from its index and is compared. Each RESULT is a folder of a run
with .pvd files: every frame must open, without a word from VTK, and be sound.
"""

import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkOutputWindow, vtkStringOutputWindow
from vtkmodules.vtkFiltersVerdict import vtkCellSizeFilter
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

VERTEX, TETRA, HEXAHEDRON, WEDGE = 1, 10, 12, 13

messages = vtkStringOutputWindow()
vtkOutputWindow.SetInstance(messages)
passed = failed = 0


def check(name, good, detail=""):
    """Counts a check; says which one failed."""
    global passed, failed
    if good:
        passed += 1
    else:
        failed += 1
        print(f"FAILED: {name} {detail}")


def equal(name, found, expected):
    found, expected = np.asarray(found), np.asarray(expected)
    good = found.shape == expected.shape and np.array_equal(found, expected)
    check(name, good, f"\n  found    {found[:3]}\n  expected {expected[:3]}")


def read(path):
    """The grid of a .vtu file; any message of VTK is a failure."""
    reader = vtkXMLUnstructuredGridReader()
    check(f"{path.name}: VTK can read it", reader.CanReadFile(str(path)))
    reader.SetFileName(str(path))
    before = messages.GetOutput() or ""
    reader.Update()
    said = (messages.GetOutput() or "")[len(before):]
    check(f"{path.name}: VTK has nothing to say", not said, said)
    return reader.GetOutput()


def array(data, name):
    found = data.GetArray(name)
    return np.empty(0) if found is None else vtk_to_numpy(found)


def points_of(grid):
    return vtk_to_numpy(grid.GetPoints().GetData())


def cell_types(grid):
    return np.array([grid.GetCellType(i) for i in range(grid.GetNumberOfCells())])


def vtk_volumes(grid):
    """Cells' volumes as VTK finds them; negative for a reversed cell."""
    sizes = vtkCellSizeFilter()
    sizes.SetInputData(grid)
    sizes.Update()
    return array(sizes.GetOutput().GetCellData(), "Volume")


def faces_point_outward(grid, i):
    """Every face of a cell must turn counter-clockwise seen from outside."""
    cell = grid.GetCell(i)
    corners = vtk_to_numpy(cell.GetPoints().GetData())
    centre = corners.mean(axis=0)
    for k in range(cell.GetNumberOfFaces()):
        x = vtk_to_numpy(cell.GetFace(k).GetPoints().GetData())
        diagonals = (x[2] - x[0], x[-1] - x[1] if len(x) == 4 else x[1] - x[0])
        normal = np.cross(*diagonals) * (1 if len(x) == 4 else -1)
        if normal @ (x.mean(axis=0) - centre) <= 0:
            return False
    return True


def frames(collection):
    """(time, path) of each frame of a .pvd file."""
    entries = ET.parse(collection).getroot().findall("Collection/DataSet")
    return [(float(e.get("timestep")), collection.parent / e.get("file")) for e in entries]


def check_sample_spheres(time, path):
    grid, label = read(path), path.name
    i = np.arange(999, -1, -1)
    x = i.astype(float)
    data = grid.GetPointData()
    equal(f"{label}: points", points_of(grid), np.c_[x, x / 7 + time, -np.sqrt(x)])
    equal(f"{label}: cells", cell_types(grid), np.full(1000, VERTEX))
    equal(f"{label}: id", array(data, "id"), i)
    equal(f"{label}: radius", array(data, "radius"), 1e-3 * (x + 1))
    equal(f"{label}: velocity", array(data, "velocity"), np.c_[0 * x + time, -x, 1 / (x + 1)])
    equal(f"{label}: force", array(data, "force"), np.c_[1e-300 * x, x * x, 0 * x + 1e300 * time])


def check_sample_pores(time, path):
    grid, label = read(path), path.name
    n = 50
    height = np.repeat(1 + np.arange(n) / 10, 3)
    share = np.tile([1 / 6, 1 / 2, 1], n)
    data = grid.GetCellData()
    equal(f"{label}: points", [grid.GetNumberOfPoints()], [8 * n])
    equal(f"{label}: cell types", cell_types(grid), np.tile([TETRA, WEDGE, HEXAHEDRON], n))
    equal(f"{label}: pressure", array(data, "pressure"), 1000 * np.arange(3 * n) / 7 + time)
    error = np.abs(vtk_volumes(grid) - height * share).max()
    check(f"{label}: VTK's volumes, positive", error < 1e-12, f"error {error}")
    error = np.abs(array(data, "volume") - height * share).max()
    check(f"{label}: our volumes", error < 1e-12, f"error {error}")
    outward = all(faces_point_outward(grid, i) for i in range(3 * n))
    check(f"{label}: all faces point outward", outward)


def check_sound(path):
    """What holds for a frame of any run."""
    grid, label = read(path), path.name
    check(f"{label}: not empty", grid.GetNumberOfPoints() and grid.GetNumberOfCells())
    groups = [(grid.GetPointData(), grid.GetNumberOfPoints()),
              (grid.GetCellData(), grid.GetNumberOfCells())]
    for data, count in groups:
        for k in range(data.GetNumberOfArrays()):
            values = vtk_to_numpy(data.GetArray(k))
            good = len(values) == count and np.isfinite(values).all()
            check(f"{label}: {data.GetArrayName(k)}: one finite value each", good)
    ours = array(grid.GetCellData(), "volume")
    if len(ours):
        theirs = vtk_volumes(grid)
        error = np.abs(theirs - ours).max() / np.abs(ours).max()
        check(f"{label}: volumes agree with VTK's", error < 1e-9, f"to {error} of the largest")
        solid = [i for i in range(len(ours)) if theirs[i] > 1e-9 * theirs.mean()]
        outward = all(faces_point_outward(grid, i) for i in solid)
        check(f"{label}: all faces point outward", outward)


def main(sample, *results):
    sample = Path(sample)
    for name, check_frame in [("spheres", check_sample_spheres), ("pores", check_sample_pores)]:
        found = frames(sample / f"{name}.pvd")
        equal(f"{name}.pvd: times", [t for t, _ in found], [0, 0.125, 0.25])
        for time, path in found:
            check_frame(time, path)
    for folder in map(Path, results):
        collections = sorted(folder.rglob("*.pvd"))
        check(f"{folder}: has .pvd files", collections)
        for collection in collections:
            found = frames(collection)
            times = [t for t, _ in found]
            check(f"{collection.name}: has frames in order of time", times and times == sorted(times))
            for _, path in found:
                check_sound(path)
    print(f"{passed} passed, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
