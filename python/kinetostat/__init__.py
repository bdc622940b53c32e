"""Stiffness of robots and machine tools, and which physical effect a model of one lacks.

All numbers are in SI units: m, N, rad, and what is made of them. Matrices know the point and the axes that they are for.
A mistake in a file is an InputError with file, line, key and cure. Functions that may take long, as compare(), diagnose(),
calibrate(), map_poses(), modes() and trace(), take progress=lambda phase, fraction: ..., run on all processors unless
threads=N says otherwise, and stop at Ctrl-C. kinetostat.plots draws results by matplotlib, kinetostat.cluster runs parts of long commands by Dask."""

from ._core import (Adoption, ArgumentError, ArgumentTypeError, Calibration, Campaign, Comparison, Compliance,
                    Deflection, Diagnosis, Error, InputError, Link, Map, Modes, NoConvergence, NotIdentifiable,
                    Plan, Posture, Robot, Simulation, SimulatorFile, Stiffness, Trace, Uncertainty, __version__,
                    adopt, calibrate, compare, diagnose, export, map_poses, modes, plan, simulate,
                    stiffness_matrices, trace, uncertainty)
from ._effects import EffectKind, effect_kind, with_effects
from ._frames import campaign_of, frame_of

__all__ = ["Adoption", "ArgumentError", "ArgumentTypeError", "Calibration", "Campaign", "Comparison", "Compliance",
           "Deflection", "Diagnosis", "EffectKind", "Error", "InputError", "Link", "Map", "Modes", "NoConvergence",
           "NotIdentifiable", "Plan", "Posture", "Robot", "Simulation", "SimulatorFile", "Stiffness", "Trace",
           "Uncertainty", "__version__", "adopt", "calibrate", "campaign_of", "compare", "diagnose", "effect_kind",
           "export", "frame_of", "map_poses", "modes", "plan", "simulate", "stiffness_matrices", "trace",
           "uncertainty", "with_effects"]
