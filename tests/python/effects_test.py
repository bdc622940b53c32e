"""Laws of one's own in Python: against closed forms, against the same law as a formula, and named by diagnose.

usage: effects_test.py PROGRAM SOURCE      with the package on PYTHONPATH"""
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np

import kinetostat as ks

PROGRAM = SOURCE = ""  # from the command line

BENCH = """kinetostat: 1
name: bench
units: {length: m, force: N, angle: rad}
chain_types:
  cell:
    - actuator: {name: spring, axis: Tz, stiffness: 1.0e6}
manipulator: {chain: cell}
"""
PARAMETERS = {"a": {"unit": "N", "between": [0, 5000], "prior": 200}, "w": {"unit": "um", "between": [0.1, 1000], "prior": 50}}
EXACT = {"d": lambda d, a, w: a / w / np.cosh(d / w) ** 2, "a": lambda d, a, w: np.tanh(d / w),
         "w": lambda d, a, w: -a * d / w ** 2 / np.cosh(d / w) ** 2}


def drag(d, a, w):
    """a cable resists"""
    return a * np.tanh(d / w)


def by_series(d, a, w):
    """The same by its exponentials: no formula, for the loop ends by a number."""
    x, term, total = 2 * d / w, 1.0, 1.0
    for k in range(1, 400):
        term = term * x / k
        total = total + term
        if abs(complex(term)) < 1e-18 * abs(complex(total)):
            break
    return a * (total - 1) / (total + 1)


class Folder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def bench(self, more=""):
        (self.folder / "bench.yaml").write_text(BENCH + more)
        return ks.Robot.read(self.folder / "bench.yaml")

    def kinds(self):
        return {"formula": ks.effect_kind(drag, name="drag", parameters=PARAMETERS),
                "complex step": ks.effect_kind(by_series, name="drag", parameters=PARAMETERS),
                "called": ks.effect_kind(drag, name="drag", parameters=PARAMETERS, formula=False),
                "given": ks.effect_kind(drag, name="drag", parameters=PARAMETERS, derivatives=EXACT)}


