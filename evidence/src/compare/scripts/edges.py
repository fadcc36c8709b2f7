# The forces between neighbours of one packing, as YADE has them.
#
# job: spheres ([x, y, z, r]), box (6), viscosity, eps, velocity and spin of each sphere.
# Each case is one step of YADE's flow engine with some effects on, less the same step with
# none: what is left are their forces and torques on the spheres.
from yade import *

COUNT = len(job["spheres"])


def step(turns, **effects):
    O.reset()
    O.materials.append(FrictMat(young=1e6, poisson=0.5, frictionAngle=0, density=2600))
    low, high = (Vector3(job["box"][i : i + 3]) for i in (0, 3))
    O.bodies.append(aabbWalls([low, high], thickness=0))
    for (x, y, z, r), v, w in zip(job["spheres"], job["velocity"], job["spin"]):
        k = O.bodies.append(utils.sphere(Vector3(x, y, z), r))
        O.bodies[k].state.vel = Vector3(v) * (not turns)
        O.bodies[k].state.angVel = Vector3(w) * turns
    flow = FlowEngine(useSolver=3, permeabilityFactor=1, viscosity=job["viscosity"])
    flow.boundaryUseMaxMin = [0] * 6
    flow.bndCondIsPressure = [1] * 6
    flow.bndCondValue = [0] * 6
    flow.slipBoundary = True
    # No spring in series with the films.
    flow.stiffness = 0
    flow.eps = job["eps"]
    for name, on in effects.items():
        setattr(flow, name, on)
    O.engines = [ForceResetter(), flow]
    O.dt = 1e-9
    O.step()
    bodies = range(6, 6 + COUNT)
    return [O.forces.f(k) for k in bodies], [O.forces.t(k) for k in bodies]


def less(a, b):
    return [[list(x - y) for x, y in zip(p, q)] for p, q in zip(a, b)]


def case(turns=False, beside={}, **effects):
    force, torque = less(step(turns, **effects, **beside), step(turns, **beside))
    return dict(force=force, torque=torque)


# YADE computes the two couples beside shear lubrication only.
SHEAR = dict(shearLubrication=True)
finish(
    [
        case(viscousShear=True),
        case(normalLubrication=True),
        case(**SHEAR),
        case(turns=True, beside=SHEAR, pumpTorque=True),
        case(turns=True, beside=SHEAR, twistTorque=True),
    ]
)
