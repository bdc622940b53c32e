"""What Python has of the commands on robots and readings: closed forms, and the same bytes as the program.

usage: commands_test.py PROGRAM SOURCE      with the package on PYTHONPATH"""
import json
import os
import pathlib
import pickle
import signal
import subprocess
import sys
import tempfile
import time
import unittest
import warnings

import numpy as np

import kinetostat as ks

PROGRAM = SOURCE = ""  # from the command line

STIFFNESS, LENGTH, MASS = 2.0e4, 0.5, 8.0  # N m/rad, m, kg

PENDULUM = f"""kinetostat: 1
name: pendulum
units: {{length: m, force: N, angle: rad}}
chain_types:
  arm:
    - actuator: {{name: q1, axis: Rz, stiffness: {{value: {STIFFNESS}, sd: 4 %}}}}
    - offset: [{LENGTH}, 0, 0]
    - node: {{name: load}}
    - mass: {{name: ball, mass: {MASS}}}
manipulator: {{chain: arm}}
"""


def source(name):
    return os.path.join(SOURCE, name)


class Commands(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def path(self, name, text=None):
        path = pathlib.Path(self.folder.name, name)
        if text is not None:
            path.write_text(text)
        return path

    def pendulum(self, text=PENDULUM):
        return ks.Robot.read(self.path("pendulum.yaml", text))

    def program(self, *words):
        done = subprocess.run([PROGRAM, *map(str, words), "-q"], text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.assertEqual(done.returncode, 0, done.stderr)

    def assert_of_program(self, result, name):
        """All that the result has, the JSON of the program has, too."""
        by_program = json.loads(self.path(name).read_bytes())
        self.assertTrue(result)
        self.assertEqual(result, {key: by_program.get(key) for key in result})


class Modes(Commands):
    def test_a_ball_on_an_arm_swings_as_its_closed_form(self):
        omega = np.sqrt(STIFFNESS / MASS) / LENGTH
        damping = 0.02
        found = ks.modes(self.pendulum(), response="1:100:5", damping=damping)
        np.testing.assert_allclose(found.frequencies, [omega / (2 * np.pi)], rtol=1e-12)
        np.testing.assert_allclose(found.shapes, [np.array([0, 1, 0, 0, 0, 1 / LENGTH]) / np.sqrt(MASS)], rtol=1e-12, atol=1e-12)
        # As the root of a stiffness that is known to 4 %, with k = 2.
        np.testing.assert_allclose(found.expanded / found.frequencies, [0.04], rtol=1e-6)
        self.assertEqual((len(found), found.free_motions, found.mass), (1, 0, MASS))
        peak = found.response_frequencies.index(found.frequencies[0])
        self.assertEqual(found.receptance.shape, (len(found.response_frequencies), 6, 6))
        np.testing.assert_allclose(found.receptance[peak, 1, 1], -1j / (MASS * 2 * damping * omega**2), rtol=1e-9)
        self.assertTrue(repr(found).startswith("Modes: First natural frequency 15.9 Hz"))
        plain = ks.modes(self.pendulum(), uncertainty=False)
        self.assertEqual((plain.expanded, plain.receptance, plain.response_frequencies), (None, None, None))

    def test_a_pull_outwards_raises_the_frequency(self):
        pull = 3e4
        found = ks.modes(self.pendulum(), wrench=[pull, 0, 0])
        omega = np.sqrt((STIFFNESS + pull * LENGTH) / MASS) / LENGTH
        np.testing.assert_allclose(found.frequencies, [omega / (2 * np.pi)], rtol=1e-9)
        at_node = ks.modes(self.pendulum(), node_loads={"load": [pull, 0, 0]})
        np.testing.assert_allclose(at_node.frequencies, found.frequencies, rtol=1e-9)

    def test_they_are_those_of_the_program(self):
        robot = ks.Robot.read(source("data/robots/gantry.yaml"))
        found = ks.modes(robot, robot.posture(joints={"x": 0.1, "y": -0.05}), modes=4, draws=20, seed=3, response="5:200:20", loss_factor=0.04)
        self.program("modes", robot.file, "--joints", "x=0.1 m,y=-0.05 m", "--modes", 4, "--draws", 20, "--seed", 3, "--response", "5:200:20",
                     "--loss-factor", 0.04, "-o", self.path("modes.json"))
        found.write(self.path("python.json"))
        self.assertEqual(self.path("python.json").read_bytes(), self.path("modes.json").read_bytes())
        self.assertEqual(found.to_json().encode(), self.path("modes.json").read_bytes())
        heavy = ks.Robot.read(source("data/robots/heavy_arm.yaml"))
        self.program("modes", heavy.file, "--weight", "--wrench", "0 N,0 N,-500 N", "-o", self.path("heavy.json"))
        self.assertEqual(ks.modes(heavy, weight=True, wrench=[0, 0, -500]).to_json().encode(), self.path("heavy.json").read_bytes())

    def test_a_posture_that_was_sent_elsewhere_is_the_same(self):
        robot = ks.Robot.read(source("data/robots/gantry.yaml"))
        for posture in (robot.posture(at=robot.posture(joints={"x": 0.1}).pose), robot.posture(joints={"z": 0.02})):
            there = pickle.loads(pickle.dumps(posture))
            self.assertEqual(ks.modes(robot, there).to_json(), ks.modes(robot, posture).to_json())
            np.testing.assert_allclose(ks.modes(robot, posture).result["posture"]["position"], posture.position, atol=1e-9)

    def test_what_cannot_be_asked_is_refused(self):
        robot = self.pendulum()
        massless = ks.Robot.parse(PENDULUM.replace(f"    - mass: {{name: ball, mass: {MASS}}}\n", ""), self.path("light.yaml"))
        with self.assertRaisesRegex(ks.InputError, "has a mass"):
            ks.modes(massless)
        other = ks.Robot.read(source("data/robots/gantry.yaml")).posture()
        for why, call in (("modes: 0", lambda: ks.modes(robot, modes=0)), ("damping", lambda: ks.modes(robot, response="1:9")),
                          ("range of frequencies", lambda: ks.modes(robot, response="9:1", damping=0.1)),
                          ("exclude", lambda: ks.modes(robot, damping=0.1, loss_factor=0.1)), ("draws: 1", lambda: ks.modes(robot, draws=1)),
                          ("not wanted", lambda: ks.modes(robot, draws=9, uncertainty=False)), ("a wrench is", lambda: ks.modes(robot, wrench=[1])),
                          ("no node 'lod'", lambda: ks.modes(robot, node_loads={"lod": [1, 0, 0]})), ("another robot", lambda: ks.modes(robot, other))):
            with self.assertRaisesRegex(ks.ArgumentError, why):
                call()


class Traces(Commands):
    def test_an_arm_that_is_pushed_along_itself_buckles_where_it_should(self):
        critical = STIFFNESS / LENGTH
        found = ks.trace(self.pendulum(), wrench=[-1.5 * critical, 0, 0])
        point = found.critical_points[0]
        self.assertEqual(point["kind"], "bifurcation")
        self.assertAlmostEqual(point["point"]["along"]["force"] / critical, 1, places=9)
        columns = found.columns()
        np.testing.assert_allclose(columns["fx"], -1.5 * critical * columns["parameter"], atol=1e-6)
        np.testing.assert_array_equal(columns["stable"], columns["parameter"] < 1 / 1.5)
        self.assertEqual({len(column) for column in columns.values()}, {len(found)})
        np.testing.assert_array_equal(ks.frame_of(found)["fx"], columns["fx"])
        self.assertTrue(repr(found).startswith("Trace: First critical point, a bifurcation"))

    def test_force_over_deflection_is_that_of_the_joint(self):
        columns = ks.trace(self.pendulum(), wrench=[0, 3000, 0]).columns()
        angle = columns["rz"]
        np.testing.assert_allclose(columns["force"] * LENGTH * np.cos(angle), STIFFNESS * angle, rtol=1e-8, atol=1e-6)
        np.testing.assert_allclose(columns["deflection"], LENGTH * np.sin(angle), rtol=1e-8, atol=1e-12)
        self.assertGreater(angle[-1], 0.07)
        self.assertAlmostEqual(columns["stiffness"][0] / (STIFFNESS / LENGTH**2), 1, places=6)

    def test_they_are_those_of_the_program(self):
        robot = ks.Robot.read(source("data/robots/urrs_c.yaml"))
        found = ks.trace(robot, along=[-0.02, 0, 0], branches=True, points=20, segments=[1, 2])
        self.program("trace", robot.file, "--along", "-0.02 m,0 m,0 m", "--branches", "--points", 20, "--segments", "1,2", "-o",
                     self.path("path.csv"), "--json", self.path("path.json"))
        self.assertEqual(found.to_csv().encode(), self.path("path.csv").read_bytes())
        self.assert_of_program(found.result, "path.json")
        found.write(self.path("python.csv"))
        self.assertEqual(self.path("python.csv").read_bytes(), self.path("path.csv").read_bytes())
        gantry = ks.Robot.read(source("data/robots/gantry.yaml"))
        self.program("trace", gantry.file, "--along", "0 m,0 m,-0.001 m", "--json", self.path("gantry.json"))
        self.assert_of_program(ks.trace(gantry, along=[0, 0, -1e-3]).result, "gantry.json")

    def test_what_cannot_be_followed_is_refused(self):
        robot = self.pendulum()
        for why, call in (("nothing is given that grows", lambda: ks.trace(robot)), ("nothing grows", lambda: ks.trace(robot, wrench=[0, 0, 0])),
                          ("either a wrench", lambda: ks.trace(robot, wrench=[1, 0, 0], along=[1, 0, 0])),
                          ("must hold the start", lambda: ks.trace(robot, wrench=[0, 1, 0], lowest=0.5)),
                          ("points", lambda: ks.trace(robot, wrench=[0, 1, 0], points=0)),
                          ("segments", lambda: ks.trace(robot, wrench=[0, 1, 0], segments=[0]))):
            with self.assertRaisesRegex(ks.ArgumentError, why):
                call()


class Uncertainties(Commands):
    def test_a_compliance_is_as_uncertain_as_its_spring(self):
        found = ks.uncertainty(self.pendulum())
        along = found.names.index("compliance_along")
        self.assertAlmostEqual(found.values[along] * STIFFNESS / LENGTH**2, 1, places=12)
        self.assertAlmostEqual(found.standard[along] / found.values[along], 0.04, places=8)
        np.testing.assert_array_equal(found.expanded, 2 * found.standard)
        self.assertAlmostEqual(found.values[found.names.index("compliance[1,5]")] * STIFFNESS / LENGTH, 1, places=12)
        np.testing.assert_allclose(np.sqrt(np.diag(found.covariance)), found.standard, rtol=1e-12, atol=1e-30)
        budget = found.budget("compliance_along")
        self.assertEqual(([part["source"] for part in budget], budget[0]["share"]), (["stiffness of q1"], 1.0))
        self.assertIsNone(found.draws)
        self.assertTrue(repr(found).startswith("Uncertainty: Softest along y"))

    def test_a_held_displacement_leaves_the_force_uncertain(self):
        move = [LENGTH * (np.cos(0.01) - 1), LENGTH * np.sin(0.01), 0, 0, 0, 0.01]
        found = ks.uncertainty(self.pendulum(), move=move)
        values, standard = dict(zip(found.names, found.values)), dict(zip(found.names, found.standard))
        self.assertAlmostEqual(standard["force"] / values["force"], 0.04, places=6)
        self.assertAlmostEqual(standard["moved"] / values["moved"], 0, places=9)

    def test_draws_scatter_as_the_first_order_says(self):
        found = ks.uncertainty(self.pendulum(), wrench=[0, 10, 0], draws=400)
        moved = found.names.index("moved")
        self.assertEqual(found.draws.shape, (400, len(found.names)))
        self.assertLess(abs(found.draws[:, moved].std() / found.standard[moved] - 1), 0.05)

    def test_they_are_those_of_the_program(self):
        robot = ks.Robot.read(source("data/robots/gantry.yaml"))
        self.program("stiffness", robot.file, "--draws", 20, "--json", self.path("stiffness.json"))
        found = ks.uncertainty(robot, draws=20)
        self.assertEqual(found.result, json.loads(self.path("stiffness.json").read_bytes())["uncertainty"])
        self.program("deflect", robot.file, "--at", "0.05 m,0.02 m,0 m", "--wrench", "0 N,0 N,-500 N", "--json", self.path("deflect.json"))
        there = ks.uncertainty(robot, robot.posture(at=[0.05, 0.02, 0]), wrench=[0, 0, -500])
        self.assertEqual(there.result, json.loads(self.path("deflect.json").read_bytes())["uncertainty"])
        self.assertEqual(there.headline, json.loads(self.path("deflect.json").read_bytes())["headline"])

    def test_ctrl_c_stops_many_draws_within_a_second(self):
        code = (f"import kinetostat as ks; r = ks.Robot.read({source('data/robots/gantry.yaml')!r})\n"
                "try: ks.uncertainty(r, draws=100000, threads=1, progress=lambda phase, done: print(phase, flush=True))\n"
                "except KeyboardInterrupt: print('stopped', flush=True)")
        child = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
        self.assertTrue(child.stdout.readline())
        start = time.monotonic()
        child.send_signal(signal.SIGINT)
        rest, _ = child.communicate(timeout=60)
        self.assertLess(time.monotonic() - start, 1)
        self.assertTrue(rest.endswith("stopped\n"), rest)

    def test_an_exception_of_progress_stops_and_comes_out(self):
        def progress(phase, done):
            raise LookupError(phase)
        with self.assertRaises(LookupError):
            ks.uncertainty(self.pendulum(), draws=100000, progress=progress)

    def test_a_robot_without_uncertain_numbers_is_refused(self):
        with self.assertRaisesRegex(ks.ArgumentError, "of no number that it is uncertain"):
            ks.uncertainty(ks.Robot.read(source("data/robots/six_axis.yaml")))
        with self.assertRaisesRegex(ks.ArgumentError, "no number 'nothing'"):
            ks.uncertainty(self.pendulum()).budget("nothing")


class Exports(Commands):
    def test_files_are_those_of_the_program(self):
        robot = ks.Robot.read(source("data/robots/six_axis.yaml"))
        posture = robot.posture(joints={"q2": 0.3})
        for extension, form in ((".xml", "mjcf"), (".urdf", "urdf"), (".sdf", "sdf"), (".mo", "modelica"), (".m", "matlab")):
            by_program, by_python = self.path("program" + extension), self.path("python" + extension)
            self.program("export", robot.file, "--joints", "q2=0.3 rad", "--damping", 0.1, "-o", by_program)
            file = ks.export(robot, by_python, posture=posture, damping=0.1)
            self.assertEqual(by_python.read_bytes(), by_program.read_bytes())
            self.assertEqual((file.format, file.text.encode()), (form, by_python.read_bytes()))
            self.assertEqual(ks.export(robot, format=form, posture=posture, damping=0.1).text, file.text)
            self.assertTrue(repr(file).startswith("SimulatorFile: six-axis arm"))

    def test_what_cannot_be_exported_is_refused(self):
        robot = ks.Robot.read(source("data/robots/orthoglide.yaml"))
        there = self.path("robot.xml")
        with self.assertRaisesRegex(ks.InputError, "one chain"):
            ks.export(robot, there)
        for why, words in (("format: 'stl'", ("robot.xml", "stl")), ("does not say the format", ("robot.txt", ""))):
            with self.assertRaisesRegex(ks.ArgumentError, why):
                ks.export(robot, self.path(words[0]), words[1])
        self.assertFalse(there.exists())


def bar_stl(length, y, z, pieces=12):
    """A bar along x, closed, of two triangles a side of each piece."""
    def corner(piece, i):
        return (length * (piece + (i & 1)) / pieces, y / 2 if i & 2 else -y / 2, z / 2 if i & 4 else -z / 2)
    sides = [(piece, side) for piece in range(pieces) for side in ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3))]
    lines = []
    for piece, (a, b, c, d) in [*sides, (0, (0, 4, 6, 2)), (pieces - 1, (1, 3, 7, 5))]:
        for triangle in ((a, b, c), (a, c, d)):
            vertices = "".join("vertex {} {} {}\n".format(*corner(piece, i)) for i in triangle)
            lines.append(f"facet normal 0 0 0\nouter loop\n{vertices}endloop\nendfacet\n")
    return "solid bar\n" + "".join(lines) + "endsolid bar\n"


