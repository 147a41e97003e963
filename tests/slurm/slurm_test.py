"""A study on Slurm against the same study on this machine: munged, slurmctld and slurmd on loopback, in a folder of
their own, as the user who calls; a task is killed and the daemon of the node is restarted midway.

usage: slurm_test.py ASLIO    (needs Debian's slurm-wlm and munge)
"""
import contextlib
import csv
import math
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

ASLIO = sys.argv.pop()
TASKS = 20
CONFIG = """\
ClusterName=aslio
SlurmctldHost={host}(127.0.0.1)
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CryptoType=crypto/munge
SlurmUser={user}
SlurmdUser={user}
SlurmctldPort={port}
SlurmdPort={node_port}
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
SlurmdSpoolDir={folder}/spool
StateSaveLocation={folder}/state
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
MpiDefault=none
SwitchType=switch/none
SchedulerType=sched/backfill
SchedulerParameters=sched_interval=1
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SlurmdParameters=config_overrides
ReturnToService=2
SlurmdTimeout=30
KillWait=1
MinJobAge=10
MailProg=/bin/true
NodeName={host} NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""
ROOM = """\
v -4 -3 -1.2\nv -4 -3 1.6\nv -4 3.5 -1.2\nv -4 3.5 1.6\nv 5 -3 -1.2\nv 5 -3 1.6\nv 5 3.5 -1.2\nv 5 3.5 1.6
f 1 3 4 2\nf 5 7 8 6\nf 1 2 6 5\nf 3 4 8 7\nf 1 3 7 5\nf 2 4 8 6
"""


def free_port():
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


def daemon(name):
    path = shutil.which(name, path=os.environ["PATH"] + ":/usr/sbin:/sbin")
    if path is None:
        raise AssertionError(f"{name} is not there: install slurm-wlm and munge")
    return path


class Cluster:
    """The three daemons. What is started here is ended here."""

    def __init__(self, folder):
        self.folder = folder
        self.processes = {}
        for name in ("spool", "state"):
            (folder / name).mkdir()
        host = socket.gethostname().split(".")[0]
        user = subprocess.run(["id", "-un"], capture_output=True, text=True, check=True).stdout.strip()
        (folder / "slurm.conf").write_text(CONFIG.format(host=host, folder=folder, user=user, port=free_port(),
                                                         node_port=free_port()))
        key = folder / "munge.key"
        key.write_bytes(os.urandom(128))
        key.chmod(0o600)
        self.environment = {**os.environ, "SLURM_CONF": str(folder / "slurm.conf")}
        self.start("munged", "--foreground", "--force", f"--socket={folder}/munge.socket", f"--key-file={key}",
                   f"--pid-file={folder}/munged.pid", f"--log-file={folder}/munged.log",
                   f"--seed-file={folder}/munged.seed", "--num-threads=2")
        self.wait_for(lambda: (folder / "munge.socket").exists(), "munged")
        self.start("slurmctld", "-D", "-i")
        self.start("slurmd", "-D", "-N", host)
        self.wait_for(lambda: "idle" in self.ask("sinfo", "-h", "-o", "%T"), "an idle node")

    def start(self, name, *arguments):
        with open(self.folder / f"{name}.out", "ab") as log:
            self.processes[name] = subprocess.Popen([daemon(name), *arguments], env=self.environment, stdout=log,
                                                    stderr=log, stdin=subprocess.DEVNULL)
        self.arguments = {**getattr(self, "arguments", {}), name: arguments}

    def kill(self, name):
        self.processes[name].kill()
        self.processes[name].wait()

    def restart(self, name):
        self.start(name, *self.arguments[name])

    def ask(self, *words):
        """What a command of Slurm prints; nothing when it does not answer in time."""
        try:
            return subprocess.run(words, env=self.environment, capture_output=True, text=True, timeout=30).stdout
        except subprocess.TimeoutExpired:
            return ""

    def logs(self):
        return "".join(f"== {p.name}\n{p.read_text(errors='replace')[-3000:]}" for p in
                       [*self.folder.glob("*.log"), *self.folder.glob("*.out"), *self.folder.parent.glob("*.txt")])

    def wait_for(self, condition, what, seconds=60):
        end = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > end:
                raise AssertionError(f"no {what} within {seconds} s\n{self.logs()}")
            time.sleep(0.1)

    def restart_both(self):
        """Killed, and started again. The node comes back when its tasks are older than BatchStartTimeout (10 s), so that the
        controller misses them when the node reports, and not at the next report, which may be minutes later."""
        self.kill("slurmctld")
        self.kill("slurmd")
        killed = time.monotonic()
        time.sleep(2)
        self.restart("slurmctld")
        self.wait_for(lambda: " is UP" in self.ask("scontrol", "ping"), "controller after its restart")
        time.sleep(max(0, killed + 12 - time.monotonic()))
        self.restart("slurmd")

    def leftovers(self):
        """What runs by this cluster's configuration: tasks, and the steps that wait for a controller without end."""
        mark = f"SLURM_CONF={self.folder}/slurm.conf".encode()
        for process in pathlib.Path("/proc").glob("[0-9]*"):
            try:
                if int(process.name) != os.getpid() and mark in (process / "environ").read_bytes().split(b"\0"):
                    yield int(process.name)
            except OSError:
                continue

    def stop(self):
        self.ask("scancel", "--full", f"--user={os.getuid()}")
        for name in ("slurmd", "slurmctld", "munged"):
            if name in self.processes:
                self.processes[name].send_signal(signal.SIGTERM)
                try:
                    self.processes[name].wait(20)
                except subprocess.TimeoutExpired:
                    self.kill(name)
        for process in self.leftovers():
            with contextlib.suppress(ProcessLookupError):
                os.kill(process, signal.SIGKILL)


