# Injection into one packing at rest, as YADE has it: pores above a level are held at zero
# pressure, the bottom at another; then the start of the flow of a compressible fluid, and the
# steady flow through a Darcy medium.
#
# job: spheres ([x, y, z, r]), box (6), viscosity, pressure (of y_min in Pa), level (y in m),
# bulk_modulus (Pa), dt (s), looks (steps after which the compressible flow is looked at), mobility
# (m²/(Pa·s)), cases (which are wanted). Cells are numbered and named as by network.py.
from yade import *

COUNT = len(job["spheres"])
Y_MIN, Y_MAX = 2, 3


def engine(modulus, closed, factor=1):
    O.reset()
    O.materials.append(FrictMat(young=1e6, poisson=0.5, frictionAngle=0, density=2600))
    low, high = (Vector3(job["box"][i : i + 3]) for i in (0, 3))
    O.bodies.append(aabbWalls([low, high], thickness=0))
    for x, y, z, r in job["spheres"]:
        O.bodies.append(utils.sphere(Vector3(x, y, z), r))
    flow = FlowEngine()
    flow.useSolver = 3
    flow.permeabilityFactor = factor
    flow.viscosity = job["viscosity"]
    flow.defTolerance = -1
    flow.meshUpdateInterval = 100000
    flow.boundaryUseMaxMin = [0] * 6
    flow.bndCondIsPressure = [False, False, True, not closed, False, False]
    flow.bndCondValue = [0, 0, job["pressure"], 0, 0, 0]
    flow.clampKValues = False
    flow.iniVoidVolumes = True
    if modulus:
        flow.fluidBulkModulus = modulus
    O.engines = [ForceResetter(), flow]
    O.dt = job["dt"]
    O.step()
    return flow


def vertex(body):
    """YADE numbers the six walls first."""
    return body - 6 if body >= 6 else COUNT + body


def cells_of(flow):
    every = range(flow.nCells())
    cells = [[vertex(v) for v in flow.getVertices(i)] for i in every]
    return dict(cells=cells, void=[1 / flow.getCellInvVoidVolume(i) for i in every])


def injection():
    flow = engine(0, True)
    every = range(flow.nCells())
    held = [i for i in every if flow.getCellBarycenter(i)[1] >= job["level"]]
    for i in held:
        flow.setCellPImposed(i, True)
        flow.setCellPressure(i, 0)
    O.step()
    return dict(
        cells_of(flow),
        held=held,
        pressure=[flow.getCellPressure(i) for i in every],
        entering=-flow.getBoundaryFlux(Y_MIN),
        leaving=-sum(flow.getCellFluxFromId(i) for i in held),
    )


def compression():
    flow = engine(job["bulk_modulus"], False)
    every = range(flow.nCells())
    looks, done = [], 1
    for look in job["looks"]:
        for _ in range(look - done):
            O.step()
        done = look
        pressure = [flow.getCellPressure(i) for i in every]
        looks.append(dict(pressure=pressure, flux=[-flow.getBoundaryFlux(wall) for wall in (Y_MIN, Y_MAX)]))
    return dict(cells_of(flow), looks=looks)


def darcy():
    # A negative factor is a mobility.
    flow = engine(0, False, -job["mobility"])
    return [-flow.getBoundaryFlux(wall) for wall in (Y_MIN, Y_MAX)]


CASES = dict(injection=injection, compression=compression, darcy=darcy)
finish({case: CASES[case]() for case in job["cases"]})
