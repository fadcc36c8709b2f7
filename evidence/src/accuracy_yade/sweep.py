# The box of loaded.py is loaded, with the clock read after every step; hands back what there is to see at
# the steps asked for, and how long all steps after the first took.
import time

interval, looks = job["wet"]["remesh_interval"], set(job["samples"])
course = dict(displacement=[], pressure=[])
start = O.bodies[walls[TOP]].state.pos[1]
clock = dict(began=0.0, ended=0.0, looking=0.0)


def remesh():
    """Asks for a network at each step, which `meshUpdateInterval` cannot say.

    A new network has no pressures until the next step solves them: none is made where one looks.
    """
    flow.updateTriangulation = O.iter + 1 not in looks


def stepped():
    """Reads the clock, and notes what there is to see."""
    now, step = time.perf_counter(), O.iter + 1
    if step == 1:
        clock["began"] = now
    if step in looks:
        course["displacement"].append(O.bodies[walls[TOP]].state.pos[1] - start)
        course["pressure"].append([flow.getPorePressure(Vector3(*p)) for p in job["probes"]])
        clock["looking"] += time.perf_counter() - now
    clock["ended"] = time.perf_counter()


if interval == 1:
    O.engines = [PyRunner(command="remesh()", iterPeriod=1, initRun=True)] + O.engines
O.engines = O.engines + [PyRunner(command="stepped()", iterPeriod=1, initRun=True)]
flow.useSolver = job["solver"]
flow.numSolveThreads = flow.numFactorizeThreads = job["blas_threads"]
# The first step in this thread: the flow engine starts there without trouble.
O.step()
O.run(job["steps"] - 1, True)
course["pores"] = flow.nCells()
course["seconds"] = clock["ended"] - clock["began"] - clock["looking"]
finish(course)
