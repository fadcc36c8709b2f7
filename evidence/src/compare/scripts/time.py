# The coupled specimen under a servo wall, with the clock read after every step.
import time

from yade import *

base_memory = peak_memory()
numbers = [line.split() for line in open(job["packing"]) if line.split("#")[0].strip()]
low, high = Vector3(job["box"][0]), Vector3(job["box"][1])

# The stiffness ratio of a contact is what YADE calls "poisson".
elastic = dict(young=job["young"], poisson=job["stiffness_ratio"])
O.materials.append(
    FrictMat(frictionAngle=job["friction_angle"], density=job["density"], label="spheres", **elastic)
)
O.materials.append(FrictMat(frictionAngle=0, density=0, label="walls", **elastic))
O.bodies.append(aabbWalls([low, high], thickness=0, material="walls"))
for x, y, z, r in numbers:
    O.bodies.append(utils.sphere(Vector3(float(x), float(y), float(z)), float(r), material="spheres"))

flow = FlowEngine(
    useSolver=job["solver"],
    numFactorizeThreads=job["blas_threads"],
    numSolveThreads=job["blas_threads"],
    meshUpdateInterval=job["remesh_interval"],
    defTolerance=-1,
    viscosity=job["viscosity"],
    permeabilityFactor=1,
    slipBoundary=True,
    clampKValues=True,
    boundaryUseMaxMin=[0] * 6,
    bndCondIsPressure=[0, 0, 0, 1, 0, 0],
    bndCondValue=[0] * 6,
    label="flow",
)
servo = TriaxialStressController(
    thickness=0,
    internalCompaction=False,
    stressMask=2,
    goal1=0,
    goal2=-job["stress"],
    goal3=0,
    wall_bottom_activated=False,
    max_vel=1,
)

clock, engines, flow_parts = [], [], []


def read_clock():
    clock.append(time.perf_counter())
    engines.append([engine.execTime for engine in O.engines])
    flow_parts.append([part[1] for part in flow.timingDeltas.data])


O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Box_Aabb()]),
    InteractionLoop(
        [Ig2_Sphere_Sphere_ScGeom(), Ig2_Box_Sphere_ScGeom()],
        [Ip2_FrictMat_FrictMat_FrictPhys()],
        [Law2_ScGeom_FrictPhys_CundallStrack()],
    ),
    flow,
    servo,
    NewtonIntegrator(damping=job["damping"]),
    PyRunner(command="read_clock()", iterPeriod=1, initRun=True),
]
O.dt = job["dt"]
O.timingEnabled = True
O.run(job["steps"], True)

finish(
    dict(
        clock_s=clock,
        engine_names=[type(engine).__name__ for engine in O.engines],
        engines_ns=engines,
        flow_names=[part[0] for part in flow.timingDeltas.data],
        flow_ns=flow_parts,
        pores=flow.nCells(),
        base_memory_bytes=base_memory,
    )
)
