#!/usr/bin/python3
"""What calls from Python cost [us]: the package on PYTHONPATH, in the source folder.

    PYTHONPATH=build/release/python bench/python_calls.py"""
import timeit

import kinetostat as ks

arm = ks.Robot.read("data/robots/six_axis.yaml")
home = arm.posture()
for call in ("arm.name", "home.position", "arm.posture()", "arm.stiffness(home)", "arm.compliance(home)", "arm.deflect([0, 0, -100], home)"):
    count = 2000
    print(f"{call:34}{min(timeit.repeat(call, globals=globals(), number=count, repeat=5)) / count * 1e6:8.2f}")
