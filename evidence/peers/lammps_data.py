#!/usr/bin/env python3
"""Turns a packing file (x y z r per line, a comment with the box) into a LAMMPS
data file for atom_style sphere, and prints the variables for dry_step.lmp.

    lammps_data.py PACKING DATA

Variables, in the order of LAMMPS's command line (-var NAME VALUE ...): kn, kt
(N/m), gamma (1/s), dt (s), skin (m).

The contact law is that of dempfv's dry step: E = 1 MPa, k_s/k_n = 0.5, friction
30 degrees, density 2600 kg/m3. LAMMPS has one k_n for all pairs: E times the
mean radius is dempfv's for the mean sphere. Local damping of 0.2 loses as much
per cycle as a share 0.2/pi of critical viscous damping.
"""

import math
import sys

YOUNG, RATIO, DENSITY, DAMPING = 1e6, 0.5, 2600.0, 0.2


def read(path):
    box, spheres = None, []
    with open(path) as lines:
        for line in lines:
            words = line.split()
            if words[:2] == ["#", "box"]:
                box = [float(w) for w in words[2:8]]
            elif words and words[0] != "#":
                spheres.append([float(w) for w in words[:4]])
    if box is None or not spheres:
        sys.exit(f"{path}: no '# box' line or no spheres")
    return box, spheres


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    box, spheres = read(sys.argv[1])
    with open(sys.argv[2], "w") as out:
        print("packing\n", file=out)
        print(f"{len(spheres)} atoms\n1 atom types\n", file=out)
        for axis, name in enumerate("xyz"):
            print(f"{box[axis]} {box[axis + 3]} {name}lo {name}hi", file=out)
        print("\nAtoms # sphere\n", file=out)
        for number, (x, y, z, r) in enumerate(spheres, 1):
            print(f"{number} 1 {2 * r} {DENSITY} {x} {y} {z}", file=out)
    radius = sum(s[3] for s in spheres) / len(spheres)
    kn = YOUNG * radius
    mass = DENSITY * 4 / 3 * math.pi * radius**3
    # Share 0.2/pi of critical damping of two mean spheres in contact.
    gamma = 2 * DAMPING / math.pi * math.sqrt(kn / (mass / 2))
    # Half the stable step of a sphere of the smallest size with eight contacts'
    # worth of stiffness: what dempfv's own bound gives for such packings.
    smallest = min(s[3] for s in spheres)
    dt = 0.5 * math.sqrt(2 * DENSITY * 4 / 3 * math.pi * smallest**2 / (8 * YOUNG))
    print(f"-var kn {kn} -var kt {RATIO * kn} -var gamma {gamma} -var dt {dt} -var skin {0.1 * radius}")


main()
