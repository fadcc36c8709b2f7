# Dry spheres between walls that stand still: the time of a step after the first ones.
import time

from yade import *

numbers = [line.split() for line in open(job["packing"]) if line.split("#")[0].strip()]
low, high = Vector3(job["box"][0]), Vector3(job["box"][1])
elastic = dict(young=job["young"], poisson=job["stiffness_ratio"])
O.materials.append(
    FrictMat(frictionAngle=job["friction_angle"], density=job["density"], label="spheres", **elastic)
)
O.materials.append(FrictMat(frictionAngle=0, density=0, label="walls", **elastic))
O.bodies.append(aabbWalls([low, high], thickness=0, material="walls"))
for x, y, z, r in numbers:
    O.bodies.append(utils.sphere(Vector3(float(x), float(y), float(z)), float(r), material="spheres"))
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Box_Aabb()]),
    InteractionLoop(
        [Ig2_Sphere_Sphere_ScGeom(), Ig2_Box_Sphere_ScGeom()],
        [Ip2_FrictMat_FrictMat_FrictPhys()],
        [Law2_ScGeom_FrictPhys_CundallStrack()],
    ),
    NewtonIntegrator(damping=job["damping"]),
]
O.dt = job["dt"]
O.run(job["before"], True)
start = time.perf_counter()
O.run(job["steps"], True)
seconds = time.perf_counter() - start
contacts = sum(1 for i in O.interactions if i.isReal and i.id1 > 5 and i.id2 > 5)
finish(dict(step_s=seconds / job["steps"], contacts=contacts))
