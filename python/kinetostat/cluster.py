"""Long commands of kinetostat over the workers of a Dask cluster, in parts: `sweep`, `map`, and draws of `deflect` and `stiffness`.

    python3 -m kinetostat.cluster --scheduler tcp://host:8786 -o map.csv map robot.yaml --grid ... --index ...

A part is a run of the program `kinetostat` on a worker, with --part i/n; the table that is joined has the bytes of one run of all.
A worker that dies costs the parts that it was at: they run elsewhere. All of them see the files under the same names, in the folder
of the caller."""

import argparse
import os
import pathlib
import shutil
import socket
import subprocess
import sys
import tempfile
import time
from typing import Any, Callable, List, Optional, Sequence, Union

from ._core import Error

__all__ = ["program", "run", "sweep"]

#: How often parts may lose their workers, more often than the scheduler itself allows, before one counts as the cause.
MOST_LOSSES = 20

#: How long the address of a scheduler may be refused before there is none [s]: one that was just started does not listen yet.
REFUSED = 3.0

#: Of a cluster on this machine: Dask is imported once for all workers, which look at themselves seldom, as they only wait for the
#: program.
OWN_CLUSTER = {"distributed.worker.multiprocessing-method": "forkserver", "distributed.worker.profile.interval": "1s",
               "distributed.worker.profile.cycle": "10s", "distributed.admin.tick.interval": "500ms"}


def program() -> str:
    """The program kinetostat: $KINETOSTAT, the one that was built with this package, or that of the path."""
    built = pathlib.Path(__file__).resolve().parents[2] / "kinetostat"
    found = os.environ.get("KINETOSTAT") or (str(built) if os.access(built, os.X_OK) and built.is_file() else shutil.which("kinetostat"))
    if not found:
        raise FileNotFoundError("the program kinetostat is not on the path: install it on every worker, or set KINETOSTAT to where it is")
    return found


class CommandFailed(Error, RuntimeError):
    """The program said no: its words, and its exit code."""

    def __init__(self, code: int, words: str) -> None:
        super().__init__(code, words)
        self.code, self.words = code, words

    def __str__(self) -> str:
        return f"exit code {self.code}: {self.words}"


def _call(words: Sequence[str], folder: str, file: str) -> bytes:
    """What a command writes into `file`."""
    one_thread = {"OPENBLAS_NUM_THREADS": "1", **os.environ}  # a second one would wait for work, awake, beside other parts
    done = subprocess.run([program(), *words, "--quiet"], cwd=folder, env=one_thread, stdout=subprocess.DEVNULL,
                          stderr=subprocess.PIPE)
    if done.returncode not in (0, 4, 5):  # 4, 5: done, without a full result
        raise CommandFailed(done.returncode, done.stderr.decode(errors="replace").strip())
    return pathlib.Path(file).read_bytes()


def _part(words: Sequence[str], option: str, part: str, folder: str) -> bytes:
    """On a worker: one part, as bytes, so that nothing but the inputs must be shared."""
    with tempfile.TemporaryDirectory(prefix="kinetostat-") as scratch:
        file = os.path.join(scratch, "part.csv")
        return _call([*words, "--part", part, option, file, "--threads", "1"], folder, file)


def _parts(client: Any, words: List[str], count: int, folder: str, scratch: str,
           progress: Optional[Callable[[str, float], object]]) -> List[str]:
    """The files of all parts, in `scratch`. A part whose workers died is given to others again."""
    from distributed import KilledWorker, as_completed
    draws = words[0] != "map" and "--draws" in words

    def submit(i: int) -> Any:
        return client.submit(_part, words, "--drawn" if draws else "-o", f"{i}/{count}", folder, pure=False)
    number = {submit(i): i for i in range(1, count + 1)}
    waiting = as_completed(list(number), loop=client.loop)
    files: List[str] = []
    losses = 0
    for future in waiting:
        i = number.pop(future)
        try:
            content = future.result()
        except KilledWorker:
            losses += 1
            if losses > MOST_LOSSES:
                raise
            again = submit(i)
            number[again] = i
            waiting.add(again)
            continue
        files.append(os.path.join(scratch, f"{i}.csv"))
        pathlib.Path(files[-1]).write_bytes(content)
        if progress is not None:
            progress("parts", len(files) / count)
    return sorted(files)


