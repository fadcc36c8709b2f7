# The pore network of a packing, evaluated a second time.
#
# Written from the published formulas (Chareyre et al. 2012, Caulk et al. 2020) for
# pores that are given by their four vertices; it shares no code with dempfv, nor
# with YADE. Each throat is evaluated three times:
#
#   planes   at 50 digits, the walls being planes;
#   spheres  at 50 digits, the pores' centres coming from walls that are spheres of
#            radius 50000 H which touch the planes from outside, as YADE has them: H
#            is the extent along y of the spheres, not of the box;
#   double   the same at 53 bits, the precision of a double, with a pore's centre
#            computed relative to its first vertex.
#
# So what the sphere model changes is told from what floating point loses.
#
# job: box (6), spheres ([x, y, z, r]), cells (four vertices each: spheres from 0 and,
# after them, the walls in the order x_min, x_max, y_min, ...), throats (pairs of
# cells; those between pores without walls are evaluated only as planes), viscosity,
# pressure (per wall in Pa, or null), solve (are these all throats: pressures too?).
import multiprocessing

import numpy as np
from mpmath import acos, atan2, mp, mpf, sqrt

DIGITS = 50
MODELS = ("planes", "spheres", "double")
SLIPS = (True, False)
HUGE = 50000


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def sub(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def add(a, b):
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def times(s, a):
    return (s * a[0], s * a[1], s * a[2])


def norm(a):
    return sqrt(dot(a, a))


class Packing:
    """Spheres and walls at full precision."""

    def __init__(self):
        self.count = len(job["spheres"])
        self.at = [tuple(map(mpf, s[:3])) for s in job["spheres"]]
        self.radius = [mpf(s[3]) for s in job["spheres"]]
        self.low = tuple(map(mpf, job["box"][:3]))
        self.high = tuple(map(mpf, job["box"][3:]))
        top = max(x[1] + r for x, r in zip(self.at, self.radius))
        bottom = min(x[1] - r for x, r in zip(self.at, self.radius))
        self.huge = HUGE * (top - bottom)

    def is_wall(self, v):
        return v >= self.count

    def plane(self, v):
        """Axis, position and inward direction of a wall."""
        axis, upper = divmod(v - self.count, 2)
        return axis, (self.high if upper else self.low)[axis], -1 if upper else 1

    def inward(self, v):
        axis, _, sign = self.plane(v)
        return tuple(mpf(sign if a == axis else 0) for a in range(3))

    def distance(self, v, x):
        axis, position, sign = self.plane(v)
        return sign * (x[axis] - position)

    def project(self, v, x):
        axis, position, _ = self.plane(v)
        return tuple(position if a == axis else x[a] for a in range(3))

    def sphere(self, v):
        """Centre and radius of a sphere, or of the huge one that stands in for a
        wall."""
        if not self.is_wall(v):
            return self.at[v], self.radius[v]
        axis, position, sign = self.plane(v)
        middle = times(mpf(1) / 2, add(self.low, self.high))
        at = tuple(position - sign * self.huge if a == axis else middle[a] for a in range(3))
        return at, self.huge

    def center(self, cell, model):
        """The point of equal power to a cell's vertices: three linear equations
        relative to one of them, by Cramer's rule. With huge spheres relative to the
        first vertex, as YADE does: at 50 digits it is all the same, in floating point
        nine digits go where that vertex is a wall."""
        if model == "planes":
            base = next(v for v in cell if not self.is_wall(v))
        else:
            base = cell[0]
        x0, r0 = self.sphere(base)
        rows, right = [], []
        for v in cell:
            if v == base:
                continue
            if self.is_wall(v) and model == "planes":
                rows.append(self.inward(v))
                right.append(-self.distance(v, x0))
                continue
            x, r = self.sphere(v)
            d = sub(x, x0)
            rows.append(d)
            right.append((dot(d, d) + r0 * r0 - r * r) / 2)
        a, b, c = rows
        bc, ca, ab = cross(b, c), cross(c, a), cross(a, b)
        shift = add(add(times(right[0], bc), times(right[1], ca)), times(right[2], ab))
        return add(x0, times(1 / dot(a, bc), shift))


def volume(cell):
    """Tetrahedron, prism, wedge or box, without its sign."""
    spheres = [packing.at[v] for v in cell if not packing.is_wall(v)]
    walls = [v for v in cell if packing.is_wall(v)]
    if not walls:
        a, b, c, d = spheres
        return abs(dot(sub(b, a), cross(sub(c, a), sub(d, a)))) / 6
    if len(walls) == 1:
        a, b, c = spheres
        n = packing.inward(walls[0])
        height = sum(packing.distance(walls[0], x) for x in spheres) / 3
        return abs(dot(cross(sub(b, a), sub(c, a)), n)) / 2 * height
    if len(walls) == 2:
        along = cross(packing.inward(walls[0]), packing.inward(walls[1]))
        a, b = ([packing.distance(w, x) for w in walls] for x in spheres)
        section = (a[0] * a[1] + b[0] * b[1]) / 3 + (a[0] * b[1] + b[0] * a[1]) / 6
        return abs(dot(along, sub(*spheres))) * section
    d = [packing.distance(w, spheres[0]) for w in walls]
    return d[0] * d[1] * d[2]


class Facet:
    """What two pores share: spheres, walls and an area vector that points away
    from the vertex opposite."""

    def __init__(self, vertices, opposite):
        self.spheres = [v for v in vertices if not packing.is_wall(v)]
        self.walls = [v for v in vertices if packing.is_wall(v)]
        at = [packing.at[v] for v in self.spheres]
        self.at = at
        if not self.walls:
            s = times(mpf(1) / 2, cross(sub(at[1], at[0]), sub(at[2], at[0])))
        elif len(self.walls) == 1:
            w = self.walls[0]
            mean = (packing.distance(w, at[0]) + packing.distance(w, at[1])) / 2
            s = times(mean, cross(sub(at[1], at[0]), packing.inward(w)))
        else:
            u, w = self.walls
            size = packing.distance(u, at[0]) * packing.distance(w, at[0])
            s = times(size, cross(packing.inward(u), packing.inward(w)))
        if packing.is_wall(opposite):
            outward = dot(s, packing.inward(opposite)) > 0
        else:
            outward = dot(s, sub(packing.at[opposite], at[0])) < 0
        self.area = s if outward else times(-1, s)
        self.size = norm(s)
        self.sectors = [self.sector(k) for k in range(len(self.spheres))]
        segments = self.segments()
        self.is_doubtful = len(segments) > 1
        rest = self.size - sum(self.sectors) + (segments[0] if segments else 0)
        self.fluid_area = abs(rest)

    def corners(self, k):
        """The facet's other two corners as sphere k sees them."""
        others = [x for m, x in enumerate(self.at) if m != k]
        return others + [packing.project(w, self.at[k]) for w in self.walls]

    def sector(self, k):
        """Area of sphere k's circular sector of the facet."""
        r = packing.radius[self.spheres[k]]
        a, b = (sub(x, self.at[k]) for x in self.corners(k))
        return r * r / 2 * atan2(norm(cross(a, b)), dot(a, b))

    def segments(self):
        """Areas of the spheres' circular segments beyond the opposite edges, in
        the order of the vertices; at most the first counts."""
        found = []
        if len(self.walls) == 2:
            return found
        for k, v in enumerate(self.spheres):
            others = [x for m, x in enumerate(self.at) if m != k]
            if self.walls:
                others.append(packing.project(self.walls[0], others[0]))
            edge, seen = sub(others[1], others[0]), sub(self.at[k], others[0])
            share = dot(seen, edge) / dot(edge, edge)
            away = sub(seen, times(share, edge))
            m, r = norm(away), packing.radius[v]
            if 0 <= share <= 1 and m < r:
                angle, chord = 2 * acos(m / r), 2 * sqrt(r * r - m * m)
                found.append((r * r * angle - chord * m) / 2)
        return found


def solid_angle(a, b, c):
    """Van Oosterom and Strackee (1983), without its sign."""
    na, nb, nc = norm(a), norm(b), norm(c)
    below = na * nb * nc + dot(a, b) * nc + dot(a, c) * nb + dot(b, c) * na
    return 2 * atan2(abs(dot(a, cross(b, c))), below)


class Throat:
    """A throat between pores centred at p and q: all that viscosity and slip leave."""

    def __init__(self, facet, p, q):
        walls = facet.walls
        line = sub(q, p)
        self.solid, solid_volume = {}, mpf(0)
        for k, v in enumerate(facet.spheres):
            x, r = facet.at[k], packing.radius[v]
            seen = [
                solid_angle(sub(c, x), sub(p, x), sub(q, x)) for c in facet.corners(k)
            ]
            self.solid[v] = r * r * sum(seen)
            solid_volume += r**3 * sum(seen) / 3
        self.wall = {}
        for w in walls:
            edge = sub(facet.at[0], facet.at[1] if len(walls) == 1 else q)
            self.wall[w] = abs(dot(cross(line, edge), packing.inward(w))) / 2
        self.facet = facet
        self.fluid_volume = abs(dot(facet.area, line)) / 3 - solid_volume
        self.length = norm(line)

    def with_slip(self, slip):
        """Conductance, dragging surface, and per sphere its push per pressure. None
        where the pores' centres coincide."""
        drags = [w for w in self.wall if not slip and not imposed[w - packing.count]]
        solid = sum(self.solid.values()) + sum(self.wall[w] for w in drags)
        if solid == 0:
            return None
        radius = self.fluid_volume / solid
        # Slip walls widen the throat by 2^(1/4) in its radius for each wall.
        if slip:
            radius /= sqrt(sqrt(mpf(2) ** len(self.wall)))
        length = max(self.length, 2 * radius / 10**6)
        viscosity = mpf(job["viscosity"])
        conductance = self.facet.fluid_area * (2 * radius) ** 2 / (8 * viscosity * length)
        shares = [self.facet.fluid_area * s / solid for s in self.solid.values()]
        push = [share + sector for share, sector in zip(shares, self.facet.sectors)]
        return float(conductance), float(solid), [float(p) for p in push]


packing = Packing()
imposed = [p is not None for p in job["pressure"]]


def evaluate(throat):
    """One throat in every model."""
    shared = [v for v in job["cells"][throat[0]] if v in job["cells"][throat[1]]]
    (opposite,) = set(job["cells"][throat[0]]) - set(shared)
    near_wall = any(packing.is_wall(v) for c in throat for v in job["cells"][c])
    mp.dps = DIGITS
    facet = Facet(shared, opposite)
    out = {}
    for model in MODELS if near_wall else MODELS[:1]:
        if model == "double":
            mp.prec = 53
            facet = Facet(shared, opposite)
        walls = "planes" if model == "planes" else "spheres"
        p, q = (packing.center(job["cells"][c], walls) for c in throat)
        t = Throat(facet, p, q)
        excess = facet.fluid_area + sum(facet.sectors) - facet.size
        out[model] = dict(
            length=float(t.length),
            fluid_volume=float(t.fluid_volume),
            excess=float(excess),
            slip=[t.with_slip(slip) for slip in SLIPS],
            normal=[float(v / facet.size) for v in facet.area],
            spheres=facet.spheres,
            is_doubtful=facet.is_doubtful,
        )
    return out


def clamped(conductance, length, fluid_volume, solid):
    """As YADE does: between 1e-4 and 100 times mean length × fluid volume /
    (8 μ × solid area)."""
    mean = np.mean(length) * np.sum(fluid_volume)
    mean /= 8 * job["viscosity"] * np.sum(solid)
    return np.clip(conductance, 1e-4 * mean, 100 * mean)


class Graph:
    """All pores and throats, for pressures."""

    def __init__(self):
        count = len(job["cells"])
        self.first, self.second = np.array(job["throats"]).T
        self.pressure = np.full(count, np.nan, dtype=np.longdouble)
        # The wall that imposes a pore's pressure: of several the last.
        self.wall = np.full(count, -1)
        for i, cell in enumerate(job["cells"]):
            for w in sorted(v - packing.count for v in cell if packing.is_wall(v)):
                if imposed[w]:
                    self.pressure[i], self.wall[i] = job["pressure"][w], w
        self.layers = self.peel()

    def peel(self):
        """Free pores by their distance, in throats, from a pore with an imposed
        pressure: a throat joins pores of the same layer or of neighbouring ones."""
        around = [[] for _ in self.wall]
        for i, j in job["throats"]:
            around[i].append(j)
            around[j].append(i)
        front = np.flatnonzero(self.wall == max(self.wall))
        layers, seen = [], set(front)
        while len(front):
            front = {j for i in front for j in around[i]} - seen
            seen |= front
            layers.append([i for i in front if self.wall[i] < 0])
        return [np.array(sorted(layer)) for layer in layers if layer]

    def factor(self, g):
        """Block elimination, layer by layer. Each layer's inverse, and its block
        with the layer before it."""
        place = {}
        for k, layer in enumerate(self.layers):
            place.update({i: (k, m) for m, i in enumerate(layer)})
        own = [np.zeros((len(layer), len(layer))) for layer in self.layers]
        before = [None] + [
            np.zeros((len(b), len(a))) for a, b in zip(self.layers, self.layers[1:])
        ]
        for i, j, value in zip(self.first, self.second, g.astype(float)):
            for a, b in ((i, j), (j, i)):
                if a not in place:
                    continue
                k, m = place[a]
                own[k][m, m] += value
                if b in place and place[b][0] == k:
                    own[k][m, place[b][1]] -= value
                elif b in place and place[b][0] == k - 1:
                    before[k][m, place[b][1]] -= value
        inverse = []
        for k, block in enumerate(own):
            if k > 0:
                block = block - before[k] @ inverse[-1] @ before[k].T
            inverse.append(np.linalg.inv(block))
        return inverse, before

    def correction(self, factor, surplus):
        inverse, before = factor
        right = [surplus[layer].astype(float) for layer in self.layers]
        for k in range(1, len(right)):
            right[k] -= before[k] @ (inverse[k - 1] @ right[k - 1])
        change = np.zeros(len(self.wall))
        after = None
        for k in reversed(range(len(right))):
            if after is not None:
                right[k] -= before[k + 1].T @ after
            after = inverse[k] @ right[k]
            change[self.layers[k]] = after
        return change

    def solve(self, g):
        """Pressures, refined with what each pore gains, taken throat by throat in
        extended precision, until the changes no longer fall."""
        factor = self.factor(g)
        pressure = np.where(self.wall < 0, 0, self.pressure)
        last = np.inf
        for _ in range(20):
            flow = g * (pressure[self.second] - pressure[self.first])
            surplus = np.zeros(len(pressure), dtype=np.longdouble)
            np.add.at(surplus, self.first, flow)
            np.add.at(surplus, self.second, -flow)
            change = self.correction(factor, surplus)
            pressure = pressure + change
            size = np.abs(change).max(initial=0)
            if size == 0 or (size < 1e-13 and size > last / 2):
                break
            last = size
        return pressure

    def flux(self, pressure, g):
        """Into the box, by the wall that imposes the pressure."""
        flux = np.zeros(7, dtype=np.longdouble)
        flow = g * (pressure[self.first] - pressure[self.second])
        np.add.at(flux, self.wall[self.first], flow)
        np.add.at(flux, self.wall[self.second], -flow)
        return flux[:6]

    def force(self, throats, s, pressure):
        """On every sphere: pores push the spheres of their throats outward, by the
        fluid's share of the facet in proportion to the solid surfaces, and by each
        sphere's own sector. And what these sum to beyond the facets' areas: the
        fluid area counts a segment that reaches past an edge, the facet's does not."""
        force = np.zeros((packing.count, 3), dtype=np.longdouble)
        excess = np.zeros(3, dtype=np.longdouble)
        for i, j, t in zip(self.first, self.second, throats):
            drop = (pressure[i] - pressure[j]) * np.array(t["normal"])
            excess += t["excess"] * drop
            for v, push in zip(t["spheres"], t["slip"][s][2]):
                force[v] += push * drop
        return force, excess


def pressures(throats, graph):
    """Per model, slip and clamp: pressures, fluxes and forces."""
    cases = []
    for model in MODELS:
        chosen = [t.get(model, t["planes"]) for t in throats]
        length = [t["length"] for t in chosen]
        fluid_volume = [t["fluid_volume"] for t in chosen]
        for s, slip in enumerate(SLIPS):
            g = np.array([t["slip"][s][0] for t in chosen], dtype=np.longdouble)
            solid = [t["slip"][s][1] for t in chosen]
            for clamp in (False, True):
                bounded = clamped(g, length, fluid_volume, solid) if clamp else g
                pressure = graph.solve(bounded)
                force, excess = graph.force(chosen, s, pressure)
                cases.append(
                    dict(
                        model=model,
                        slip=slip,
                        clamp=clamp,
                        conductance=bounded.astype(float).tolist(),
                        pressure=pressure.astype(float).tolist(),
                        flux=graph.flux(pressure, bounded).astype(float).tolist(),
                        force=force.astype(float).tolist(),
                        excess=excess.astype(float).tolist(),
                    )
                )
    return cases


def rows(throats):
    """Per model and slip, without a clamp: conductances, null where a model was not
    evaluated or has none; and where the pressures are not ours to find, what each throat
    pushes its spheres by, per pressure in its first pore."""
    out = []
    for model in MODELS:
        for s, slip in enumerate(SLIPS):
            row = dict(model=model, slip=slip, conductance=[], push=[])
            for t in throats:
                found = t[model]["slip"][s] if model in t else None
                row["conductance"].append(found and found[0])
                if found and not job["solve"]:
                    normal, spheres = t[model]["normal"], t[model]["spheres"]
                    push = [[f * n for n in normal] for f in found[2]]
                    row["push"].append(list(zip(spheres, push)))
            out.append(row)
    return out


def main():
    mp.dps = DIGITS
    with multiprocessing.Pool() as pool:
        throats = pool.map(evaluate, job["throats"], chunksize=64)
    result = dict(
        volume=[],
        rows=rows(throats),
        doubtful=[k for k, t in enumerate(throats) if t["planes"]["is_doubtful"]],
        cases=[],
    )
    undetermined = any(None in t["planes"]["slip"] for t in throats)
    if job["solve"]:
        result["volume"] = [float(volume(c)) for c in job["cells"]]
    if job["solve"] and not undetermined:
        result["cases"] = pressures(throats, Graph())
    finish(result)


main()
