#!/usr/bin/python3
"""How the time of a diagnosis grows with readings and with the catalogue: a six-axis arm with backlash in its elbow,
pushed and released in random postures, diagnosed with the whole catalogue and with every second effect of it.

    bench/diagnosis_growth.py [READINGS ...] [--threads N] [--program build/release/kinetostat]"""
import argparse
import json
import os
import random
import subprocess
import tempfile
import time

ROBOT = "data/measurements/six_axis_balancer/robot.yaml"
HIDDEN = ("clearance", "arm.q3", "1.5e-4 rad")
RANGES = ((-100, 100), (-60, 40), (-40, 60), (-150, 150), (-90, 90), (-150, 150))
CYCLE = (0, 0.5, 1, 0.5, 0, -0.6)  # of 600 N
SECONDS = 35


def plan(count):
    random.seed(count)
    rows = ["session,cycle,step,time,q1,q2,q3,q4,q5,q6,fx,fy,fz"]
    for reading in range(count):
        cycle, step = divmod(reading, len(CYCLE))
        if step == 0:
            joints = [random.uniform(*limits) for limits in RANGES]
            direction = [random.gauss(0, 1) for _ in range(3)]
            length = sum(x * x for x in direction) ** 0.5
        force = [600 * CYCLE[step] * x / length for x in direction]
        rows.append(",".join(["monday", str(cycle + 1), str(step + 1), str(SECONDS * (reading + 1))]
                             + [f"{x:.3f}" for x in joints + force]))
    return "\n".join(rows) + "\n"


def simulated(program, count, folder):
    table = os.path.join(folder, "plan.csv")
    with open(table, "w", encoding="utf-8") as file:
        file.write(plan(count))
    effect, place, size = HIDDEN
    subprocess.run([program, "simulate", ROBOT, "--plan", table, "--noise-translation", "10 um", "--effect", effect,
                    "--at", place, "--size", size, "-o", folder, "--quiet"], check=True, stdout=subprocess.DEVNULL)
    return os.path.join(folder, "campaign.yaml")


def every_second_effect(program):
    listed = subprocess.run([program, "effect", "list", "--json", "-"], check=True, capture_output=True, text=True)
    names = [effect["name"] for effect in json.loads(listed.stdout)["effects"] if effect["name"] != HIDDEN[0]]
    return ",".join([HIDDEN[0]] + names[::2])


def measured(command):
    """Wall and processor time [s], most memory [MB]."""
    start, child = time.monotonic(), subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(child.pid, 0)
    if status != 0:
        raise SystemExit(f"{' '.join(command)} failed")
    return time.monotonic() - start, usage.ru_utime + usage.ru_stime, usage.ru_maxrss * 1024 / 1e6


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("readings", type=int, nargs="*", default=[300, 3000, 30000])
    parser.add_argument("--threads", default="2")
    parser.add_argument("--program", default="build/release/kinetostat")
    options = parser.parse_args()
    print("| readings | effects | wall time | processor time | memory |\n|---|---|---|---|---|")
    half = every_second_effect(options.program)
    for count in options.readings:
        with tempfile.TemporaryDirectory() as folder:
            diagnose = [options.program, "diagnose", simulated(options.program, count, folder), "--no-cache",
                        "--threads", options.threads]
            for name, some in (("all", []), ("every second", ["--effects", half])):
                wall, processor, memory = measured(diagnose + some)
                print(f"| {count:,} | {name} | {wall:.1f} s | {processor:.1f} s | {memory:.0f} MB |", flush=True)


if __name__ == "__main__":
    main()