def _wait_for_listener(address: str) -> None:
    """Raises OSError where the address of a scheduler is unknown or refused: Dask itself tries again there for as long as it waits
    for a slow one (30 s). Of one that is slow or far away it returns, as Dask has the patience."""
    from distributed.comm.addressing import parse_address, parse_host_port
    protocol, place = parse_address(address)
    if protocol not in ("tcp", "tls"):
        return
    end = time.monotonic() + REFUSED
    while True:
        try:
            socket.create_connection(parse_host_port(place), timeout=REFUSED).close()
            return
        except (ConnectionRefusedError, socket.gaierror):
            if time.monotonic() > end:
                raise
            time.sleep(0.2)
        except OSError:
            return


def run(words: Sequence[str], out: Union[str, "os.PathLike[str]"], *, scheduler: Any = None, parts: int = 0, workers: int = 0,
        progress: Optional[Callable[[str, float], object]] = None) -> pathlib.Path:
    """Runs a command (its words, without `kinetostat`, --part and -o) in parts and writes the table that is joined to `out`.

    `scheduler`: the address of a Dask scheduler, or a distributed.Client; None: a cluster of its own on this machine, of `workers`
    processes (one a processor). `parts`: 8 for each worker unless given. Of draws (--draws), `out` is the table for --drawn.
    Throws CommandFailed with the words of the program, OSError where no scheduler answers."""
    import dask
    from distributed import Client, LocalCluster
    if isinstance(scheduler, str):
        _wait_for_listener(scheduler)
    with tempfile.TemporaryDirectory(prefix="kinetostat-") as scratch:
        own = None
        if scheduler is None:
            with dask.config.set(OWN_CLUSTER):
                own = LocalCluster(n_workers=workers or os.cpu_count(), threads_per_worker=1, dashboard_address=":0")
        client = scheduler if isinstance(scheduler, Client) else Client(own or scheduler, set_as_default=False)
        try:
            count = parts or 8 * max(1, len(client.scheduler_info()["workers"]))
            folder = os.getcwd()
            try:
                files = _parts(client, list(words), count, folder, scratch, progress)
            except CommandFailed as failed:
                if parts or "--part: there are only" not in failed.words:
                    raise
                files = _parts(client, list(words), 1, folder, scratch, progress)  # fewer poses than parts
            joined = os.path.join(scratch, "joined.csv")
            whole = pathlib.Path(files[0]).read_bytes() if len(files) == 1 else None
            table = whole or _call(["join", *files, "-o", joined], folder, joined)
        finally:
            if client is not scheduler:
                client.close()
            if own is not None:
                own.close()
    target = pathlib.Path(out)
    beside = target.with_name(target.name + ".new")
    beside.write_bytes(table)
    os.replace(beside, target)
    return target


def sweep(file: Union[str, "os.PathLike[str]"], out: Union[str, "os.PathLike[str]"], **keys: Any) -> pathlib.Path:
    """run() of a sweep file."""
    return run(["sweep", os.fspath(file)], out, **keys)


def main(arguments: Optional[Sequence[str]] = None) -> int:
    parser = argparse.ArgumentParser(prog="python3 -m kinetostat.cluster", description="A command of kinetostat in parts, by Dask.")
    parser.add_argument("--scheduler", help="address of the scheduler, tcp://host:8786; without it, a cluster on this machine")
    parser.add_argument("--parts", type=int, default=0, help="8 for each worker unless given")
    parser.add_argument("--workers", type=int, default=0, help="of the cluster on this machine; one a processor unless given")
    parser.add_argument("-o", "--out", required=True, help="the table that is joined")
    parser.add_argument("command", nargs=argparse.REMAINDER, help="sweep FILE, map ROBOT ..., deflect ROBOT ... --draws N")
    given = parser.parse_args(arguments)
    words = given.command[1:] if given.command[:1] == ["--"] else given.command
    if not words:
        parser.error("there is no command: write sweep FILE, or map ROBOT ...")
    try:
        run(words, given.out, scheduler=given.scheduler, parts=given.parts, workers=given.workers)
    except CommandFailed as failed:
        print(failed.words, file=sys.stderr)
        return failed.code
    print(f"Written to {given.out}.")
    return 0


if __name__ == "__main__":
    from kinetostat.cluster import main as by_reference  # workers import what they are given
    sys.exit(by_reference())
