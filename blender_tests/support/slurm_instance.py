# SPDX-License-Identifier: GPL-3.0-or-later
"""A Slurm of its own for a test: munged, slurmctld and several slurmd on this machine, in one folder, on 127.0.0.1."""
from __future__ import annotations

import getpass
import os
import platform
import shutil
import signal
import socket
import subprocess
import time
from pathlib import Path

NEEDED = ("munged", "slurmctld", "slurmd", "sbatch", "scontrol")
CONFIGURATION = """
ClusterName=rumple_test
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={ports[0]}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={folder}/munge/socket,cred_expire=5
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool-%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/%n.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerType=sched/builtin
SchedulerParameters=sched_interval=1,sched_min_interval=0,default_queue_depth=2000
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
ReturnToService=2
SlurmdTimeout={timeout}
MessageTimeout={message}
KillWait=2
MinJobAge=3600
NodeName=n[1-{nodes}] NodeHostname={host} NodeAddr=127.0.0.1 Port=[{ports[1]}-{ports[2]}] CPUs=1 RealMemory=500
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


def missing() -> list[str]:
    """Programs that are not there."""
    return [name for name in NEEDED if shutil.which(name, path=_path()) is None]


def _path() -> str:
    return f"{os.environ['PATH']}:/usr/sbin:/sbin"


class Slurm:
    """Runs from start() to stop()."""

    def __init__(self, folder: Path, nodes: int, timeout: int = 6) -> None:
        """timeout: seconds after which a node that says nothing is dead."""
        self.timeout = timeout
        self.folder, self.nodes = folder, [f"n{number}" for number in range(1, nodes + 1)]
        self.environment = {**os.environ, "PATH": _path(), "SLURM_CONF": str(folder / "slurm.conf")}

    def start(self) -> None:
        folder = self.folder
        for name in ("munge", "state", *(f"spool-{node}" for node in self.nodes)):
            (folder / name).mkdir()
        (folder / "key").mkdir(mode=0o700)
        (folder / "key" / "key").write_bytes(os.urandom(1024))
        (folder / "key" / "key").chmod(0o600)
        first = _free_ports(len(self.nodes) + 1)
        (folder / "slurm.conf").write_text(CONFIGURATION.format(
            host=platform.node().split(".")[0], folder=folder, user=getpass.getuser(), nodes=len(self.nodes),
            timeout=self.timeout, message=max(5, self.timeout // 2),
            ports=(first, first + 1, first + len(self.nodes))))
        self.run("munged", "--force", f"--key-file={folder}/key/key", f"--socket={folder}/munge/socket",
                 f"--pid-file={folder}/munged.pid", f"--log-file={folder}/munged.log", f"--seed-file={folder}/seed",
                 "--num-threads=4")
        self.run("slurmctld")
        for node in self.nodes:
            self.run("slurmd", "-N", node)
        self.wait_for(lambda: self.run("sinfo", "-h", "-o", "%D", "-t", "idle").strip() == str(len(self.nodes)),
                      30.0 + len(self.nodes))

    def run(self, *command: str, check: bool = True, seconds: float = 60.0) -> str:
        """What a program of this Slurm says."""
        done = subprocess.run(command, env=self.environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              text=True, timeout=seconds)
        if check and done.returncode:
            raise AssertionError(f"{' '.join(command)}: {done.stdout}")
        return done.stdout

    @staticmethod
    def wait_for(happened: object, seconds: float) -> None:
        until = time.monotonic() + seconds
        while not happened():  # type: ignore[operator]
            if time.monotonic() > until:
                raise AssertionError(f"it did not happen within {seconds:g} s")
            time.sleep(0.05)

    def processes(self) -> dict[int, str]:
        """Those of this Slurm, and what it runs, with their nodes: of daemons empty."""
        found = {}
        for entry in Path("/proc").iterdir():
            if entry.name.isdigit():
                try:
                    environment = (entry / "environ").read_bytes().split(b"\0")
                except OSError:
                    continue
                if f"SLURM_CONF={self.folder / 'slurm.conf'}".encode() in environment:
                    node = [word[16:] for word in environment if word.startswith(b"SLURMD_NODENAME=")]
                    found[int(entry.name)] = node[0].decode() if node else ""
        return found

    def kill_node(self, node: str) -> None:
        """As where its power goes: first what could still tell of it."""
        daemon = int((self.folder / f"{node}.pid").read_text())
        of_node = [process for process, where in self.processes().items() if where == node]
        parents = {_parent(process) for process in of_node}
        for process in (daemon, *(parent for parent in parents if _name(parent) == "slurmstepd"), *of_node):
            _kill(process, signal.SIGKILL)

    def stop(self) -> None:
        """Nothing of it is left."""
        munged = self.folder / "munged.pid"
        pids = [int(munged.read_text())] if munged.exists() else []
        for process in (*self.processes(), *pids):
            if process != os.getpid():
                _kill(process, signal.SIGKILL)


def _parent(process: int) -> int:
    try:
        return int(Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()[1])
    except (OSError, IndexError):
        return 0


def _name(process: int) -> str:
    try:
        return Path(f"/proc/{process}/comm").read_text().strip()
    except OSError:
        return ""


def _kill(process: int, number: int) -> None:
    try:
        os.kill(process, number)
    except ProcessLookupError:
        pass


def _free_ports(count: int) -> int:
    """The first of so many that nobody listens on."""
    for first in range(26000 + os.getpid() % 4000, 32000, count):
        try:
            for port in range(first, first + count):
                with socket.socket() as tried:
                    tried.bind(("127.0.0.1", port))
            return first
        except OSError:
            continue
    raise AssertionError("there are no free ports")