class Imports(Commands):
    LENGTH, WIDTH, HEIGHT = 0.6, 0.04, 0.06  # m

    def bar(self):
        """One bar between two joints about its axis, of a mesh in a package, and a hand whose mesh is nowhere."""
        meshes = self.path("parts") / "meshes"
        meshes.mkdir(parents=True)
        (meshes / "bar.stl").write_text(bar_stl(self.LENGTH, self.WIDTH, self.HEIGHT, 24))
        joint = '<joint name="{}" type="continuous"><parent link="{}"/><child link="{}"/><origin xyz="{} 0 0"/><axis xyz="1 0 0"/></joint>'
        shape = '<visual><geometry><mesh filename="package://{}"/></geometry></visual>'
        return self.path("bar.urdf", '<robot name="bar"><link name="base"/><link name="bar">' + shape.format("bar_parts/meshes/bar.stl")
                         + '</link><link name="hand">' + shape.format("other/hand.stl") + "</link>" + joint.format("one", "base", "bar", 0)
                         + joint.format("two", "bar", "hand", self.LENGTH) + "</robot>")

    def test_links_are_identified_from_their_meshes_as_by_the_program(self):
        urdf = self.bar()
        for name in ("program", "python"):
            self.path(name).mkdir()
        self.program("import", urdf, "--package", f"bar_parts={self.path('parts')}", "--identify", "--material", "aluminium", "--accuracy", "2 %",
                     "--joint-stiffness", "5e4", "-o", self.path("program") / "bar.yaml")
        out, phases = self.path("python") / "bar.yaml", set()
        with self.assertWarnsRegex(UserWarning, "link hand was not identified: .*its package is not known"):
            robot = ks.Robot.from_urdf(urdf, 5e4, packages={"bar_parts": self.path("parts")}, identify=True, material="aluminium",
                                       accuracy="2 %", out=out, progress=lambda phase, done: phases.add(phase))
        self.assertEqual(out.read_bytes(), (self.path("program") / "bar.yaml").read_bytes())
        self.assertEqual((robot.file, robot.text), (str(out), out.read_text()))
        self.assertTrue(phases)
        modulus, area = 70e9, self.WIDTH * self.HEIGHT
        shear = modulus / 2.66
        compliance = robot.compliance().array
        for axis, moment in ((1, self.HEIGHT * self.WIDTH**3 / 12), (2, self.WIDTH * self.HEIGHT**3 / 12)):
            cantilever = self.LENGTH**3 / (3 * modulus * moment) + 1.2 * self.LENGTH / (shear * area)
            self.assertAlmostEqual(compliance[axis, axis] / cantilever, 1, delta=0.03)

    def test_what_links_need_is_asked_for(self):
        urdf = self.bar()
        for why, given in (("out=", {"identify": True, "material": "steel"}), ("material=", {"identify": True, "out": self.path("a.yaml")}),
                           ("identified", {"material": "steel"}),
                           ("no material", {"identify": True, "material": "wood", "out": self.path("a.yaml")}),
                           ("accuracy", {"identify": True, "material": "steel", "accuracy": "80", "out": self.path("a.yaml")}),
                           ("no folder", {"identify": True, "material": "steel", "packages": {"a": "nowhere"}, "out": self.path("a.yaml")})):
            with self.assertRaisesRegex(ks.ArgumentError, why):
                ks.Robot.from_urdf(urdf, 5e4, **given)
        self.assertFalse(self.path("a.yaml").exists())

    def test_a_robot_is_written_as_by_the_program(self):
        urdf = source("data/urdf/six_axis.urdf")
        self.program("import", urdf, "--tip", "flange", "--joint-stiffness", "5e4 N m/rad", "-o", self.path("program.yaml"))
        robot = ks.Robot.from_urdf(urdf, "5e4 N m/rad", tip="flange", out=self.path("python.yaml"))
        self.assertEqual(self.path("python.yaml").read_bytes(), self.path("program.yaml").read_bytes())
        self.assertEqual(robot.file, str(self.path("python.yaml")))


