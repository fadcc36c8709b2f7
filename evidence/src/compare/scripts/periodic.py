# The flow through a periodic cube of spheres at rest, under a mean gradient of pressure along x.
#
# job: spheres ([x, y, z, r], centres in the cube), edge (m), viscosity, gradient (Pa/m).
from yade import *

O.periodic = True
O.cell.setBox(*[job["edge"]] * 3)
O.materials.append(FrictMat(young=1e6, poisson=0.5, density=2600))
for x, y, z, r in job["spheres"]:
    O.bodies.append(utils.sphere(Vector3(x, y, z), r))
for body in O.bodies:
    body.state.blockedDOFs = "xyzXYZ"
flow = PeriodicFlowEngine()
flow.useSolver = 3
flow.viscosity = job["viscosity"]
flow.permeabilityFactor = 1
flow.defTolerance = -1
flow.meshUpdateInterval = 1000000
flow.wallIds = [-1] * 6
flow.gradP = Vector3(job["gradient"], 0, 0)
flow.duplicateThreshold = job["edge"]
# It has no switch for its clamp: these bounds let all conductances pass.
flow.minKdivKmean = 0
flow.maxKdivKmean = 1e30
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb()], allowBiggerThanPeriod=True),
    flow,
    NewtonIntegrator(damping=0),
]
O.dt = 1e-9
O.step()
finish(
    dict(
        pores=flow.nCells(),
        velocity=list(flow.averageVelocity()),
        force=[list(flow.fluidForce(body.id)) for body in O.bodies],
    )
)
