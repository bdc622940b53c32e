"""The notebooks run from top to bottom, and come to the verdicts that they are about.

usage: notebooks_test.py PROGRAM SOURCE      with the package on PYTHONPATH"""
import os
import pathlib
import re
import sys
import tempfile
import unittest

import nbclient
import nbformat

PROGRAM = SOURCE = ""  # from the command line


def run(name):
    """The outputs of every cell, as text, in a folder that looks like the source folder."""
    with tempfile.TemporaryDirectory() as folder:
        for there in ("data", "meshes"):
            os.symlink(os.path.join(SOURCE, there), os.path.join(folder, there))
        os.environ["PATH"] = str(pathlib.Path(PROGRAM).parent) + ":/usr/bin:" + os.environ["PATH"]  # the Python of the package
        os.environ["IPYTHONDIR"] = os.environ["JUPYTER_RUNTIME_DIR"] = os.environ["MPLCONFIGDIR"] = folder
        book = nbformat.read(os.path.join(SOURCE, "docs/notebooks", name), as_version=4)
        nbclient.NotebookClient(book, timeout=600, resources={"metadata": {"path": folder}}).execute()
    return ["".join(output.get("text", "") or output.get("data", {}).get("text/plain", "") for output in cell.get("outputs", []))
            for cell in book.cells]


class Notebooks(unittest.TestCase):
    def test_none_is_kept_with_outputs(self):
        for file in pathlib.Path(SOURCE, "docs/notebooks").glob("*.ipynb"):
            book = nbformat.read(file, as_version=4)
            nbformat.validate(book)
            self.assertFalse(any(cell.get("outputs") or cell.get("execution_count") for cell in book.cells), file)

    def test_an_arm_that_bends_too_much_has_play_at_its_elbow(self):
        said = run("my-arm-bends-too-much.ipynb")
        found = next(text for text in said if text.startswith("Backlash"))
        self.assertIn("joint joint_3", found)
        gap, deviation = map(float, re.search(r"clearance \(([0-9.]+) \+- ([0-9.]+)\)e-05 rad", found).groups())
        self.assertLess(abs(gap - 10), 3 * deviation)  # what the notebook has hidden: 1e-4 rad
        self.assertRegex(said[-1], "^The model explains the readings")

    def test_one_link_has_three_models(self):
        said = run("one-link-three-models.ipynb")
        rows = {plane: [float(number) for number in numbers.split()] for plane, numbers in re.findall(r"(\w+ plane)(.*)", said[-2])}
        for plane, (book, one, four, many, finite) in rows.items():
            self.assertEqual(finite, 0, plane)
            self.assertLess(abs(many), 3, plane)  # the section varies slowly
            self.assertLess(abs(many), abs(four))
            self.assertLess(abs(four), abs(one))
        self.assertGreater(rows["softer plane"][0], 20)  # where it bends most it is thicker than in its middle


if __name__ == "__main__":
    PROGRAM, SOURCE = sys.argv[1:3]
    del sys.argv[1:3]
    unittest.main(verbosity=2)
