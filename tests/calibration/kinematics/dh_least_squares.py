#!/usr/bin/python3
"""Plain least squares over a Denavit-Hartenberg table, as another program than ours would do it.

usage: dh_least_squares.py

Reads data/measurements/ur10_tracker/readings.csv, fits the tracker's frame, the target on the flange, joint offsets and
the table by Gauss and Newton from the maker's table, without any weight or stiffness, and prints the rms of one
coordinate. Steps are those of a singular value decomposition with columns of unit length; singular values below a share
of the largest are cut off. tests/calibration/kinematics/kinematic_calibration_test.cpp has its figures."""
import csv
import pathlib

import numpy as np

root = pathlib.Path(__file__).resolve().parents[3]
rows = list(csv.reader(open(root / "data/measurements/ur10_tracker/readings.csv")))[1:]
joints = np.array([[float(x) for x in row[2:8]] for row in rows])  # [rad]
read = np.array([[float(x) for x in row[8:11]] for row in rows])  # [mm]

a = np.array([0, -612, -572.3, 0, 0, 0])  # [mm]
alpha = np.radians([90, 0, 0, 90, -90, 0])
d = np.array([127.3, 0, 0, 163.941, 115.7, 92.2])
# Unknowns: offsets [mrad], a, alpha [mrad], d, target [mm]; six each, but three of the target.
size = 27


def turned(points, angle, first, second):
    """Points turned from one axis towards another."""
    c, s = np.cos(angle), np.sin(angle)
    result = points.copy()
    result[:, first] = c * points[:, first] - s * points[:, second]
    result[:, second] = s * points[:, first] + c * points[:, second]
    return result


def positions(x):
    """Of the target in the robot's base, one row a pose."""
    points = np.tile(x[24:27], (len(joints), 1))
    for i in reversed(range(6)):
        points = turned(points, alpha[i] + 1e-3 * x[12 + i], 1, 2)
        points = points + [a[i] + x[6 + i], 0, d[i] + x[18 + i]]
        points = turned(points, joints[:, i] + 1e-3 * x[i], 0, 1)
    return points


def registered(points):
    """Rotation and translation that bring points nearest to what was read (Kabsch)."""
    mean, target = points.mean(0), read.mean(0)
    u, _, v = np.linalg.svd((read - target).T @ (points - mean))
    rotation = u @ np.diag([1, 1, np.linalg.det(u @ v)]) @ v
    return rotation, target - rotation @ mean


def rms(unknowns, share, iterations=15):
    x = np.zeros(size)
    for _ in range(iterations):
        points = positions(x)
        rotation, shift = registered(points)
        seen = points @ rotation.T
        columns = []
        for k in unknowns:
            step = np.zeros(size)
            step[k] = 1e-4
            columns.append(((positions(x + step) - points) @ rotation.T).ravel() / 1e-4)
        for axis in np.eye(3):
            columns.append(1e-3 * np.cross(axis, seen).ravel())
            columns.append(np.tile(axis, (len(points), 1)).ravel())
        jacobian = np.array(columns).T
        length = np.linalg.norm(jacobian, axis=0)
        length[length == 0] = 1
        u, s, v = np.linalg.svd(jacobian / length, full_matrices=False)
        kept = s > share * s[0]
        step = (v.T[:, kept] / s[kept]) @ (u[:, kept].T @ (read - seen - shift).ravel()) / length
        x[unknowns] += step[: len(unknowns)]
        if not np.all(np.abs(x) < 1e6):
            return float("inf"), kept.sum(), len(s)
    points = positions(x)
    rotation, shift = registered(points)
    return np.sqrt(np.mean((read - points @ rotation.T - shift) ** 2)), kept.sum(), len(s)


target = list(range(24, 27))
offsets = list(range(6))
for name, unknowns in [("frame", []), ("+ target", target), ("+ joint offsets", offsets + target),
                       ("+ the whole table", list(range(24)) + target)]:
    for share in (1e-12, 1e-4, 3e-3):
        error, rank, count = rms(unknowns, share)
        print(f"{name:20} cut off at {share:.0e}: {error:.4f} mm, rank {rank} of {count}")
