"""The Python package: numbers against closed forms, results against the program, errors, Ctrl-C, stubs.

usage: package_test.py PROGRAM SOURCE      with the package on PYTHONPATH"""
import ast
import base64
import hashlib
import inspect
import copy
import json
import os
import pathlib
import pickle
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import warnings
import zipfile

import numpy as np

import kinetostat as ks
from kinetostat import _core

PROGRAM = SOURCE = ""  # from the command line

ARM = """kinetostat: 1
name: arm
units: {length: m, force: N, angle: rad}
chain_types:
  arm:
    - actuator: {name: q1, axis: Rz, stiffness: 2.0e5}
    - offset: [0.3, 0, 0]
    - actuator: {name: q2, axis: Rz, stiffness: 1.0e5}
    - tool: [0.2, 0, 0]
    - actuator: {name: lift, axis: Tz, stiffness: 4.0e6}
manipulator: {chain: arm}
"""

PAPER_CAMPAIGN = "data/measurements/nist_load_cell/campaign.yaml"
ARM_CAMPAIGN = "data/measurements/arm_backlash_soft_base/campaign.yaml"


def source(name):
    return os.path.join(SOURCE, name)


class Robots(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def path(self, name, text=None):
        path = pathlib.Path(self.folder.name, name)
        if text is not None:
            path.write_text(text)
        return path

    def arm(self):
        return ks.Robot.read(self.path("arm.yaml", ARM))

    def test_compliance_of_a_plane_arm_is_the_sum_over_its_joints(self):
        robot = self.arm()
        q1, q2 = 0.4, 0.9
        posture = robot.posture(joints={"q1": q1, "q2": q2})
        elbow = 0.3 * np.array([np.cos(q1), np.sin(q1), 0])
        tip = elbow + 0.2 * np.array([np.cos(q1 + q2), np.sin(q1 + q2), 0])
        np.testing.assert_allclose(posture.position, tip, atol=1e-12)
        np.testing.assert_allclose(posture.pose[:3, 3], tip, atol=1e-12)
        wanted = np.zeros((6, 6))
        for at, stiffness in ((np.zeros(3), 2.0e5), (elbow, 1.0e5)):
            screw = np.concatenate([np.cross([0, 0, 1], tip - at), [0, 0, 1]])
            wanted += np.outer(screw, screw) / stiffness
        wanted[2, 2] += 1 / 4.0e6
        compliance = robot.compliance(posture)
        np.testing.assert_allclose(compliance.array, wanted, atol=1e-18)
        np.testing.assert_allclose(compliance.point, tip, atol=1e-12)
        np.testing.assert_array_equal(compliance.axes, np.eye(3))
        self.assertIsNone(robot.stiffness(posture))  # rigid against turns about x
        small = robot.deflect([0, 1e-3, 0], posture)
        np.testing.assert_allclose(small.displacement, wanted[:, 1] * 1e-3, rtol=1e-6, atol=1e-16)
        self.assertTrue(small.stable)

    def test_a_matrix_in_another_frame_gives_the_same_work(self):
        robot = ks.Robot.read(source("data/robots/six_axis.yaml"))
        stiffness = robot.stiffness(robot.posture(joints={"q2": 0.3}))
        turn = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1.0]])
        point = stiffness.point + [0.1, -0.2, 0.3]
        moved = stiffness.at(point, turn)
        twist = np.array([1, 2, 3, 0.1, 0.2, 0.3])
        there = np.concatenate([turn.T @ (twist[:3] + np.cross(twist[3:], point - stiffness.point)), turn.T @ twist[3:]])
        self.assertAlmostEqual(there @ moved.array @ there / (twist @ np.asarray(stiffness) @ twist), 1, places=12)
        np.testing.assert_allclose(np.asarray(stiffness) @ stiffness.inverse().array, np.eye(6), atol=1e-9)
        again = ks.Stiffness(moved.array, moved.point, moved.axes).at(stiffness.point, np.eye(3))
        np.testing.assert_allclose(again.array, stiffness.array, rtol=1e-9, atol=1e-3)
        self.assertEqual(np.asarray(stiffness, dtype=np.float32).dtype, np.float32)
        copy = stiffness.array
        copy[0, 0] = 0
        self.assertNotEqual(stiffness.array[0, 0], 0)

    def test_a_joint_outside_of_its_range_is_warned_of(self):
        robot = ks.Robot.parse(ARM.replace("stiffness: 2.0e5", "stiffness: 2.0e5, range: [-1, 1]"), self.path("ranged.yaml"))
        with self.assertWarnsRegex(UserWarning, "q1 stands at 90 rad, outside of its range -1 to 1 rad"):
            robot.posture(joints={"q1": 90.0})
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            robot.posture(joints={"q1": 0.9})
            robot.deflect([0, 1, 0])
            with self.assertRaises(UserWarning):
                robot.posture(joints={"q1": 1.1})

    def test_a_pose_is_reached(self):
        robot = ks.Robot.read(source("data/robots/orthoglide.yaml"))
        posture = robot.posture(at=[0.01, 0.02, -0.03])
        np.testing.assert_allclose(posture.position, [0.01, 0.02, -0.03], atol=1e-9)
        self.assertEqual(sorted(posture.joints), sorted(robot.joints))
        with self.assertRaises(ks.NoConvergence):
            robot.posture(at=[9, 9, 9])
        with self.assertRaises(ValueError):
            robot.posture(at=[1, 2])
        with self.assertRaisesRegex(ValueError, "nowhere"):
            robot.posture(joints={"nowhere": 1})

    def test_a_urdf_becomes_a_robot(self):
        robot = ks.Robot.from_urdf(source("data/urdf/six_axis.urdf"), 5e4, tip="flange")
        self.assertEqual(len(robot.joints), 6)
        twice = ks.Robot.from_urdf(source("data/urdf/six_axis.urdf"), [1e5] * 6, tip="flange")
        np.testing.assert_allclose(robot.compliance().array, 2 * twice.compliance().array, rtol=1e-9, atol=1e-18)
        written = robot.write(self.path("new.yaml"))
        np.testing.assert_array_equal(written.compliance().array, robot.compliance().array)
        by_name = {f"joint_{i + 1}": 5e4 for i in range(6)}
        named = ks.Robot.from_urdf(source("data/urdf/six_axis.urdf"), by_name, tip="flange")
        np.testing.assert_array_equal(named.compliance().array, robot.compliance().array)
        for wrong in (-1.0, [1e5] * 5, {"joint_1": 1e5}, by_name | {"joint_9": 1e5}, None):
            with self.assertRaises(ValueError):
                ks.Robot.from_urdf(source("data/urdf/six_axis.urdf"), wrong, tip="flange")

    def test_stiffnesses_have_units_where_they_are_texts(self):
        urdf = source("data/urdf/six_axis.urdf")
        plain = ks.Robot.from_urdf(urdf, 5e4, tip="flange").text
        for same in ("5e4 N m/rad", "50 kN m/rad", ["5e4 N m/rad"] * 5 + [5e4], {f"joint_{i + 1}": "5e4 N m" for i in range(6)}):
            self.assertEqual(ks.Robot.from_urdf(urdf, same, tip="flange").text, plain)
        with self.assertRaisesRegex(ks.ArgumentError, "joint_1.*N/m"):
            ks.Robot.from_urdf(urdf, "5e4 N/m", tip="flange")

    def test_a_posture_is_found_by_its_pose(self):
        robot = ks.Robot.read(source("data/robots/six_axis.yaml"))
        posture = robot.posture(joints={"q2": 0.2, "q3": -0.3, "q5": 0.4})
        np.testing.assert_allclose(robot.posture(at=posture.pose).pose, posture.pose, atol=1e-9)
        for wrong, why in ((2 * posture.pose, "last row"), (np.diag([1, 1, -1, 1]), "right-handed"), (np.eye(3), "3 x 3")):
            with self.assertRaisesRegex(ks.ArgumentError, why):
                robot.posture(at=wrong)

    def test_what_an_argument_cannot_be_is_an_error_of_the_package(self):
        robot = ks.Robot.read(source("data/robots/orthoglide.yaml"))
        for kind, call in ((ValueError, lambda: robot.posture(joints={"nowhere": 1})), (ValueError, lambda: robot.posture(at=[1])),
                           (ValueError, lambda: robot.deflect([1])), (ValueError, lambda: ks.Stiffness(np.full((6, 6), np.nan))),
                           (ValueError, lambda: ks.Stiffness(np.eye(6), axes=2 * np.eye(3))), (ValueError, lambda: ks.map_poses(robot, "x=")),
                           (ValueError, lambda: ks.map_poses(robot, "x=0", threads=-1)), (ValueError, lambda: ks.campaign_of({}, robot)),
                           (ValueError, lambda: ks.effect_kind(lambda q: q, parameters={})), (TypeError, lambda: ks.frame_of(robot)),
                           (TypeError, lambda: ks.campaign_of({"fz": 1, "dz": [1]}, robot))):
            with self.assertRaises(kind) as caught:
                call()
            self.assertIsInstance(caught.exception, ks.Error)

    def test_a_urdf_that_slides_and_turns_has_no_stiffness_of_one_number(self):
        pathlib.Path(self.path("crane.urdf")).write_text(
            '<robot name="crane"><link name="base"/><link name="jib"/><link name="trolley"/>'
            '<joint name="swing" type="continuous"><parent link="base"/><child link="jib"/><axis xyz="0 0 1"/></joint>'
            '<joint name="run" type="prismatic"><parent link="jib"/><child link="trolley"/><axis xyz="1 0 0"/>'
            '<limit lower="0" upper="1" effort="9" velocity="1"/></joint>'
            '<gazebo reference="swing"><springStiffness>12345</springStiffness></gazebo></robot>')
        with self.assertRaisesRegex(ValueError, "dict by name"):
            ks.Robot.from_urdf(self.path("crane.urdf"), 5e4)
        robot = ks.Robot.from_urdf(self.path("crane.urdf"), {"run": 2e6})  # the other is in the file
        self.assertIn("12345", robot.text)

    def test_a_robot_can_be_sent_to_another_process(self):
        robot = ks.Robot.read(source("data/robots/orthoglide.yaml"))
        for copy_of in (lambda r: pickle.loads(pickle.dumps(r)), copy.deepcopy):
            other = copy_of(robot)
            self.assertEqual((other.name, other.file, other.text), (robot.name, robot.file, robot.text))
            np.testing.assert_array_equal(other.compliance().array, robot.compliance().array)

    def test_matrices_and_postures_can_be_sent_to_another_process(self):
        for name in ("six_axis", "orthoglide", "delta"):
            robot = ks.Robot.read(source(f"data/robots/{name}.yaml"))
            posture = robot.posture()
            for copy_of in (lambda r: pickle.loads(pickle.dumps(r)), copy.deepcopy):
                other = copy_of(posture)
                np.testing.assert_array_equal(other.pose, posture.pose)
                self.assertEqual(other.joints, posture.joints)
                for matrix in (robot.compliance(posture), robot.compliance(posture).at([0.1, 0.2, 0.3])):
                    same = copy_of(matrix)
                    np.testing.assert_array_equal(same.array, matrix.array)
                    np.testing.assert_array_equal((same.point, *same.axes), (matrix.point, *matrix.axes))
                np.testing.assert_array_equal(robot.compliance(other).array, robot.compliance(posture).array)

    def test_a_robot_that_cannot_be_read_elsewhere_is_not_written_there(self):
        robot = ks.Robot.read(source("data/robots/orthoglide_fea.yaml"))  # names link files beside it
        there = self.path("elsewhere.yaml")
        with self.assertRaises(ks.InputError):
            robot.write(there)
        self.assertFalse(there.exists())
        there.write_text("what was there")
        with self.assertRaises(ks.InputError):
            robot.write(there)
        self.assertEqual(there.read_text(), "what was there")

    def test_a_link_has_the_numbers_of_its_file(self):
        file = source("data/links/foot.link.json")
        link, content = ks.Link.read(file), json.loads(pathlib.Path(file).read_text())
        np.testing.assert_array_equal(link.compliance.array, np.reshape(content["compliance"], (6, 6)))
        np.testing.assert_array_equal(link.compliance.point, content["point"])
        with self.assertRaises(ks.InputError):
            ks.Link.read(source("data/robots/bench.yaml"))

    def test_a_map_is_that_of_the_program(self):
        grid, indices = "x=-60:60:3,y=-60:60:3,z=0", ["weakest-translation", "stiffness=1,1,1"]
        robot = ks.Robot.read(source("data/robots/orthoglide.yaml"))
        found = ks.map_poses(robot, grid, indices)
        run(["map", robot.file, "--grid", grid, *(word for index in indices for word in ("--index", index)), "-o", self.path("map.csv"),
             "--json", self.path("map.json"), "-q"])
        self.assertEqual(self.path("map.csv").read_bytes(), found.to_csv().encode())
        by_program = json.loads(self.path("map.json").read_bytes())
        self.assertEqual(found.result, json.loads(found.to_json()))
        self.assertEqual(found.result, {key: by_program[key] for key in found.result})
        frame = ks.frame_of(found)
        self.assertEqual((len(found), len(frame), found.shape[:3]), (9, 9, [3, 3, 1]))
        middle = frame[(frame.x == 0) & (frame.y == 0)].iloc[0]
        along = np.ones(3) / np.sqrt(3)
        compliance = robot.compliance(robot.posture(at=[0, 0, 0])).array[:3, :3]
        self.assertAlmostEqual(middle["stiffness=1 1 1"] * (along @ compliance @ along), 1, places=9)
        self.assertAlmostEqual(middle["weakest-translation"] * np.linalg.eigvalsh(compliance).max(), 1, places=9)
        loaded = ks.map_poses(robot, grid, indices, wrench="100 N,0 N,-20 N,0 N m,3 N m,0 N m")
        self.assertEqual(ks.map_poses(robot, grid, indices, wrench=[100, 0, -20, 0, 3, 0]).to_csv(), loaded.to_csv())
        with self.assertRaisesRegex(ValueError, "a wrench is"):
            ks.map_poses(robot, grid, wrench=[1, 2])
        with self.assertRaisesRegex(ValueError, "no index"):
            ks.map_poses(robot, grid, ["wekest"])
        with self.assertWarnsRegex(UserWarning, "flat.csv has no column z: it is 0 in every pose"):
            ks.map_poses(robot, path=str(self.path("flat.csv", "x,y\n0,10\n")))

    def test_many_matrices_are_those_of_each_pose(self):
        robot = ks.Robot.read(source("data/robots/orthoglide.yaml"))
        poses = np.array([[x, y, 0.01] for x in np.linspace(-0.05, 0.05, 9) for y in (-0.04, 0, 0.03)] + [[9, 9, 9]])
        relaxed = ks.stiffness_matrices(robot, poses)
        wrenches = np.outer(np.linspace(0, 200, len(poses)), [1, -0.5, 0.3, 0.01, 0, 0.02])
        loaded = ks.stiffness_matrices(robot, poses, wrenches, threads=2)
        self.assertEqual((relaxed.shape, loaded.shape), ((28, 6, 6), (28, 6, 6)))
        self.assertTrue(np.isnan(relaxed[-1]).all() and np.isnan(loaded[-1]).all())
        for i, pose in enumerate(poses[:-1]):
            posture = robot.posture(at=pose)
            np.testing.assert_allclose(relaxed[i], robot.stiffness(posture).array, rtol=1e-9, atol=1e-3)
            found = robot.deflect(wrenches[i], posture)
            if not np.isnan(loaded[i]).all():
                np.testing.assert_allclose(loaded[i], found.stiffness.array, rtol=1e-8, atol=1e-2)
            self.assertEqual(np.isnan(loaded[i]).all(), not found.stable)
        np.testing.assert_array_equal(ks.stiffness_matrices(robot, [0.01, 0.02, 0.0]), ks.stiffness_matrices(robot, [[0.01, 0.02, 0, 0, 0, 0]]))
        same = ks.stiffness_matrices(robot, poses[:3], [10, 20, 30])
        np.testing.assert_array_equal(same[2], ks.stiffness_matrices(robot, poses[2:3], [[10, 20, 30, 0, 0, 0]])[0])
        self.assertEqual(ks.stiffness_matrices(robot, np.empty((0, 3))).shape, (0, 6, 6))
        with self.assertRaisesRegex(ValueError, "rows x, y, z"):
            ks.stiffness_matrices(robot, [[1, 2]])
        with self.assertRaisesRegex(ValueError, "a row for each"):
            ks.stiffness_matrices(robot, poses, wrenches[:5])

    def test_what_is_no_number_is_refused(self):
        robot = ks.Robot.read(source("data/robots/six_axis.yaml"))
        home = robot.posture()
        nan = float("nan")
        for wrong in (lambda: robot.deflect([nan, 0, 0], home), lambda: robot.deflect([0, 0, float("inf")], home),
                      lambda: robot.deflect([1, 0, 0], home, point=[0, nan, 0]), lambda: robot.posture(at=[nan, 0, 0]),
                      lambda: robot.posture(joints={robot.joints[0]: nan}), lambda: robot.posture(joints={robot.joints[0]: 1e300}),
                      lambda: ks.stiffness_matrices(robot, [[nan, 0, 0]]),
                      lambda: ks.stiffness_matrices(robot, [[0.9, 0, 0.9]], [nan, 0, 0])):
            with self.assertRaisesRegex(ValueError, "no number|no place of a joint"):
                wrong()

    def test_a_posture_of_another_robot_is_refused(self):
        names = ("six_axis", "orthoglide", "seven_axis", "gantry")
        robots = [ks.Robot.read(source(f"data/robots/{name}.yaml")) for name in names]
        for robot in robots:
            for other in robots:
                if other is robot:
                    continue
                for use in (robot.stiffness, robot.compliance, lambda posture, r=robot: r.deflect([1, 0, 0], posture)):
                    with self.assertRaisesRegex(ValueError, "another robot"):
                        use(other.posture())

    def test_axes_are_a_rotation(self):
        matrix = ks.Stiffness(np.eye(6))
        for axes in (2 * np.eye(3), np.ones((3, 3)), np.diag([1, 1, -1]), np.full((3, 3), np.nan)):
            with self.assertRaisesRegex(ValueError, "right-handed"):
                matrix.at([0, 0, 0], axes)
            with self.assertRaisesRegex(ValueError, "right-handed"):
                ks.Compliance(np.eye(6), axes=axes)
        with self.assertRaisesRegex(ValueError, "no number"):
            ks.Stiffness(np.full((6, 6), np.nan))

    def test_a_mistake_has_its_place_and_cure(self):
        path = self.path("wrong.yaml", ARM.replace("stiffness: 1.0e5", "stiffness: -1"))
        with self.assertRaises(ks.InputError) as caught:
            ks.Robot.read(path)
        error = caught.exception
        self.assertIsInstance(error, ks.Error)
        self.assertIsInstance(error, ValueError)
        self.assertEqual((error.file, error.line), (str(path), ARM[:ARM.index("name: q2")].count("\n") + 1))
        self.assertIn("stiffness", error.key)
        self.assertTrue(error.cure)
        self.assertIn(f"{path}:{error.line}", str(error))

    def test_a_call_costs_little(self):
        """What Python adds to a computation: that of a matrix without it is less than a microsecond."""
        robot = ks.Robot.read(source("data/robots/six_axis.yaml"))
        posture = robot.posture()
        for call in (lambda: robot.name, lambda: posture.position, lambda: robot.stiffness(posture), robot.posture):
            times = []
            for _ in range(2000):
                start = time.perf_counter()
                call()
                times.append(time.perf_counter() - start)
            self.assertLess(np.median(times), 20e-6)


