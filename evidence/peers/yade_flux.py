"""Flux from y_min (1 Pa) to y_max (0) through a packing at rest, by YADE's flow engine, with its clamp
of conductances and without: yade -n -x yade_flux.py PACKING"""

import sys

from yade import *

lines = open(sys.argv[1]).read().splitlines()
box = [float(c) for c in lines[0].split()[2:]]
spheres = [[float(c) for c in line.split()] for line in lines[1:]]
for clamp in (False, True):
    O.reset()
    O.materials.append(FrictMat(young=1e6, poisson=0.5, frictionAngle=0, density=2600))
    O.bodies.append(aabbWalls([box[:3], box[3:]], thickness=0))
    for x, y, z, r in spheres:
        O.bodies.append(utils.sphere((x, y, z), r))
    flow = FlowEngine()
    flow.useSolver = 3
    flow.permeabilityFactor = 1
    flow.viscosity = 1e-3
    flow.defTolerance = -1
    flow.meshUpdateInterval = 1000
    flow.boundaryUseMaxMin = [0] * 6
    flow.bndCondIsPressure = [False, False, True, True, False, False]
    flow.bndCondValue = [0, 0, 1, 0, 0, 0]
    flow.slipBoundary = True
    flow.clampKValues = clamp
    O.engines = [ForceResetter(), flow]
    O.dt = 1e-12
    O.step()
    print("FLUX", "clamp" if clamp else "free", flow.getBoundaryFlux(2), flush=True)
