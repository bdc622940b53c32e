"""Commands in parts over a Dask cluster: the bytes of one process, whatever happens to workers.

usage: cluster_test.py PROGRAM SOURCE      with the package on PYTHONPATH"""
import os
import pathlib
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import unittest

from distributed import Client, LocalCluster

from kinetostat import Error, cluster

PROGRAM = SOURCE = ""  # from the command line
MAP = ["map", "data/robots/orthoglide.yaml", "--grid", "x=-60:60:25,y=-60:60:25,z=-20:20:5", "--index", "weakest-translation",
       "--index", "stiffness=1,1,1", "--index", "deflection", "--wrench", "30,10,-50"]
DRAWS = ["deflect", "data/robots/gantry.yaml", "--wrench", "0,300,0", "--draws", "40"]
DIAGNOSES = """kinetostat: 1
sweep: every campaign that is there
command: compare {campaign}
vary: [{word: campaign, files: data/measurements/*/campaign.yaml}]
results: {adequacy: adequacy, error: as_designed.error_over_noise}
"""


def one_process(words, option, file):
    done = subprocess.run([PROGRAM, *words, option, str(file), "-q"], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    assert done.returncode == 0, done.stderr
    return file.read_bytes()


class Parts(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        os.environ["KINETOSTAT"] = PROGRAM
        os.chdir(SOURCE)
        cls.workers = LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0")
        cls.client = Client(cls.workers, set_as_default=False)

    @classmethod
    def tearDownClass(cls):
        cls.client.close()
        cls.workers.close()

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def test_a_map_is_that_of_one_process_though_workers_are_killed(self):
        killed = []

        def kill_one(phase, done):
            if len(killed) < 2 and done >= 0.15 * (1 + len(killed)):
                workers = self.client.run(os.getpid)
                victim = sorted(workers.values())[0]
                killed.append(victim)
                os.kill(victim, signal.SIGKILL)
        cluster.run(MAP, self.folder / "parts.csv", scheduler=self.client, parts=24, progress=kill_one)
        self.assertEqual(len(killed), 2)
        self.assertEqual((self.folder / "parts.csv").read_bytes(), one_process(MAP, "-o", self.folder / "whole.csv"))

    def test_by_address_a_sweep_of_campaigns_is_that_of_one_process(self):
        file = self.folder / "sweep.yaml"
        file.write_text(DIAGNOSES)
        cluster.sweep(file, self.folder / "parts.csv", scheduler=self.workers.scheduler_address, parts=4)
        whole = one_process(["sweep", str(file)], "-o", self.folder / "whole.csv")
        self.assertEqual((self.folder / "parts.csv").read_bytes(), whole)
        self.assertGreater(whole.count(b"\n"), 10)

    def test_the_program_runs_a_sweep_on_workers(self):
        file = self.folder / "sweep.yaml"
        file.write_text(DIAGNOSES)
        whole = one_process(["sweep", str(file)], "-o", self.folder / "whole.csv")
        for scheduler in (self.workers.scheduler_address, "local"):
            parts = self.folder / "parts.csv"
            self.assertEqual(one_process(["sweep", str(file), "--scheduler", scheduler], "-o", parts), whole)
            self.assertEqual(sorted(p.name for p in self.folder.iterdir()), ["parts.csv", "sweep.yaml", "whole.csv"])

    def test_where_no_scheduler_answers_the_program_says_so_soon(self):
        file = self.folder / "sweep.yaml"
        file.write_text(DIAGNOSES)
        seconds = {}
        for address in ("tcp://127.0.0.1:1", "tcp://nobody.invalid:8786"):
            started = time.monotonic()
            done = subprocess.run([PROGRAM, "sweep", str(file), "--scheduler", address, "-o", str(self.folder / "x.csv")],
                                  stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
            seconds[address] = time.monotonic() - started
            self.assertEqual(done.returncode, 2)
            self.assertIn(f"no scheduler answers at {address}", done.stderr)
            self.assertEqual([p.name for p in self.folder.iterdir()], ["sweep.yaml"])
        self.assertLess(seconds["tcp://127.0.0.1:1"], 20)  # 5 s on a quiet machine; Dask by itself would wait 30

    def test_a_scheduler_that_is_just_started_is_waited_for(self):
        with socket.socket() as late:
            late.bind(("127.0.0.1", 0))  # its port refuses until it listens
            address = "tcp://{}:{}".format(*late.getsockname())
            threading.Timer(1, late.listen).start()
            started = time.monotonic()
            cluster._wait_for_listener(address)
            self.assertGreater(time.monotonic() - started, 0.5)

    def test_draws_are_those_of_one_process(self):
        cluster.run(DRAWS, self.folder / "parts.csv", scheduler=self.client, parts=3)
        self.assertEqual((self.folder / "parts.csv").read_bytes(), one_process(DRAWS, "--drawn", self.folder / "whole.csv"))

    def test_there_may_be_fewer_of_them_than_parts(self):
        draws = [*DRAWS[:-1], "3"]
        cluster.run(draws, self.folder / "few.csv", scheduler=self.client, parts=5)
        self.assertEqual((self.folder / "few.csv").read_bytes(), one_process(draws, "--drawn", self.folder / "whole_few.csv"))
        poses = ["map", "data/robots/orthoglide.yaml", "--grid", "x=-60:60:2,y=0,z=0", "--index", "weakest-translation"]
        cluster.run(poses, self.folder / "two.csv", scheduler=self.client)
        self.assertEqual((self.folder / "two.csv").read_bytes(), one_process(poses, "-o", self.folder / "whole_two.csv"))

    def test_what_the_program_refuses_comes_out(self):
        with self.assertRaisesRegex(cluster.CommandFailed, "no index") as caught:
            cluster.run([*MAP, "--index", "wekest"], self.folder / "x.csv", scheduler=self.client, parts=2)
        self.assertEqual(caught.exception.code, 2)
        self.assertIsInstance(caught.exception, Error)
        self.assertFalse((self.folder / "x.csv").exists())

    def test_the_entry_point_starts_a_cluster_of_its_own(self):
        words = ["map", "data/robots/orthoglide.yaml", "--grid", "x=-60:60:5,y=0,z=0", "--index", "weakest-translation"]
        done = subprocess.run([sys.executable, "-m", "kinetostat.cluster", "--workers", "2", "--parts", "3", "-o",
                               str(self.folder / "parts.csv"), *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual((self.folder / "parts.csv").read_bytes(), one_process(words, "-o", self.folder / "whole.csv"))
        wrong = subprocess.run([sys.executable, "-m", "kinetostat.cluster", "-o", "x.csv"], stderr=subprocess.PIPE, text=True)
        self.assertIn("there is no command", wrong.stderr)


if __name__ == "__main__":
    PROGRAM, SOURCE = sys.argv[1:3]
    del sys.argv[1:3]
    unittest.main(verbosity=2)