class Readings(unittest.TestCase):
    def test_columns_are_the_table_in_si(self):
        campaign = ks.Campaign.read(source(PAPER_CAMPAIGN))
        rows = [line.split(",") for line in pathlib.Path(source("data/measurements/nist_load_cell/readings.csv")).read_text().split("\n")
                if line and not line.startswith("#")][1:]
        columns = campaign.columns()
        self.assertEqual(len(campaign), len(rows))
        np.testing.assert_allclose(columns["fz"], [float(row[2]) for row in rows])
        np.testing.assert_allclose(columns["dz"], [float(row[3]) * 1e-3 for row in rows])
        self.assertTrue(np.isnan(columns["dx"]).all())

    def test_readings_in_memory_are_compared_as_those_of_the_file(self):
        campaign = ks.Campaign.read(source(PAPER_CAMPAIGN))
        columns = campaign.columns()
        with tempfile.TemporaryDirectory() as folder:
            made = ks.campaign_of({name: columns[name] for name in ("id", "fz", "dz")} | {"replicate": [1 + i // 20 for i in range(40)]},
                                  source("data/robots/bench.yaml"), folder=folder, zero="estimate", wrench_point="reference")
            one, other = ks.compare(campaign), ks.compare(made)
            self.assertEqual(one.adequacy, other.adequacy)
            np.testing.assert_allclose(one.residuals, other.residuals, rtol=1e-6, atol=1e-15)
            with self.assertRaises(ValueError):
                ks.campaign_of({"fz": [1, 2], "dz": [1]}, source("data/robots/bench.yaml"), folder=folder)

    def test_a_robot_that_is_in_no_file_is_compared_and_diagnosed(self):
        text = pathlib.Path(source("data/robots/bench.yaml")).read_text()
        robot = ks.Robot.parse(text, "/nowhere/bench.yaml")
        readings = {"fz": [0.0, 100, 200, 300, -100, -200], "dz": [0.0, 1e-4, 2e-4, 3e-4, -1e-4, -2e-4]}
        campaign = ks.campaign_of(readings, robot, noise={"translation": 1e-6})
        for found in (ks.compare(campaign), ks.diagnose(campaign, ["friction"], draws=99)):
            self.assertEqual(found.result["inputs"]["robot"]["sha256"], hashlib.sha256(text.encode()).hexdigest())

    def test_frames_hold_readings_and_what_is_left_of_them(self):
        campaign = ks.Campaign.read(source(PAPER_CAMPAIGN))
        frame = ks.frame_of(campaign)
        self.assertEqual(len(frame), len(campaign))
        with tempfile.TemporaryDirectory() as folder:
            replicate = [1 + i // 20 for i in range(40)]
            made = ks.campaign_of(frame[["id", "fz", "dz"]].assign(replicate=replicate), source("data/robots/bench.yaml"), folder=folder,
                                  zero="estimate", wrench_point="reference")
            np.testing.assert_allclose(ks.frame_of(made)["dz"], frame["dz"], rtol=1e-12)
        comparison = ks.compare(campaign)
        left = ks.frame_of(comparison)
        np.testing.assert_array_equal(left["residual dz"], comparison.residuals[:, campaign.components.index("dz")])
        self.assertAlmostEqual(np.sqrt(np.nanmean(left["whitened dz"] ** 2)), comparison.error_over_noise, places=9)

    def test_a_frame_of_a_campaign_is_that_campaign(self):
        masked = {"mask": [False, True] + [False] * 10, "time": np.arange(12.0), "humidity": 40 + np.arange(12.0), "who": ["Ann", "Bob"] * 6,
                  "sigma_dz": [2e-6] * 12, "sigma_dx": [3e-6] * 12, "corr_dx_dz": [0.9] * 11 + [None]}
        robot = ks.Robot.read(source("data/robots/six_axis.yaml"))
        q = {name: np.repeat([0.1, 0.3, 0.5], 4) for name in robot.joints}
        loads = {"fz": np.tile([-100.0, 200, -300, 400], 3), "mx": np.linspace(0, 5, 12), "px": [0.1] * 12, "py": [0] * 12, "pz": [0.02] * 12}
        arm = ks.campaign_of(masked | q | loads | {"dx": 1e-7 * np.arange(12), "dz": 1e-8 * loads["fz"]}, robot)
        poses = ks.Campaign.read(source("data/measurements/orthoglide_clearance/campaign.yaml"))
        for campaign in (arm, poses, ks.Campaign.read(source(ARM_CAMPAIGN))):
            one, frame = ks.compare(campaign), ks.frame_of(campaign)
            again = ks.campaign_of(frame, campaign.robot)
            other = ks.compare(again)
            self.assertEqual((one.adequacy, again.warnings), (other.adequacy, campaign.warnings))
            np.testing.assert_allclose(other.residuals, one.residuals, rtol=1e-6, atol=1e-13)
            np.testing.assert_allclose(other.whitened, one.whitened, rtol=1e-6, atol=1e-6)
            self.assertEqual(list(ks.frame_of(again)), list(frame))
        frame = ks.frame_of(arm)
        np.testing.assert_array_equal(frame["q2"], q["q2"])
        np.testing.assert_array_equal(frame["humidity"], masked["humidity"])
        self.assertEqual((list(frame["used"]), list(frame["who"])), ([True, False] + [True] * 10, masked["who"]))
        self.assertEqual((frame["px"][3], frame["mx"][11]), (0.1, 5))
        self.assertLess(abs(ks.frame_of(poses)["x"][0] + 0.051814093), 1e-9)
        self.assertEqual(list(ks.frame_of(ks.campaign_of(frame.assign(used=frame["id"] != "3"), robot))["used"]),
                         [True, True, False] + [True] * 9)

    def test_what_is_used_is_said_by_booleans_or_their_numbers(self):
        bench, force = source("data/robots/bench.yaml"), np.array([0.0, 100, 200, 300])
        readings = {"fz": force, "dz": 1e-8 * force, "used": [True, False, True, True]}

        def used(**changed):
            return list(ks.campaign_of(readings | changed, bench, noise={"translation": 1e-6}).columns()["used"])
        for said in (readings["used"], [1, 0, 1, 1], [1.0, 0.0, 1.0, 1.0], ["True", "False", "True", "True"]):
            self.assertEqual(used(used=said), readings["used"])
        self.assertEqual(used(mask=[False, False, False, True]), [True, False, True, False])
        for unknown in (None, np.nan, "yes", 2):
            with self.assertRaisesRegex(ks.ArgumentError, "'used' has .* in row 3"):
                used(used=[True, True, True, unknown])

    def test_loads_that_are_in_no_column_are_warned_of(self):
        keys = {"noise": {"translation": 1e-6}, "weights": {"plate": {"on": "platform", "at": [0, 0, 0.1]}}}
        campaign = ks.campaign_of({"plate": [0.0, 5, 10], "dz": [0.0, 1e-6, 2e-6]}, source("data/robots/bench.yaml"), **keys)
        with self.assertWarnsRegex(UserWarning, "no column"):
            ks.frame_of(campaign)

    def test_frames_may_have_missing_values_and_a_named_index(self):
        import pandas
        readings = {"fz": [0.0, 100, 200, 300], "dz": [0.0, 1e-6, 2e-6, 3e-6], "session": ["a", "a", "b", "b"], "replicate": [1, 2, 1, 2]}
        noise = {"noise": {"translation": 1e-6}, "wrench_point": np.array([0.0, 0, 0.1])}
        bench = source("data/robots/bench.yaml")
        plain = ks.compare(ks.campaign_of(readings, bench, **noise))
        frame = pandas.DataFrame(readings | {"note": ["x", None, "y", None]}).convert_dtypes().set_index("session")
        frame["dx"] = pandas.array([pandas.NA, 1e-7, pandas.NA, 2e-7], dtype="Float64")
        made = ks.campaign_of(frame, bench, **noise)
        self.assertEqual(list(ks.frame_of(made)["session"]), readings["session"])
        np.testing.assert_array_equal(np.isnan(made.columns()["dx"]), [True, False, True, False])
        column = made.components.index("dz")
        np.testing.assert_allclose(ks.compare(made).residuals[:, column], plain.residuals[:, column], atol=1e-12)

    def test_whitened_residuals_make_the_error(self):
        comparison = ks.compare(ks.Campaign.read(source(ARM_CAMPAIGN)), threads=1)
        self.assertEqual(comparison.adequacy, "inadequate")
        whitened = comparison.whitened[np.isfinite(comparison.whitened)]
        self.assertAlmostEqual(comparison.error_over_noise, np.sqrt(np.mean(whitened ** 2)), places=9)
        self.assertEqual(comparison.result["headline"], comparison.headline)
        self.assertIn(comparison.headline, repr(comparison))

    def test_diagnosis_adoption_and_plan_are_those_of_the_program(self):
        campaign = ks.Campaign.read(source(ARM_CAMPAIGN))
        heard = []
        diagnosis = ks.diagnose(campaign, progress=lambda phase, done: heard.append((phase, done, threading.current_thread())))
        self.assertTrue(heard and all(0 <= done <= 1 and thread is threading.main_thread() for _, done, thread in heard))
        self.assertEqual(diagnosis.verdict, "identified")
        with tempfile.TemporaryDirectory() as folder:
            file, robot = os.path.join(folder, "diagnosis.json"), os.path.join(folder, "robot.yaml")
            run(["diagnose", source(ARM_CAMPAIGN), "-o", file, "-q"])
            self.assertEqual(pathlib.Path(file).read_bytes(), diagnosis.to_json().encode())
            self.assertEqual([one["effect"] for one in diagnosis.found], [one["effect"] for one in diagnosis.result["found"]])
            diagnosis.write(file)
            run(["adopt", campaign.robot.file, file, "-o", robot])
            adoption = ks.adopt(diagnosis)
            self.assertEqual(pathlib.Path(robot).read_text(), adoption.text)
            better = ks.compare(ks.Campaign.read(source(ARM_CAMPAIGN), robot=adoption.robot))
            self.assertLess(better.error_over_noise, 1.1)
            with self.assertRaisesRegex(ValueError, "friction"):
                ks.adopt(diagnosis, "friction")
            table = os.path.join(folder, "next.csv")
            run(["plan", source(ARM_CAMPAIGN), "--diagnosis", file, "-o", table, "-q"])
            plan = ks.plan(campaign, diagnosis)
            self.assertEqual(pathlib.Path(table).read_text(), plan.table)

    def test_others_run_meanwhile(self):
        campaign, counted, stop = ks.Campaign.read(source(ARM_CAMPAIGN)), [0], threading.Event()

        def count():
            while not stop.is_set():
                counted[0] += 1
                time.sleep(0.001)
        counter = threading.Thread(target=count)
        counter.start()
        start, before = time.monotonic(), counted[0]
        ks.compare(campaign, threads=1)
        taken, during = time.monotonic() - start, counted[0] - before
        stop.set()
        counter.join()
        self.assertGreater(during, 5)
        self.assertGreater(taken, 0.01)

    def test_ctrl_c_stops_a_diagnosis_within_a_second_and_loses_nothing(self):
        code = (f"import kinetostat as ks; c = ks.Campaign.read({source(ARM_CAMPAIGN)!r})\n"
                "try: ks.diagnose(c, threads=1, progress=lambda phase, done: print(phase, flush=True))\n"
                "except KeyboardInterrupt: print('stopped', flush=True)")
        with tempfile.TemporaryDirectory() as cache:
            child = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True, env={**os.environ, "XDG_CACHE_HOME": cache})

            def kept():
                return sum(file.is_file() for file in pathlib.Path(cache).rglob("*"))
            while kept() < 5 and child.poll() is None:
                self.assertTrue(child.stdout.readline())
            start = time.monotonic()
            child.send_signal(signal.SIGINT)
            rest, _ = child.communicate(timeout=60)
            self.assertLess(time.monotonic() - start, 1)
            self.assertTrue(rest.endswith("stopped\n"), rest)
            self.assertEqual(child.returncode, 0)
            done, whole = kept(), code.replace("print(phase, flush=True)", "None") + "\nelse: print('done')"
            self.assertGreaterEqual(done, 5)
            before = {file: file.stat().st_ino for file in pathlib.Path(cache).rglob("*") if file.is_file()}
            again = subprocess.run([sys.executable, "-c", whole], stdout=subprocess.PIPE, text=True, env={**os.environ, "XDG_CACHE_HOME": cache})
            self.assertEqual(again.stdout, "done\n")
            self.assertEqual({file: file.stat().st_ino for file in before}, before)  # none was computed and kept anew
            self.assertGreater(kept(), done)

    def test_an_exception_of_progress_stops_and_comes_out(self):
        class Enough(Exception):
            pass

        def progress(phase, done):
            raise Enough(phase)
        with self.assertRaises(Enough):
            ks.diagnose(ks.Campaign.read(source(ARM_CAMPAIGN)), progress=progress)

    def test_none_is_no_campaign_and_no_kind_of_effect(self):
        file = source("data/robots/bench.yaml")
        for call in (ks.compare, ks.diagnose, ks.plan, ks.adopt, lambda none: ks.map_poses(none, "x=0"),
                     lambda none: ks.stiffness_matrices(none, [[0, 0, 0]]), lambda none: ks.Robot.read(file, kinds=[none]),
                     lambda none: ks.Robot.parse("", file, kinds=[none])):
            with self.assertRaises(TypeError):
                call(None)

    def test_a_diagnosis_names_one_effect_or_more(self):
        campaign = ks.Campaign.read(source(ARM_CAMPAIGN))
        for wrong in (0, 11):
            with self.assertRaisesRegex(ValueError, "most_effects"):
                ks.diagnose(campaign, most_effects=wrong)

    def test_a_campaign_can_be_sent_to_another_process(self):
        campaign = ks.Campaign.read(source(ARM_CAMPAIGN))
        for other in (pickle.loads(pickle.dumps(campaign)), copy.deepcopy(campaign)):
            self.assertEqual((other.name, other.robot.text, len(other)), (campaign.name, campaign.robot.text, len(campaign)))
            np.testing.assert_array_equal(other.columns()["dz"], campaign.columns()["dz"])

    def test_an_unknown_effect_is_refused(self):
        with self.assertRaisesRegex(ValueError, "clearance"):
            ks.diagnose(ks.Campaign.read(source(ARM_CAMPAIGN)), ["clearence"])


class Stubs(unittest.TestCase):
    """The stubs name what the module has, and no more, with the same arguments."""

    def stubs(self):
        return ast.parse(pathlib.Path(_core.__file__).with_name("_core.pyi").read_text()).body

    def arguments(self, function, value):
        written = [a.arg for a in function.args.posonlyargs + function.args.args + function.args.kwonlyargs]
        signature = value.__doc__.split(") ->")[0].partition("(")[2]
        try:
            tree = ast.parse(f"def f({strip_types(signature)}): pass").body[0]
        except SyntaxError as error:
            raise AssertionError(signature) from error
        return written, [a.arg for a in tree.args.args + tree.args.kwonlyargs]

    def check_function(self, function, value):
        written, there = self.arguments(function, value)
        self.assertEqual(written, there, function.name)

    def test_they_agree_with_the_module(self):
        classes = {node.name: node for node in self.stubs() if isinstance(node, ast.ClassDef)}
        functions = {node.name: node for node in self.stubs() if isinstance(node, ast.FunctionDef)}
        there = {name: value for name, value in vars(_core).items() if not name.startswith("_")}
        self.assertEqual(set(classes) | set(functions), set(there))
        for name, node in functions.items():
            self.check_function(node, there[name])
        for name, node in classes.items():
            if issubclass(there[name], Exception):
                self.assertEqual({base.id for base in node.bases}, {base.__name__ for base in there[name].__bases__})
                continue
            members = {one.name: one for one in node.body}
            public = {key for key in vars(there[name]) if not key.startswith("_") or key in ("__array__", "__len__")}
            self.assertEqual({key for key in members if key != "__init__"}, public, name)
            for key, member in members.items():
                value = inspect.getattr_static(there[name], key)
                if isinstance(value, property):
                    self.assertIn("property", [d.id for d in member.decorator_list], key)
                else:
                    self.check_function(member, getattr(there[name], key))

    def test_all_that_is_public_is_exported(self):
        inner = {"FunctionKind", "law_variables", "usual_values"}
        python = {"__version__", "EffectKind", "campaign_of", "effect_kind", "frame_of", "with_effects"}
        self.assertEqual(set(ks.__all__), {name for name in vars(_core) if not name.startswith("_")} - inner | python)
        self.assertTrue(pathlib.Path(_core.__file__).with_name("py.typed").exists())


class Wheel(unittest.TestCase):
    def test_what_is_built_is_packed_and_works_elsewhere(self):
        """As `pip install .` does it, without compiling again."""
        sys.path.insert(0, source("python"))
        import backend
        ran = []
        backend._run, backend.PACKAGE = lambda *command: ran.append(command), pathlib.Path(_core.__file__).parent
        with tempfile.TemporaryDirectory() as folder:
            name = backend.build_wheel(folder)
            self.assertIn("KINETOSTAT_PYTHON=ON", ran[0])
            self.assertRegex(name, r"^kinetostat-\d+\.\d+\.\d+-cp3\d+-cp3\d+-linux_\w+\.whl$")
            archive = zipfile.ZipFile(os.path.join(folder, name))
            info = next(one for one in archive.namelist() if one.endswith("/RECORD"))
            rows = [row.split(",") for row in archive.read(info).decode().split()]
            self.assertEqual([row[0] for row in rows], archive.namelist())
            for file, digest, size in rows[:-1]:
                content = archive.read(file)
                made = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).decode().rstrip("=")
                self.assertEqual((digest, size), ("sha256=" + made, str(len(content))))
            archive.extractall(folder)
            helpers = [one for one in archive.namelist() if one.startswith("kinetostat/kinetostat-")]
            self.assertIn("kinetostat/kinetostat-tetgen", helpers)
            for helper in helpers:
                self.assertEqual(archive.getinfo(helper).external_attr >> 16, 0o100755)
                os.chmod(os.path.join(folder, helper), 0o755)  # as pip does, where extractall() does not
            code = "import kinetostat; print(kinetostat.__version__)"
            said = subprocess.run([sys.executable, "-c", code], cwd=folder, env={"PYTHONPATH": folder}, text=True, stdout=subprocess.PIPE)
            self.assertEqual(said.stdout, name.split("-")[1] + "\n")
            self.check_identifies(folder)
            self.assertIn(f"Version: {ks.__version__}", archive.read(info.replace("RECORD", "METADATA")).decode())


    def check_identifies(self, folder):
        """By the helper programs beside the library: the program is not on the path, nor installed."""
        joint = '<joint name="{}" type="continuous"><parent link="{}"/><child link="{}"/><origin xyz="{} 0 0"/><axis xyz="1 0 0"/></joint>'
        corners = [(x, y, z) for x in (0, 0.2) for y in (-0.02, 0.02) for z in (-0.02, 0.02)]
        faces = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
        mesh = "".join("v {} {} {}\n".format(*corner) for corner in corners)
        mesh += "".join("f {} {} {}\nf {} {} {}\n".format(*(1 + f[i] for i in (0, 1, 2, 0, 2, 3))) for f in faces)
        pathlib.Path(folder, "bar.obj").write_text(mesh)
        pathlib.Path(folder, "bar.urdf").write_text(
            '<robot name="bar"><link name="base"/><link name="hand"/><link name="bar"><visual><geometry><mesh filename="bar.obj"/></geometry>'
            "</visual></link>" + joint.format("one", "base", "bar", 0) + joint.format("two", "bar", "hand", 0.2) + "</robot>")
        code = """import kinetostat
robot = kinetostat.Robot.from_urdf("bar.urdf", 5e4, identify=True, material="steel", accuracy="20 %", out="bar.yaml")
print(robot.compliance().array[0, 0] > 0)"""
        said = subprocess.run([sys.executable, "-c", code], cwd=folder, env={"PYTHONPATH": folder}, text=True, capture_output=True)
        self.assertEqual(said.stdout, "True\n", said.stderr)


def strip_types(signature):
    """"a: int, *, b: Dict[str, float] = None" as "a, *, b"."""
    names, depth, part = [], 0, ""
    for c in signature + ",":
        depth += (c in "[(<{") - (c in "])>}")
        if c == "," and depth == 0:
            names.append(part.split(":")[0].split("=")[0].strip())
            part = ""
        else:
            part += c
    return ", ".join(name for name in names if name)


def run(arguments):
    done = subprocess.run([PROGRAM, *arguments], text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert done.returncode == 0, done.stderr


if __name__ == "__main__":
    PROGRAM, SOURCE = sys.argv[1:3]
    del sys.argv[1:3]
    unittest.main(verbosity=2)
