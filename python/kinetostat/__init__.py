"""Stiffness of robots and machine tools, and which physical effect a model of one lacks.

All numbers are in SI units: m, N, rad, and what is made of them. Matrices know the point and the axes that they are for.
A mistake in a file is an InputError with file, line, key and cure. compare(), diagnose() and plan() take
progress=lambda phase, fraction: ..., run on all processors unless threads=N says otherwise, and stop at Ctrl-C."""

from ._core import (Adoption, Campaign, Comparison, Compliance, Deflection, Diagnosis, Error, InputError, NoConvergence,
                    NotIdentifiable, Plan, Posture, Robot, Stiffness, __version__, adopt, compare, diagnose, plan)
from ._frames import campaign_of

__all__ = ["Adoption", "Campaign", "Comparison", "Compliance", "Deflection", "Diagnosis", "Error", "InputError",
           "NoConvergence", "NotIdentifiable", "Plan", "Posture", "Robot", "Stiffness", "__version__", "adopt",
           "campaign_of", "compare", "diagnose", "plan"]
