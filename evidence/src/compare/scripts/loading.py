# The box of loaded.py is loaded; hands back what the walls and the pores feel at the steps asked for.
import time

course = dict(step=[], stress=[], displacement=[], contacts=[], coordination=[], pressure=[])
start = O.bodies[walls[TOP]].state.pos[1]
outward = [-1, 1] * 3


def look():
    """Notes what there is to see after a step."""
    moved = O.bodies[walls[TOP]].state.pos[1] - start
    x, y, z = high - low + Vector3(0, moved, 0)
    areas = [y * z, y * z, x * z, x * z, x * y, x * y]
    force = [O.forces.f(walls[w])[w // 2] * outward[w] for w in range(6)]
    on_walls = sum(i.isReal for w in walls for i in O.interactions.withBody(w))
    every = O.interactions.countReal()
    course["step"].append(O.iter)
    course["stress"].append([f / a for f, a in zip(force, areas)])
    course["displacement"].append(moved)
    course["contacts"].append(every)
    course["coordination"].append((2 * every - on_walls) / len(job["spheres"]))
    course["pressure"].append([flow.getPorePressure(Vector3(*p)) for p in job["probes"]])


began = time.time()
for step in job["samples"]:
    # The first step in this thread: the flow engine starts there without trouble.
    if O.iter == 0:
        O.step()
    if step > O.iter:
        O.run(step - O.iter, True)
    look()
if job["steps"] > O.iter:
    O.run(job["steps"] - O.iter, True)
course["seconds"] = time.time() - began
finish(course)
