# The pore network of one packing and its static flow, as YADE has them.
#
# job: spheres ([x, y, z, r]), box (6), viscosity, pressure (per wall in Pa, or null),
# cases ([{slip, clamp}]), scales. Cells are numbered as YADE does; a cell's vertices
# are spheres from 0 and, after them, the walls in the order x_min, x_max, y_min, ...
import math

from yade import *

COUNT = len(job["spheres"])


def engine(case, scale):
    """YADE's flow engine on the packing at rest, one step taken: the network is
    built, the pressures and forces are computed, nothing moves."""
    O.reset()
    O.materials.append(FrictMat(young=1e6, poisson=0.5, frictionAngle=0, density=2600))
    low, high = (Vector3(job["box"][i : i + 3]) * scale for i in (0, 3))
    O.bodies.append(aabbWalls([low, high], thickness=0))
    for x, y, z, r in job["spheres"]:
        O.bodies.append(utils.sphere(Vector3(x, y, z) * scale, r * scale))
    flow = FlowEngine()
    flow.useSolver = 3
    flow.permeabilityFactor = 1
    flow.viscosity = job["viscosity"]
    flow.defTolerance = -1
    flow.meshUpdateInterval = 1000
    flow.boundaryUseMaxMin = [0] * 6
    flow.bndCondIsPressure = [p is not None for p in job["pressure"]]
    flow.bndCondValue = [p or 0 for p in job["pressure"]]
    flow.slipBoundary = case["slip"]
    flow.clampKValues = case["clamp"]
    O.engines = [ForceResetter(), flow]
    O.dt = 1e-12
    O.step()
    return flow


def vertex(body):
    """YADE numbers the six walls first."""
    return body - 6 if body >= 6 else COUNT + body


def cells_of(flow):
    every = range(flow.nCells())
    return [[vertex(v) for v in flow.getVertices(i)] for i in every]


def volume(flow, i):
    """A pore's volume is asked for by a point in it. A flat pore may not hold the
    rounded mean of its vertices: then nothing is known of it."""
    at = flow.getCellBarycenter(i)
    return flow.getCellVolume(at) if flow.getCell(*at) == i else None


def solution(flow, case):
    every = range(flow.nCells())
    # Regular lattices, whose pores have the same centres.
    if not all(math.isfinite(flow.getCellPressure(i)) for i in every):
        raise RuntimeError(f"YADE finds no finite pressures with {case}")
    return dict(
        case,
        conductance=[[flow.getConductivity(i, k) for k in range(4)] for i in every],
        pressure=[flow.getCellPressure(i) for i in every],
        flux=[flow.getBoundaryFlux(i) for i in range(6)],
        force=[list(flow.fluidForce(6 + i)) for i in range(COUNT)],
        porosity=repr(flow.porosity),
    )


def network():
    result = dict(cases=[], scaled=[])
    for case in job["cases"]:
        flow = engine(case, 1)
        cells = cells_of(flow)
        if "cells" not in result:
            every = range(len(cells))
            result["cells"] = cells
            result["neighbors"] = [list(flow.getNeighbors(i)) for i in every]
            result["center"] = [list(flow.getCellCenter(i)) for i in every]
            result["volume"] = [volume(flow, i) for i in every]
            result["imposed"] = [bool(flow.getCellPImposed(i)) for i in every]
        if cells != result["cells"]:
            raise RuntimeError("two triangulations of the same packing differ")
        result["cases"].append(solution(flow, case))
    for scale in job["scales"]:
        for clamp in (False, True):
            flow = engine(dict(slip=True, clamp=clamp), scale)
            flux = [flow.getBoundaryFlux(i) for i in range(6)]
            result["scaled"].append(dict(scale=scale, clamp=clamp, flux=flux))
    return result


finish(network())
