"""Charts show the numbers of results, in the colours of the pages.

usage: plots_test.py PROGRAM SOURCE      with the package on PYTHONPATH"""
import os
import pathlib
import re
import sys
import unittest

import numpy as np

os.environ["MPLBACKEND"] = "Agg"
import kinetostat as ks
from kinetostat import plots

SOURCE = ""  # from the command line
ARM_CAMPAIGN = "data/measurements/arm_backlash_soft_base/campaign.yaml"


def source(name):
    return os.path.join(SOURCE, name)


def drawn(axes):
    """Nothing is missing that drawing needs."""
    axes.figure.canvas.draw()
    return axes


class Charts(unittest.TestCase):
    def test_colours_are_those_of_the_pages(self):
        light = pathlib.Path(source("report/page/page.css")).read_text().split("}")[0]
        page = dict(re.findall(r"--(\w+): (#[0-9a-f]{6})", light))
        self.assertEqual({name: page[name] for name in plots.COLOURS}, plots.COLOURS)

    def test_of_a_diagnosis(self):
        diagnosis = ks.diagnose(ks.Campaign.read(source(ARM_CAMPAIGN)))
        axes = drawn(plots.waterfall(diagnosis))
        heights = [bar.get_width() for bar in axes.patches]
        self.assertEqual(heights, [stage["whitened"] for stage in diagnosis.result["waterfall"]])
        self.assertGreater(heights[0], heights[-2])
        self.assertTrue(axes.get_yticklabels()[0].get_text().endswith("nominal"))
        axes = drawn(plots.load_deflection(diagnosis))
        curve = diagnosis.joint_curve()
        self.assertEqual(curve["joint"].split(".")[-1], diagnosis.found[0]["at"].split(".")[-1])
        lines = {line.get_label(): line for line in axes.get_lines()}
        np.testing.assert_array_equal(np.sort(lines["with the effect"].get_ydata()), np.sort(curve["load"]))
        off = {key: np.asarray(curve["measured"]) - np.asarray(curve[key]) for key in ("without", "with")}
        self.assertLess(np.sqrt(np.mean(off["with"] ** 2)), np.sqrt(np.mean(off["without"] ** 2)))

    def test_of_a_comparison(self):
        comparison = ks.compare(ks.Campaign.read(source(ARM_CAMPAIGN)))
        axes = drawn(plots.waterfall(comparison))
        self.assertAlmostEqual(min(bar.get_width() for bar in axes.patches), comparison.error_over_noise, places=9)

    def test_of_a_map(self):
        robot = ks.Robot.read(source("data/robots/orthoglide.yaml"))
        found = ks.map_poses(robot, "x=-50:50:3,y=-50:50:3,z=0")
        points = drawn(plots.stiffness_map(found)).collections[-1]
        np.testing.assert_array_equal(np.asarray(points.get_array()), found.columns()["weakest-translation"])
        line = drawn(plots.stiffness_map(ks.map_poses(robot, "x=-50:50:5,y=0,z=0"))).get_lines()[0]
        np.testing.assert_allclose(line.get_xdata(), np.linspace(-0.05, 0.05, 5), atol=1e-12)

    def test_of_a_matrix(self):
        compliance = ks.Robot.read(source("data/robots/orthoglide.yaml")).compliance()
        axes = drawn(plots.ellipsoid(compliance, force=100))
        ends = [np.array(line.get_data_3d()) for line in axes.get_lines()]
        sizes = [np.linalg.norm(end[:, 1] - end[:, 0]) / 2 for end in ends]
        np.testing.assert_allclose(sizes, 100 * np.linalg.eigvalsh(compliance.array[:3, :3]), rtol=1e-9)
        inverse = drawn(plots.ellipsoid(compliance.inverse(), force=100))  # a stiffness: of what it yields
        ends = [np.array(line.get_data_3d()) for line in inverse.get_lines()]
        np.testing.assert_allclose([np.linalg.norm(end[:, 1] - end[:, 0]) / 2 for end in ends], sizes, rtol=1e-6)

    def test_of_what_is_none_of_these(self):
        robot = ks.Robot.read(source("data/robots/orthoglide.yaml"))
        for chart in (plots.waterfall, plots.stiffness_map, plots.ellipsoid, plots.load_deflection):
            for other in (None, robot):
                with self.assertRaisesRegex(ks.ArgumentTypeError, "this chart is of a .*, not of"):
                    chart(other)
        with self.assertRaisesRegex(ks.ArgumentError, "no index 'nope': it has 'weakest-translation'"):
            plots.stiffness_map(ks.map_poses(robot, "x=0,y=0,z=0"), index="nope")


if __name__ == "__main__":
    SOURCE = sys.argv[2]
    del sys.argv[1:3]
    unittest.main(verbosity=2)