class Readings(Commands):
    def plan(self):
        random = np.random.default_rng(2)
        rows = [",".join(f"{angle:.3f}" for angle in random.uniform(-1, 1, 6) * (60, 40, 40, 90, 60, 90)) for _ in range(30)]
        return self.path("plan.csv", "\n".join(["q1,q2,q3,q4,q5,q6", *rows]) + "\n")

    def test_an_offset_that_was_hidden_is_found(self):
        robot = ks.Robot.read(source("data/robots/six_axis.yaml"))
        hidden = {"effect": "joint_offset", "at": "q3", "offset": "1 mrad"}
        made = ks.simulate(robot, self.path("synthetic"), self.plan(), absolute=True, noise_translation=1e-5, effects=[hidden])
        self.assertEqual((len(made.campaign), made.campaign.robot.text), (30, robot.text))
        found = ks.calibrate(made.campaign, hold_out=5)
        at = found.names.index("the offset of q3")
        self.assertLess(abs(found.values[at] - 1e-3), 4 * found.deviations[at])
        self.assertLess(found.deviations[at], 5e-5)
        others = [k for k, name in enumerate(found.names) if name.startswith("the offset") and k != at]
        self.assertTrue(others)
        for k in others:
            self.assertLess(abs(found.values[k]), 4 * found.deviations[k])
        self.assertEqual(found.correlation.shape, (len(found.names),) * 2)
        better = ks.compare(ks.Campaign.read(self.path("synthetic") / "campaign.yaml", robot=found.robot))
        self.assertLess(better.error_over_noise, 1.5)
        self.assertGreater(ks.compare(made.campaign).error_over_noise, 5)
        self.assertTrue(repr(found).startswith("Calibration: Kinematics calibrated"))

    def test_a_calibration_is_that_of_the_program(self):
        campaign = ks.Campaign.read(source("data/measurements/ur10_tracker/campaign.yaml"))
        phases = set()
        found = ks.calibrate(campaign, hold_out=2, tolerance=(5e-4, 5e-4), progress=lambda phase, done: phases.add(phase))
        self.program("calibrate", source("data/measurements/ur10_tracker/campaign.yaml"), "--hold-out", 2, "--tolerance", "0.0005 m,0.0005 rad",
                     "-o", self.path("program.yaml"), "--json", self.path("program.json"))
        written = found.write(self.path("python.yaml"))
        self.assertEqual(self.path("python.yaml").read_bytes(), self.path("program.yaml").read_bytes())
        self.assertEqual((written.text, found.robot.text), (self.path("python.yaml").read_text(),) * 2)
        self.assert_of_program(found.result, "program.json")
        self.assertTrue(phases)
        self.assertEqual([g["value"] for g in found.result["geometry"]], list(found.values))
        for wrong in ({"hold_out": -1}, {"tolerance": (0, 1)}, {"robust": "hubert"}):
            with self.assertRaises(ks.ArgumentError):
                ks.calibrate(campaign, **wrong)

    def test_simulated_readings_are_those_of_the_program(self):
        robot, plan = ks.Robot.read(source("data/robots/orthoglide.yaml")), source("data/measurements/plans/orthoglide.csv")
        made = ks.simulate(robot, self.path("python"), plan, noise_translation="5 um", noise_rotation=2e-5, seed=7,
                           effects=[{"effect": "clearance", "at": "x.rho", "gap": "20 um"}])
        self.program("simulate", robot.file, "--plan", plan, "--noise-translation", "5 um", "--noise-rotation", "2e-05 rad", "--seed", 7,
                     "--effect", "clearance", "--at", "x.rho", "--size", "gap=20 um", "--out", self.path("program"),
                     "--json", self.path("program.json"))
        for name in ("campaign.yaml", "readings.csv"):
            self.assertEqual((self.path("python") / name).read_bytes(), (self.path("program") / name).read_bytes())
        by_program = json.loads(self.path("program.json").read_bytes())
        self.assertEqual(made.result["hidden"], by_program["hidden"])
        self.assertEqual(made.folder, str(self.path("python")))
        self.assertIn(made.folder, repr(made))
        in_si = ks.simulate(robot, self.path("in_si"), plan, noise_translation=5e-6, noise_rotation=2e-5, seed=7,
                            effects=[{"effect": "clearance", "at": "x.rho", "gap": 20e-6}])
        self.assertEqual(in_si.result["hidden"], by_program["hidden"])
        again = ks.simulate(robot, self.path("again"), like=self.path("python") / "campaign.yaml", seed=8)
        self.program("simulate", robot.file, "--like", self.path("program/campaign.yaml"), "--seed", 8, "--out", self.path("program_again"))
        self.assertEqual((self.path("again") / "readings.csv").read_bytes(), self.path("program_again/readings.csv").read_bytes())
        self.assertEqual(len(again.campaign), len(made.campaign))

    def test_measured_readings_are_not_written_over(self):
        robot = ks.Robot.read(source("data/robots/orthoglide.yaml"))
        self.path("measured").mkdir()
        readings = self.path("measured/readings.csv", "x,y,z\n")
        with self.assertRaisesRegex(ks.InputError, "not made by 'simulate'"):
            ks.simulate(robot, self.path("measured"), source("data/measurements/plans/orthoglide.csv"))
        self.assertEqual(readings.read_text(), "x,y,z\n")
        with self.assertRaisesRegex(ks.ArgumentError, "plan"):
            ks.simulate(robot, self.path("synthetic"))
        with self.assertRaisesRegex(ks.ArgumentError, "write"):
            ks.simulate(ks.Robot.parse(robot.text, self.path("orthoglide.yaml")), self.path("synthetic"))
        with self.assertRaisesRegex(ks.ArgumentError, "each of the effects"):
            ks.simulate(robot, self.path("synthetic"), effects=[{"effect": "clearance"}])

    def test_warnings_of_a_command_are_those_of_python(self):
        limited = self.pendulum(PENDULUM.replace("sd: 4 %}", "sd: 4 %}, range: [-1, 1]"))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            beyond = limited.posture(joints={"q1": 1.5})
        with self.assertWarnsRegex(UserWarning, "^joint q1 stands at 1.5 rad"):
            ks.modes(limited, beyond)


if __name__ == "__main__":
    PROGRAM, SOURCE = sys.argv[1:3]
    del sys.argv[1:3]
    unittest.main(verbosity=2)
