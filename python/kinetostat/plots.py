"""Charts by matplotlib, in the colours of the pages. Each draws into `axes`, or new ones, and returns them."""

import textwrap
from typing import Any, Dict, Optional, Union

import numpy as np

from ._core import ArgumentError, ArgumentTypeError, Comparison, Compliance, Diagnosis, Map, Stiffness

#: As in the style sheet of the pages, by light.
COLOURS: Dict[str, str] = {
    "ink": "#1c2430", "quiet": "#5a6675", "line": "#d9dee5", "paper": "#ffffff", "nominal": "#6b7683", "fitted": "#2a6fb5",
    "final": "#12805c", "held": "#b35a08", "noise": "#8b95a1", "chosen": "#b0136f", "bad": "#b3261e"}
#: From soft to stiff, as maps of the pages.
SCALE = "viridis"


def _new_axes(axes: Any, **keys: Any) -> Any:
    if axes is None:
        import matplotlib.pyplot as plt
        axes = plt.figure(figsize=(6.4, 4.2), facecolor=COLOURS["paper"], layout="constrained").add_subplot(**keys)
    for spine in getattr(axes, "spines", {}).values():
        spine.set_color(COLOURS["line"])
    axes.tick_params(colors=COLOURS["quiet"])
    return axes


def _label(axes: Any, x: str, y: str, title: str) -> Any:
    axes.set_xlabel(x, color=COLOURS["ink"])
    axes.set_ylabel(y, color=COLOURS["ink"])
    axes.set_title(textwrap.fill(title, 58), color=COLOURS["ink"], loc="left", fontsize="small")
    return axes


def _require(value: Any, *kinds: type) -> None:
    if not isinstance(value, kinds):
        wanted = " or a ".join(kind.__name__ for kind in kinds)
        raise ArgumentTypeError(f"this chart is of a {wanted}, not of {'None' if value is None else 'a ' + type(value).__name__}")


def _coordinate(name: str) -> str:
    return f"{name}, {'rad' if name.startswith('r') else 'm'}"


def _stage_colour(name: str, last: bool) -> str:
    if "noise" in name:
        return COLOURS["noise"]
    return COLOURS["nominal"] if "as designed" in name else COLOURS["final"] if last else COLOURS["fitted"]


def waterfall(result: Union[Diagnosis, Comparison], axes: Any = None) -> Any:
    """How the error falls from model to model, in units of the noise: of a diagnosis on readings that are left out of the fit in
    turn, with intervals; of a comparison on the readings that were fitted."""
    _require(result, Diagnosis, Comparison)
    if isinstance(result, Diagnosis):
        stages = [(one["name"], one["whitened"], one.get("lower"), one.get("upper")) for one in result.result["waterfall"]]
    else:
        fits = ((name, result.result.get(name.replace(" ", "_"))) for name in ("as designed", "refitted"))
        stages = [(name, fit["error_over_noise"], None, None) for name, fit in fits if fit]
    stages = [one for one in stages if one[1] is not None]
    axes = _new_axes(axes)
    models = [name for name, *_ in stages if "noise" not in name]
    for at, (name, error, lower, upper) in enumerate(stages):
        whiskers = None if lower is None or upper is None else [[max(0, error - lower)], [max(0, upper - error)]]
        axes.barh(at, error, color=_stage_colour(name, len(models) > 1 and name == models[-1]), xerr=whiskers,
                  ecolor=COLOURS["ink"], capsize=3)
    names = [name.replace("as designed", "nominal").replace("refitted", "fitted") for name, *_ in stages]
    axes.set_yticks(range(len(stages)), names)
    axes.invert_yaxis()
    axes.axvline(1, color=COLOURS["noise"], linestyle="--", linewidth=1)
    return _label(axes, "error, times the noise", "", result.headline)


def stiffness_map(found: Map, index: Optional[str] = None, axes: Any = None) -> Any:
    """One index over the first two coordinates that vary; along the poses where only one does, or none."""
    _require(found, Map)
    columns = found.columns()
    if index is not None and index not in found.indices:
        raise ArgumentError(f"the map has no index '{index}': it has " + ", ".join(f"'{one}'" for one in found.indices))
    name = index if index is not None else found.indices[0]
    moving = [key for key in ("x", "y", "z", "rx", "ry", "rz") if np.ptp(columns[key]) > 0]
    axes = _new_axes(axes)
    values = np.asarray(columns[name])
    finite = np.isfinite(values)
    if len(moving) < 2:
        across = columns[moving[0]] if moving else np.arange(len(values))
        axes.plot(across, values, color=COLOURS["nominal"], marker="o", markersize=3)
        return _label(axes, _coordinate(moving[0]) if moving else "pose", f"{name}, SI", found.headline)
    x, y = (np.asarray(columns[key]) for key in moving[:2])
    axes.scatter(x[~finite], y[~finite], color=COLOURS["line"], marker="x")
    points = axes.scatter(x[finite], y[finite], c=values[finite], cmap=SCALE, marker="s", s=60)
    axes.figure.colorbar(points, ax=axes, label=f"{name}, SI")
    axes.set_aspect("equal", adjustable="datalim")
    return _label(axes, _coordinate(moving[0]), _coordinate(moving[1]), found.headline)


def ellipsoid(compliance: Union[Compliance, Stiffness], force: float = 1.0, axes: Any = None) -> Any:
    """Where a force of this size [N] takes the point, from all directions: x = C F, C the translational 3x3 [m/N].

    A Stiffness is drawn by its inverse."""
    _require(compliance, Compliance, Stiffness)
    if isinstance(compliance, Stiffness):
        compliance = compliance.inverse()
    u, v = np.mgrid[0:2 * np.pi:49j, 0:np.pi:25j]
    sphere = np.stack([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)])
    there = np.einsum("ij,jkl->ikl", force * compliance.array[:3, :3], sphere)
    axes = _new_axes(axes, projection="3d")
    axes.plot_surface(*there, color=COLOURS["nominal"], alpha=0.35, linewidth=0)
    sizes, directions = np.linalg.eigh(force * compliance.array[:3, :3])
    for size, direction, colour in zip(sizes, directions.T, ("fitted", "final", "held")):  # stiffest to softest
        axes.plot(*np.stack([-size * direction, size * direction], axis=1), color=COLOURS[colour], label=f"{size:.3g} m")
    axes.legend(loc="upper right")
    axes.set_box_aspect((1, 1, 1))
    axes.set_zlabel("z, m", color=COLOURS["ink"])
    return _label(axes, "x, m", "y, m", f"displacement under {force:g} N from all sides")


def load_deflection(diagnosis: Diagnosis, axes: Any = None) -> Any:
    """Load against deflection at the joint of the first effect found: readings, the model without the effect, and with it."""
    _require(diagnosis, Diagnosis)
    curve = diagnosis.joint_curve()
    if curve is None:
        raise ArgumentError("no effect was found at a joint with a spring")
    axes = _new_axes(axes)
    load = np.asarray(curve["load"], dtype=float)
    order = np.argsort(load)
    axes.errorbar(curve["measured"], load, xerr=2 * np.asarray(curve["deviation"], dtype=float), fmt="o", markersize=3,
                  color=COLOURS["held"], ecolor=COLOURS["noise"], label="readings")
    for key, label, colour in (("without", "without the effect", "nominal"), ("with", "with the effect", "final")):
        axes.plot(np.asarray(curve[key], dtype=float)[order], load[order], color=COLOURS[colour], label=label)
    axes.legend()
    angular = curve["turns"]
    return _label(axes, f"deflection, {'rad' if angular else 'm'}", f"load, {'N m' if angular else 'N'}", curve["effect"])