class Laws(Folder):
    def test_each_way_has_the_deflection_of_the_closed_form(self):
        a, w, d = 300.0, 40e-6, 70e-6
        force = 1e6 * d + a * math.tanh(d / w)
        tangent = 1e6 + a / w / math.cosh(d / w) ** 2
        for way, kind in self.kinds().items():
            self.assertEqual(kind.formula is not None, way == "formula", way)
            robot = ks.with_effects(self.bench(), kind, effects=[{"effect": "drag", "at": "spring", "a": "300 N", "w": "40 um"}])
            found = robot.deflect([0, 0, force])
            self.assertAlmostEqual(found.displacement[2] / d, 1, places=9, msg=way)
            change = (robot.deflect([0, 0, force + 1e-2]).displacement[2] - robot.deflect([0, 0, force - 1e-2]).displacement[2]) / 2e-2
            self.assertAlmostEqual(change * tangent, 1, places=5, msg=way)

    def test_a_formula_is_written_into_the_robot_file(self):
        kind = self.kinds()["formula"]
        robot = ks.with_effects(self.bench(), kind, effects=[{"effect": "drag", "at": "spring", "a": "300 N", "w": "40 um"}])
        again = robot.write(self.folder / "changed.yaml")
        np.testing.assert_array_equal(again.deflect([0, 0, 100]).displacement, robot.deflect([0, 0, 100]).displacement)
        said = subprocess.run([PROGRAM, "effect", "show", "drag", str(self.folder / "changed.yaml")], text=True, stdout=subprocess.PIPE)
        self.assertIn("a cable resists", said.stdout)

    def test_operators_are_those_of_python(self):
        @ks.effect_kind(parameters={"a": {"unit": "N", "between": [0, 10], "prior": 2}})
        def mixed(d, T, a):
            return -a * (2 - d * 1e4) ** 2 / (3 + np.exp(-d)) + np.sqrt(1 + np.square(d)) - 1 / (1 + 2 ** d) + a - (+d)
        names = {name: getattr(np, name) for name in ("exp", "sqrt")}
        text = mixed.formula.replace("^", "**")
        for d, a in ((1e-5, 2.0), (-3e-4, 7.0)):
            self.assertAlmostEqual(eval(text, {**names, "d": d, "a": a, "T": 20}), mixed_by_hand(d, a), places=12)

    def test_effects_go_into_lists_of_every_style(self):
        kind = self.kinds()["formula"]
        drag_item = {"effect": "drag", "at": "spring", "a": "300 N", "w": "40 um"}
        wanted = ks.with_effects(self.bench(), kind, effects=[drag_item]).deflect([0, 0, 300]).displacement[2]
        hardening = "{effect: hardening, at: spring, k3: 0 N/m^3}"
        for more in (f"effects: [{hardening}]  # none\n", f"effects:\n  # a comment\n  - {hardening}\n", f"effects:\n- {hardening}\n",
                     "effects: []\n"):
            robot = ks.with_effects(self.bench(more), kind, effects=[drag_item])
            self.assertAlmostEqual(robot.deflect([0, 0, 300]).displacement[2] / wanted, 1, places=12, msg=more)
        with self.assertRaisesRegex(ValueError, "nothing can be added"):
            ks.with_effects(self.bench(f"effects: [{hardening},\n  {hardening}]\n"), kind, effects=[drag_item])

    def test_what_is_no_law_is_refused(self):
        def refused(function, words, **keys):
            with self.assertRaisesRegex(ValueError, words):
                ks.effect_kind(function, name="bad", parameters={"a": {"unit": "N/m", "between": [0, 10], "prior": 1}}, **keys)
        refused(lambda d, a: a * abs(d), "not smooth")
        refused(lambda d, a: a * math.sinh(d), "complex numbers")
        refused(lambda d, a: a * np.sin(d), "derivative by 'd'", derivatives={"d": lambda d, a: 2 * a})
        refused(lambda d, a: a * d, "takes no 'b'", derivatives={"b": lambda d, a: a})
        refused(lambda q, a: a * q, "'q' is no variable")
        refused(lambda d: d, "does not take its parameter 'a'")
        refused(lambda d, a: a * d, "none of 'force'", law="torque")
        def of_no_sort(function, words, **keys):
            with self.assertRaisesRegex(ks.ArgumentTypeError, words):
                ks.effect_kind(function, name="bad", parameters={"a": {"unit": "N/m", "between": [0, 10], "prior": 1}}, **keys)
        of_no_sort(lambda d, a: None, "function returns None")
        of_no_sort(lambda d, a: (a * d, 0.0), "function returns .*tuple")
        of_no_sort(lambda d, a: np.array([a * d, d]), "function returns .*ndarray")
        of_no_sort(lambda d, a: a * d, r"'d'\] does not take .*\(d, a\)", derivatives={"d": lambda d: 1.0})
        of_no_sort(lambda d, a: a * d, r"'d'\] returns None", derivatives={"d": lambda d, a: None})
        of_no_sort(lambda d, a: a * d, r"'d'\] is 5", derivatives={"d": 5})
        with self.assertRaisesRegex(ValueError, "catalogue has a 'friction'"):
            ks.effect_kind(drag, name="friction", parameters=PARAMETERS, formula=False)
        with self.assertRaises(ks.InputError) as caught:
            ks.with_effects(self.bench(), self.kinds()["formula"], effects=[{"effect": "drag", "at": "nowhere", "a": "1 N", "w": "1 um"}])
        self.assertGreater(caught.exception.line, 0)


    def test_no_two_laws_have_one_name(self):
        def other(d, a, w):
            return 2 * a * np.tanh(d / w)
        formula, called = (ks.effect_kind(other, name="drag", parameters=PARAMETERS, formula=way) for way in (True, False))
        kinds = self.kinds()
        for robot, added in ((self.bench(), (kinds["formula"], formula)), (self.bench(), (kinds["called"], called)),
                             (self.bench(), (kinds["formula"], called)), (ks.with_effects(self.bench(), kinds["called"]), (called,)),
                             (ks.with_effects(self.bench(), kinds["formula"]), (formula,))):
            with self.assertRaisesRegex(ValueError, "called 'drag'"):
                ks.with_effects(robot, *added)
        for kind in (kinds["formula"], kinds["called"]):  # the same again
            once = ks.with_effects(self.bench(), kind)
            self.assertEqual(ks.with_effects(once, kind).text, once.text)


