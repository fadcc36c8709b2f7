# A box full of spheres, with or without a fluid in the pores, one wall of which YADE's servo loads.
from yade import *

# The walls in YADE's order, which is ours; the loaded one is the upper one along y.
TOP = 3
low, high = Vector3(*job["bounds"][:3]), Vector3(*job["bounds"][3:])
grain = dict(young=job["young"], poisson=job["stiffness_ratio"])
O.materials.append(
    FrictMat(frictionAngle=job["friction_angle"], density=job["density"], label="grain", **grain)
)
O.materials.append(FrictMat(frictionAngle=0, density=0, label="wall", **grain))
walls = O.bodies.append(aabbWalls([low, high], thickness=0, material="wall"))
# Sphere by sphere to and fro: some number that nothing else depends on.
sign = 1
for x, y, z, r in job["spheres"]:
    sign = -sign
    O.bodies.append(sphere((x + sign * job["perturbation"], y, z), r, material="grain"))

contacts = InteractionLoop(
    [
        Ig2_Sphere_Sphere_ScGeom(avoidGranularRatcheting=not job["plain_slip"]),
        Ig2_Box_Sphere_ScGeom(),
    ],
    [Ip2_FrictMat_FrictMat_FrictPhys()],
    [Law2_ScGeom_FrictPhys_CundallStrack()],
)
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Box_Aabb()]),
    contacts,
]

wet = job["wet"]
if wet:
    flow = FlowEngine(dead=0, label="flow")
    flow.useSolver = 3
    flow.permeabilityFactor = 1
    flow.viscosity = wet["viscosity"]
    flow.defTolerance = -1
    # YADE's counter has to exceed this number.
    flow.meshUpdateInterval = wet["remesh_interval"] - 1
    flow.boundaryUseMaxMin = [0] * 6
    flow.bndCondIsPressure = [int(w == TOP) for w in range(6)]
    flow.bndCondValue = [0] * 6
    flow.slipBoundary = True
    flow.clampKValues = wet["clamp"]
    O.engines = O.engines + [flow]

corners = []


def push_corners():
    """Adds what YADE leaves out: the push of a corner's pore on the corner's sphere."""
    if not corners or O.iter % wet["remesh_interval"] == 0:
        corners.clear()
        for cell in range(flow.nCells()):
            vertices = flow.getVertices(cell)
            sides = [v for v in vertices if v in walls]
            if len(sides) == 3:
                corners.append((cell, sides, (set(vertices) - set(sides)).pop()))
    for cell, sides, grain in corners:
        pressure = flow.getCellPressure(cell)
        centre = O.bodies[grain].state.pos
        reach = Vector3.Zero
        for side in sides:
            axis = side // 2
            reach[axis] = centre[axis] - O.bodies[side].state.pos[axis]
        volume = abs(reach[0] * reach[1] * reach[2])
        # Each component: the rectangle across it, away from the corner.
        O.forces.addF(grain, Vector3(*[pressure * volume / reach[a] for a in range(3)]))


if wet and job["corner_push"]:
    O.engines = O.engines + [PyRunner(command="push_corners()", iterPeriod=1, initRun=True)]

activated = {"wall_%s_activated" % n: n == "top" for n in "top bottom left right front back".split()}
servo = TriaxialStressController(
    internalCompaction=False,
    stressMask=2,
    goal1=0,
    goal2=-job["stress"],
    goal3=0,
    max_vel=job["max_velocity"],
    stressDamping=0.25,
    strainDamping=0.8,
    thickness=0,
    stiffnessUpdateInterval=1,
    **activated,
)
O.engines = O.engines + [servo, NewtonIntegrator(damping=job["damping"])]
O.dt = job["dt"]
