"""Readings that are in memory already."""

import csv
import json
import numbers
import os
import tempfile
import warnings
from typing import Any, Dict, List, Mapping, Optional, Union

import numpy as np

from ._core import ArgumentError, ArgumentTypeError, Campaign, Comparison, Map, Robot, Trace


def campaign_of(table: Mapping[str, Any], robot: Union[Robot, str, "os.PathLike[str]"], *,
                folder: Optional[Union[str, "os.PathLike[str]"]] = None, **keys: Any) -> Campaign:
    """A campaign from columns by name: a pandas.DataFrame, or a dict of arrays of one length.

    The columns are those of a table of readings ("fz", "dz [um]", "q1", "session"), and `keys` those of a campaign file:
    units={"length": "m", "force": "N", "angle": "rad", "time": "s"} unless given, displacement="difference", noise=
    {"translation": 15e-6} or {"translation": "15 um"}. A column of booleans "mask", or "used" as frame_of() has it, says which
    readings are left out (1 and 0 will do). What frame_of() makes of a campaign is taken back, with the campaign's other keys but
    `wrench_frame` and `wrench_point`; loads of weights, cylinders and torques have no column. Both are written to `folder` (a new
    temporary one), as campaign.yaml and readings.csv, and read from there."""
    folder = os.fspath(folder) if folder is not None else tempfile.mkdtemp(prefix="kinetostat-")
    os.makedirs(folder, exist_ok=True)
    columns = _with_mask(_lists(table))
    if not columns:
        raise ArgumentError("there are no columns: give loads and displacements, {'fz': [...], 'dz': [...]}")
    if len({len(values) for values in columns.values()}) != 1:
        raise ArgumentError("columns differ in length: " + ", ".join(f"{name} {len(v)}" for name, v in columns.items()))
    with open(os.path.join(folder, "readings.csv"), "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        writer.writerows(["" if _is_missing(value) else value for value in row] for row in zip(*columns.values()))
    file_of_robot = robot.file if isinstance(robot, Robot) else os.fspath(robot)
    content = {"kinetostat": 1, "campaign": "readings in memory", "robot": os.path.abspath(file_of_robot),
               "units": {"length": "m", "force": "N", "angle": "rad", "time": "s"}, "displacement": "difference",
               **{key: _with_units(value) if key.endswith(("noise", "repeatability")) else value for key, value in keys.items()},
               "readings": "readings.csv"}
    campaign = os.path.join(folder, "campaign.yaml")
    with open(campaign, "w", encoding="utf-8") as file:
        json.dump(content, file, indent=1, default=_plain)  # which is YAML
    return Campaign.read(campaign, robot=robot)


def frame_of(value: Union[Campaign, Comparison, Map, Trace]) -> Any:
    """A pandas.DataFrame, SI: the readings of a campaign (conditions, postures, loads about their point, displacements,
    covariates; a warning where weights, cylinders or torques act, which are in no column), those of a comparison with what the best
    model leaves of them ("residual dz", and "whitened dz" in units of the noise), a map, one row a pose, or a path of equilibria,
    one row a point."""
    import pandas
    if not isinstance(value, (Campaign, Comparison, Map, Trace)):
        raise ArgumentTypeError(f"a campaign, a comparison, a map or a trace makes a frame, not {type(value).__name__}")
    campaign = value.campaign if isinstance(value, Comparison) else value
    if isinstance(campaign, Campaign) and campaign.has_loads_besides_wrench:
        warnings.warn("weights, cylinders or torques act in this campaign, which are in no column: campaign_of() does not take them back",
                      stacklevel=2)
    if not isinstance(value, Comparison):
        return pandas.DataFrame(value.columns())
    frame = pandas.DataFrame(value.campaign.columns())
    for kind, rows in (("residual", value.residuals), ("whitened", value.whitened)):
        for column, component in enumerate(value.campaign.components):
            frame[f"{kind} {component}"] = rows[:, column]
    return frame


def _with_units(noise: Any) -> Any:
    """Plain numbers are SI, which campaign files want said."""
    if not isinstance(noise, Mapping):
        return noise
    units = {"translation": "m", "rotation": "rad", "force": "N", "moment": "N m"}
    return {key: f"{float(value)!r} {units[key]}" if isinstance(value, numbers.Real) and key in units else value
            for key, value in noise.items()}


def _with_mask(columns: Dict[str, List[Any]]) -> Dict[str, List[Any]]:
    """With booleans as the format of tables has them, 0 or 1, and the rows that are not `used` masked."""
    def booleans(name: str) -> bool:
        return bool(columns.get(name)) and all(isinstance(value, (bool, np.bool_)) for value in columns[name])
    if "used" in columns:
        left_out = [not used for used in _truths("used", columns.pop("used"))]
        masked = _truths("mask", columns["mask"]) if "mask" in columns else left_out
        columns["mask"] = [one or other for one, other in zip(left_out, masked)]
    if booleans("mask"):
        masks = columns["mask"] = [int(value) for value in columns["mask"]]
        reasons = columns.get("mask_reason", [""] * len(masks))
        columns["mask_reason"] = ["masked in the program" if mask and (_is_missing(reason) or not reason) else reason
                                  for mask, reason in zip(masks, reasons)]
    return columns


def _truths(name: str, values: List[Any]) -> List[bool]:
    """Booleans, 1 and 0, or their words: anything else would decide about readings in silence."""
    words = {"true": True, "1": True, "1.0": True, "false": False, "0": False, "0.0": False}

    def truth(row: int, value: Any) -> bool:
        word = str(value).strip().lower()
        if word not in words:
            raise ArgumentError(f"the column '{name}' has {value!r} in row {row}: give True or False, or 1 or 0")
        return words[word]
    return [truth(row, value) for row, value in enumerate(values)]


def _lists(table: Mapping[str, Any]) -> Dict[str, List[Any]]:
    """Its columns, those that it has as a named index among them."""
    columns: Dict[str, List[Any]] = {}
    index = getattr(table, "index", None)
    for level, name in enumerate(getattr(index, "names", [])):
        if name is not None:
            columns[str(name)] = list(index.get_level_values(level))
    for name in table:
        if isinstance(table[name], str) or not hasattr(table[name], "__iter__"):
            raise ArgumentTypeError(f"the column '{name}' is {table[name]!r}: give a list, one value a reading")
        columns[str(name)] = list(table[name])
    return columns


def _plain(value: Any) -> Any:
    """What numpy has, as Python's own."""
    if hasattr(value, "tolist"):
        return value.tolist()
    raise ArgumentTypeError(f"{value!r} ({type(value).__name__}) cannot stand in a campaign file: give texts, numbers, lists and dicts")


def _is_missing(value: Any) -> bool:
    if value is None:
        return True
    try:
        return bool(value != value)
    except TypeError:  # pandas.NA is neither
        return True