def mixed_by_hand(d, a):
    return (-(a * (2 - d * 1e4) ** 2 / (3 + math.exp(-d))) + math.sqrt(1 + d * d) - 1 / (1 + 2 ** d) + a - d)


class Found(Folder):
    """A drag of 300 N over 200 um, hidden in readings that no code of kinetostat has made."""

    def readings(self, robot):
        random = np.random.default_rng(5)
        force = np.tile(np.linspace(-900, 900, 19), 3)
        deflection = np.zeros_like(force)
        for _ in range(200):  # k d + a tanh(d / w) = F, by Newton's method with short steps
            rest = 1e6 * deflection + 300 * np.tanh(deflection / 200e-6) - force
            deflection -= 0.5 * rest / (1e6 + 300 / 200e-6 / np.cosh(deflection / 200e-6) ** 2)
        table = {"fz": force, "dz": deflection + random.normal(0, 2e-6, len(force)), "replicate": [1 + i // 19 for i in range(57)]}
        return ks.campaign_of(table, robot, folder=self.folder / "campaign", noise={"translation": "2 um"})

    def test_diagnose_names_a_law_of_python_and_of_a_formula_alike(self):
        verdicts = {}
        for way in ("called", "formula"):
            robot = ks.with_effects(self.bench(), self.kinds()[way])
            if way == "formula":
                robot = robot.write(self.folder / "bench.yaml")
            diagnosis = ks.diagnose(self.readings(robot), ["drag", "hardening", "clearance"])
            self.assertEqual(diagnosis.verdict, "identified", (way, diagnosis.text))
            self.assertEqual(diagnosis.found[0]["effect"], "drag")
            values = dict(zip(("a", "w"), diagnosis.found[0]["values"]))
            verdicts[way] = values
            adopted = ks.adopt(diagnosis)
            better = ks.compare(self.readings(adopted.write(self.folder / "adopted.yaml")))
            self.assertEqual(better.adequacy, "adequate", way)
        for name in ("a", "w"):
            one, other = (verdicts[way][name] for way in verdicts)
            self.assertAlmostEqual(one / other, 1, places=4)

    def test_a_robot_that_is_in_no_file_is_not_adopted_into_one(self):
        robot = ks.with_effects(self.bench(), self.kinds()["formula"])
        with self.assertRaisesRegex(ValueError, "write"):
            ks.adopt(ks.diagnose(self.readings(robot), ["drag"]))

    def test_an_exception_of_a_law_comes_out(self):
        class Broken(Exception):
            pass
        fail = []

        def law(d, a, w):
            if fail:
                raise Broken("of the law")
            return a * np.tanh(d / w)
        campaign = self.readings(ks.with_effects(self.bench(), ks.effect_kind(law, name="drag", parameters=PARAMETERS, formula=False)))
        fail.append(True)
        with self.assertRaisesRegex(Broken, "of the law"):
            ks.diagnose(campaign, ["drag"])

    def test_a_law_that_is_no_number_somewhere_is_an_error(self):
        calls = []

        def law(d, a, w):
            calls.append(d)
            return a * np.tanh(d / w) * (np.nan if len(calls) > 200 else 1)
        robot = ks.with_effects(self.bench(), ks.effect_kind(law, name="drag", parameters=PARAMETERS, formula=False))
        with self.assertRaisesRegex(ks.ArgumentError, "the law 'drag' is nan"):
            ks.diagnose(self.readings(robot), ["drag"])


if __name__ == "__main__":
    PROGRAM, SOURCE = sys.argv[1:3]
    del sys.argv[1:3]
    os.environ.setdefault("MPLBACKEND", "Agg")
    unittest.main(verbosity=2)
