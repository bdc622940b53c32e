"""The picture of the README: a link under a unit force, and a model that fails its test."""

import base64
import csv
import json
import sys
import xml.etree.ElementTree as xml

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

NUMPY_TYPES = {"Float64": "<f8", "Int64": "<i8", "Int32": "<i4", "UInt8": "u1"}


def read_arrays(file):
    """All arrays of a VTU file by name: inline base64, a UInt64 byte count before the values."""
    arrays = {}
    for array in xml.parse(file).iter("DataArray"):
        data = base64.b64decode("".join(array.text.split()))[8:]
        values = np.frombuffer(data, NUMPY_TYPES[array.get("type")])
        width = int(array.get("NumberOfComponents", "1"))
        arrays[array.get("Name")] = values.reshape(-1, width) if width > 1 else values
    return arrays


def boundary(elements):
    """Corner triangles that belong to one tetrahedron only."""
    corners = elements[:, :4]
    faces = np.vstack([corners[:, [0, 2, 1]], corners[:, [0, 1, 3]], corners[:, [1, 2, 3]], corners[:, [2, 0, 3]]])
    _, first, count = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    return faces[first[count == 1]]


def draw_link(axes, file):
    arrays = read_arrays(file)
    points = next(v for k, v in arrays.items() if k.lower() == "points") * 1e3
    faces = boundary(arrays["connectivity"].reshape(-1, 10))
    moved = arrays["Fz"] * 1e3  # mm per N
    size = np.linalg.norm(moved, axis=1)
    scale = 25 / size.max()
    shown = points + scale * moved
    colours = plt.cm.viridis(size[faces].mean(axis=1) / size.max())
    axes.add_collection3d(Poly3DCollection(points[faces][::3], facecolors=(0.6, 0.6, 0.6, 0.08)))
    axes.add_collection3d(Poly3DCollection(shown[faces], facecolors=colours, edgecolors="none"))
    axes.set(xlim=(0, 130), ylim=(-10, 120), zlim=(-40, 90), xlabel="x [mm]", ylabel="y [mm]", zlabel="z [mm]")
    axes.view_init(22, -62)
    axes.set_title(
        f"Orthoglide foot under a force along z at its bore:\n{1e3 * size.max():.2f} µm/N at the most, not to scale",
        fontsize=10,
    )


def draw_residuals(axes, residuals, comparison, readings):
    with open(readings) as file:
        rows = csv.DictReader(line for line in file if not line.startswith("#"))
        load = {row["id"]: float(row["fz"]) for row in rows}
    with open(residuals) as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    with open(comparison) as file:
        test = json.load(file)["refitted"]["lack_of_fit"]
    x = np.array([load[row["id"]] for row in rows]) * 1e-6
    y = np.array([float(row["residual_dz_refitted"]) for row in rows]) * 1e3
    axes.axhline(0, color="0.3", linewidth=0.8)
    axes.plot(x, y, "o", markersize=4, color="tab:red", label="measured minus best straight line, two runs")
    axes.set(xlabel="force [MN]", ylabel="residual [µm]")
    verdict = "fails" if test["f"] > test["critical"] else "passes"
    axes.set_title(
        f"NIST load cell: lack-of-fit F = {test['f']:.4g}, limit {test['critical']:.3g}:\nthe linear spring {verdict}",
        fontsize=10,
    )
    axes.legend(frameon=False, fontsize=9, loc="lower center")


def main():
    folder, readings, picture = sys.argv[1:]
    figure = plt.figure(figsize=(11, 4.6), dpi=110)
    draw_link(figure.add_subplot(1, 2, 1, projection="3d"), f"{folder}/foot.vtu")
    draw_residuals(figure.add_subplot(1, 2, 2), f"{folder}/residuals.csv", f"{folder}/comparison.json", readings)
    figure.tight_layout(w_pad=4)
    figure.savefig(picture)


main()
