#!/usr/bin/python3
"""The unloaded stiffness of the Orthoglide pose by pose as a laboratory's script has it, beside the map of the package.

    PYTHONPATH=build/release/python bench/numpy_peer.py [POSES]

The script knows one thing, the 3-PUU with beams (JAMRIS09): closed inverse kinematics, the Jacobians of its springs and
passive joints, and for each chain the block inverse of MMT11 (Table 1) in NumPy. Both work on one core; the largest
difference of the weakest direction is printed beside what each took."""
import sys
import time

import kinetostat as ks
import numpy as np

L, FOOT, TOOL, BACK = 0.310, 0.1549, 0.030, 0.10953084041
CORNER = FOOT / np.sqrt(2)
E, G = 70e9, 25.5e9


def rotation(axis, angle):
    c, s = np.cos(angle), np.sin(angle)
    i, j = [(1, 2), (2, 0), (0, 1)][axis]
    r = np.eye(3)
    r[i, i] = r[j, j] = c
    r[i, j], r[j, i] = -s, s
    return r


def beam(length, a, iy, iz, j):
    """6x6 stiffness at the end of a clamped beam along x."""
    c = np.zeros((6, 6))
    c[0, 0], c[3, 3] = length / (E * a), length / (G * j)
    c[1, 1], c[2, 2] = length**3 / (3 * E * iz), length**3 / (3 * E * iy)
    c[4, 4], c[5, 5] = length / (E * iy), length / (E * iz)
    c[1, 5] = c[5, 1] = length**2 / (2 * E * iz)
    c[2, 4] = c[4, 2] = -(length**2) / (2 * E * iy)
    return np.linalg.inv(c)


def torsion(a, b):
    """Torsion constant of a rectangle a >= b (Roark's formulas for stress and strain), as robot files have it."""
    return a * b**3 * (1 / 3 - 0.21 * b / a * (1 - (b / a) ** 4 / 12))


WIDE, HIGH = 0.0294, 0.0164  # of the foot: in its plane, out of it
AROUND = np.kron(np.eye(2), rotation(2, np.pi / 4))
K = np.zeros((13, 13))
K[0, 0] = 1e8
K[1:7, 1:7] = AROUND @ beam(FOOT, WIDE * HIGH, WIDE * HIGH**3 / 12, HIGH * WIDE**3 / 12, torsion(WIDE, HIGH)) @ AROUND.T
K[7:, 7:] = beam(L, 288e-6, 3300e-12, 3300e-12, 6600e-12)
K_INVERSE = np.linalg.inv(K)
TURNS = [np.column_stack([np.eye(3)[:, (i + k) % 3] for k in range(3)]) for i in range(3)]


def twist(axis, origin, end):
    return np.concatenate([np.cross(axis, end - origin), axis])


def chain_stiffness(p):
    """Of the chain along the local x axis, its end at p in local axes."""
    joint = p - [TOOL, 0, 0]
    about_y = np.arcsin(-joint[2] / L)  # z of the leg is -L sin(about_y)
    about_z = np.arctan2(joint[1] - (CORNER - BACK), np.sqrt(max(L**2 - joint[2] ** 2 - (joint[1] - (CORNER - BACK)) ** 2, 0)))
    first = joint - rotation(2, about_z) @ rotation(1, about_y) @ [L, 0, 0]
    r1 = rotation(2, about_z)
    r2 = r1 @ rotation(1, about_y)
    springs, passive = np.zeros((6, 13)), np.zeros((6, 4))
    springs[:, 0] = [1, 0, 0, 0, 0, 0]
    for k in range(3):
        springs[k, 1 + k] = 1
        springs[:, 4 + k] = twist(np.eye(3)[:, k], first, p)
        springs[:3, 7 + k] = r2[:, k]
        springs[:, 10 + k] = twist(r2[:, k], joint, p)
    passive[:, 0] = twist(np.array([0, 0, 1.0]), first, p)
    passive[:, 1] = twist(r1[:, 1], first, p)
    passive[:, 2] = twist(r1[:, 1], joint, p)
    passive[:, 3] = twist(np.array([0, 0, 1.0]), joint, p)
    block = np.zeros((10, 10))
    block[:6, :6] = springs @ K_INVERSE @ springs.T
    block[:6, 6:] = passive
    block[6:, :6] = passive.T
    return np.linalg.inv(block)[:6, :6]


def weakest(position):
    total = np.zeros((6, 6))
    for turn in TURNS:
        local = turn.T @ position
        around = np.kron(np.eye(2), turn)
        total += around @ chain_stiffness(local) @ around.T
    return 1 / np.linalg.eigvalsh(np.linalg.inv(total)[:3, :3])[-1]


def main():
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    robot = ks.Robot.read("data/robots/orthoglide.yaml")
    side = max(2, round(count ** (1 / 3)))
    grid = np.linspace(-0.06, 0.08, side)
    points = np.array([[x, y, z] for x in grid for y in grid for z in grid])
    start = time.perf_counter()
    by_script = np.array([weakest(p) for p in points])
    script = time.perf_counter() - start
    start = time.perf_counter()
    mapped = ks.map_poses(robot, f"x=-60:80:{side},y=-60:80:{side},z=-60:80:{side}", threads=1)
    package = time.perf_counter() - start
    values = mapped.columns()["weakest-translation"]
    print(f"{len(points)} poses: script {1e6 * script / len(points):.1f} us a pose, package {1e6 * package / len(points):.1f}, "
          f"ratio {script / package:.0f}, largest difference {np.max(np.abs(values / by_script - 1)):.1e}")


if __name__ == "__main__":
    main()
