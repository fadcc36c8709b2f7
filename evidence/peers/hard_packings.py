"""Writes the packings of docs/evidence/2026-11-30-hard-cases-peers.md: hard_packings.py FOLDER

Lattices with nearest neighbours 1 apart and radii of 0.4, turned at random and cut to a box of edge
6, each with a copy of which every sphere is moved by up to 1e-6; a simple cubic lattice whose radii
grow until they cover its throats; one sphere that is many times larger than 300 others."""

import itertools
import math
import random
import sys
from pathlib import Path

TURNS = 12
EDGE = 6.0


def lattices():
    cubic = lambda a: [(a, 0, 0), (0, a, 0), (0, 0, a)]
    hexagonal = [(1, 0, 0), (0.5, math.sqrt(0.75), 0), (0, 0, math.sqrt(8 / 3))]
    half = 0.5
    faces = [(0, 0, 0), (half, half, 0), (half, 0, half), (0, half, half)]
    return {
        "simple": (cubic(1), [(0, 0, 0)]),
        "body": (cubic(math.sqrt(4 / 3)), [(0, 0, 0), (half, half, half)]),
        "face": (cubic(math.sqrt(2)), faces),
        "hexagonal": (hexagonal, [(0, 0, 0), (1 / 3, 1 / 3, half)]),
    }


def turn(rng):
    """A random rotation, from a quaternion."""
    w, x, y, z = (rng.gauss(0, 1) for _ in range(4))
    n = math.sqrt(w * w + x * x + y * y + z * z)
    w, x, y, z = w / n, x / n, y / n, z / n
    return [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]


def cut(vectors, places, rotation, r=0.4):
    points = []
    for cell in itertools.product(range(-9, 10), repeat=3):
        for place in places:
            at = [cell[k] + place[k] for k in range(3)]
            x = [sum(at[k] * vectors[k][a] for k in range(3)) for a in range(3)]
            x = [EDGE / 2 + sum(rotation[a][b] * x[b] for b in range(3)) for a in range(3)]
            if all(r <= c <= EDGE - r for c in x):
                points.append((*x, r))
    return points


def moved(points, size, rng):
    return [(*(c + size * rng.uniform(-1, 1) for c in p[:3]), p[3]) for p in points]


def write(path, points, edge):
    lines = [f"# box 0 0 0 {edge!r} {edge!r} {edge!r}"]
    lines += [" ".join(repr(float(c)) for c in p) for p in points]
    path.write_text("\n".join(lines) + "\n")


def unequal(ratio, rng):
    """Spheres of radius 0.02 around and beside one in the middle, none of which overlap."""
    small, large = 0.02, min(0.02 * ratio, 0.45)
    points = [(0.5, 0.5, 0.5, large)]
    small = large / ratio
    while len(points) < 301:
        p = [rng.uniform(small, 1 - small) for _ in range(3)]
        if all(math.dist(p, q[:3]) > small + q[3] for q in points):
            points.append((*p, small))
    return points


def main(folder):
    folder.mkdir(parents=True, exist_ok=True)
    rng = random.Random(17)
    for name, (vectors, places) in lattices().items():
        for k in range(TURNS):
            points = cut(vectors, places, turn(rng))
            write(folder / f"{name}-{k:02}-exact.txt", points, EDGE)
            write(folder / f"{name}-{k:02}-moved.txt", moved(points, 1e-6, rng), EDGE)
    grid = [tuple(c + 0.5 for c in p) for p in itertools.product(range(6), repeat=3)]
    for r in (0.5, 0.55, 0.6, 0.65, 0.7, 0.75, 0.8, 1.0):
        spheres = moved([(*p, r) for p in grid], 1e-6, rng)
        write(folder / f"covered-{r:.2f}.txt", spheres, EDGE)
    for ratio in (10, 100, 1000):
        write(folder / f"unequal-{ratio}.txt", unequal(ratio, rng), 1.0)


main(Path(sys.argv[1]))