def write_study(folder):
    (folder / "room.obj").write_text(ROOM)
    # Not on a line, on which no trajectory can be measured.
    walk = "".join(f"{0.05 * k} {0.2 * (1 - abs(1 - k / 30)):.4f} {0.1 * math.sin(k / 10):.4f} {0.05 * math.cos(k / 7):.4f} 0 0 0 1\n"
                   for k in range(61))
    (folder / "walk.tum").write_text(walk)
    (folder / "small.yaml").write_text("schema: aslio/scene/1\nworld: {type: mesh, file: room.obj}\nfollow: {file: walk.tum}\n")
    pipeline = pathlib.Path(__file__).resolve().parents[2] / "configs/pipelines/fixed_window.yaml"
    (folder / "study.yaml").write_text(
        "schema: aslio/study/1\nquestion: Which?\nprediction: This one.\nrule: The lower.\n"
        f"datasets: [{{scene: small.yaml, seeds: 1-{TASKS}, name: q}}]\nmethods:\n"
        f"  - {{name: slow, pipeline: {pipeline}}}\n"
        f"  - {{name: fast, pipeline: {pipeline}, set: {{window.period: 0.05}}}}\n"
        "baseline: slow\nmetrics: [ate_m]\n")


def tables(output):
    """Without what a clock or the kernel decides."""
    with open(output / "results.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        for measured in ("cpu_s_per_s", "peak_rss_mb"):
            row.pop(measured, None)
    return (output / "table.md").read_text(), (output / "statistics.csv").read_text(), rows


class Slurm(unittest.TestCase):
    maxDiff = 2000

    def test_same_tables(self):
        with tempfile.TemporaryDirectory(prefix="aslio_slurm_") as name:
            folder = pathlib.Path(name)
            write_study(folder)
            local = subprocess.run([ASLIO, "experiment", folder / "study.yaml", "--output", folder / "local", "--jobs", "2",
                                    "--quiet"], capture_output=True, text=True, timeout=900)
            self.assertEqual(local.returncode, 0, local.stderr)
            (folder / "cluster").mkdir()
            cluster = Cluster(folder / "cluster")
            try:
                self.on_the_cluster(folder, cluster)
            finally:
                cluster.stop()
            self.assertEqual(tables(folder / "slurm"), tables(folder / "local"))
            self.assertEqual(len(tables(folder / "slurm")[2]), 2 * TASKS)

    def on_the_cluster(self, folder, cluster):
        command = [ASLIO, "experiment", folder / "study.yaml", "--output", folder / "slurm", "--executor", "slurm",
                   "--poll", "0.5", "--throttle", "2"]
        begin = time.monotonic()
        with open(folder / "first.txt", "w") as log:
            first = subprocess.Popen(command, env=cluster.environment, stdout=log, stderr=log)
        finished = lambda: len(list((folder / "slurm/runs").glob("*/*/run_key.json")))
        running = lambda: cluster.ask("squeue", "-h", "-r", "-t", "running", "-o", "%F_%K").split()
        # A task is killed, one that has just begun ..
        begun = lambda: [task for task in running() if not list(
            (folder / f"slurm/runs/q_{int(task.split('_')[1]) + 1}").glob("*/run_key.json"))]
        cluster.wait_for(lambda: finished() >= 3 and begun(), "three finished runs and a task that begins", 600)
        cluster.ask("scancel", begun()[-1])
        # .. the caller goes away and comes back ..
        cluster.wait_for(lambda: finished() >= 8, "eight finished runs", 600)
        first.send_signal(signal.SIGINT)
        cluster.wait_for(lambda: first.poll() is not None, "end of the call that was interrupted", 60)
        self.assertEqual(first.returncode, 130, (folder / "first.txt").read_text())
        with open(folder / "second.txt", "w") as log:
            second = subprocess.Popen(command, env=cluster.environment, stdout=log, stderr=log)
        # .. and the daemons are killed midway, with what the node was doing.
        cluster.wait_for(lambda: finished() >= 12 and running(), "twelve finished runs", 600)
        cluster.restart_both()
        cluster.wait_for(lambda: second.poll() is not None, "end of the study", 1200)
        text = (folder / "second.txt").read_text()
        self.assertEqual(second.returncode, 0, text)
        print((folder / "first.txt").read_text() + text, f"{time.monotonic() - begin:.1f} s for {TASKS} tasks")
        self.assertIn("submitted again", (folder / "first.txt").read_text() + text)
        # A task that has ended may be completing for a moment.
        cluster.wait_for(lambda: cluster.ask("squeue", "-h") == "", "empty queue", 120)


if __name__ == "__main__":
    unittest.main(verbosity=2)
