"""A real SLURM of one node, with accounting, in a folder of its own and on free ports."""

import os
import secrets
import shutil
import socket
import subprocess
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

PACKAGES = "slurm-wlm slurmdbd munge mariadb-server"
PROGRAMS = ("slurmctld", "slurmd", "slurmdbd", "sbatch", "sacct", "munged", "mariadbd", "mariadb-install-db")
PATIENCE = 60.0  # s for one daemon to answer; each takes one or two
END = 10.0  # s for one daemon to end
DATABASE_CONF = """\
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
DbdHost=localhost
DbdPort={accounting}
SlurmUser=root
LogFile={folder}/slurmdbd.log
PidFile={folder}/slurmdbd.pid
StorageType=accounting_storage/mysql
StorageHost=127.0.0.1
StoragePort={database}
StorageUser=slurm
StoragePass={password}
StorageLoc=slurm
"""
CLUSTER_CONF = """\
ClusterName=one_node
SlurmctldHost=localhost
SlurmctldPort={controller}
SlurmdPort={node}
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
AccountingStorageType=accounting_storage/slurmdbd
AccountingStorageHost=localhost
AccountingStoragePort={accounting}
AccountingStoragePass={folder}/munge.socket
StateSaveLocation={folder}
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
MpiDefault=none
ReturnToService=2
SlurmdParameters=config_overrides
NodeName=node NodeAddr=127.0.0.1 NodeHostname={host} CPUs=2 RealMemory=8000
PartitionName=all Nodes=node Default=YES MaxTime=INFINITE
"""
PORTS = ("database", "accounting", "controller", "node")
ACCOUNT = "CREATE USER slurm@'127.0.0.1' IDENTIFIED BY '{password}';\nGRANT ALL ON slurm.* TO slurm@'127.0.0.1';\n"
FILES = {"slurmdbd.conf": DATABASE_CONF, "slurm.conf": CLUSTER_CONF, "account.sql": ACCOUNT}
DAEMONS = {  # under their plain names: those that Debian gives them beside (slurmd-wlm …) crash
    "munged": "munged --foreground --force --key-file={folder}/key --socket={folder}/munge.socket "
    "--pid-file={folder}/munged.pid --log-file={folder}/munged.log --seed-file={folder}/seed",
    "mariadbd": "mariadbd --no-defaults --user=root --datadir={folder}/db --socket={folder}/db.socket "
    "--pid-file={folder}/db.pid --port={database} --bind-address=127.0.0.1 --skip-name-resolve "
    "--init-file={folder}/account.sql",
    "slurmdbd": "env SLURM_CONF={folder}/slurmdbd.conf slurmdbd -D",
    "slurmctld": "slurmctld -D",
    "slurmd": "slurmd -D -N node",
}
ANSWERS = {  # commands that succeed, and print a word, once a daemon is at work
    "munged": ("munge --no-input --socket={folder}/munge.socket", "MUNGE"),
    "mariadbd": (
        "mariadb --no-defaults --host=127.0.0.1 --port={database} --user=slurm --password={password} --execute=status",
        "Uptime",
    ),
    "slurmdbd": ("sacctmgr --noheader list users", "root"),
    "slurmctld": ("sacctmgr --noheader list cluster", "one_node"),
    "slurmd": ("sinfo --noheader", "idle"),
}
PREPARE = "mariadb-install-db --no-defaults --datadir={folder}/db --user=root --skip-test-db"


def missing() -> str:
    """What to do before a SLURM can be started here; nothing where it can."""
    if os.geteuid() != 0:
        return "SLURM's daemons are started as root"
    absent = [program for program in PROGRAMS if shutil.which(program, path=_path()) is None]
    return f"no {', '.join(absent)}: apt-get install {PACKAGES}" if absent else ""


@contextmanager
def one_node_slurm(folder: Path) -> Iterator[dict[str, str]]:
    """Start the daemons; gives the environment in which SLURM's commands find them.

    Args:
        folder: an empty one that every user may enter.
    """
    values = dict(zip(PORTS, map(str, free_ports(len(PORTS))), strict=True))
    values |= {"folder": str(folder), "password": secrets.token_hex(8), "host": socket.gethostname()}
    environment = os.environ | {"PATH": _path(), "SLURM_CONF": str(folder / "slurm.conf")}
    for name, text in FILES.items():
        _write(folder / name, text.format_map(values).encode())
    _write(folder / "key", secrets.token_bytes(1024))

    def words(command: str) -> list[str]:
        return [word.format_map(values) for word in command.split()]

    subprocess.run(words(PREPARE), env=environment, check=True, capture_output=True)
    with ExitStack() as stack:
        for name, command in DAEMONS.items():
            stack.enter_context(_running(words(command), folder / f"{name}.out", environment))
            asked, expected = ANSWERS[name]
            _wait(words(asked), expected, environment)
        yield environment


def free_ports(count: int) -> list[int]:
    """Ports on which nobody listens."""
    with ExitStack() as stack:
        sockets = [stack.enter_context(socket.socket()) for _ in range(count)]
        for each in sockets:
            each.bind(("127.0.0.1", 0))
        return [each.getsockname()[1] for each in sockets]


def _path() -> str:
    return os.pathsep.join([os.environ["PATH"], "/usr/sbin", "/sbin"])


def _write(path: Path, content: bytes) -> None:
    path.write_bytes(content)
    path.chmod(0o600)


@contextmanager
def _running(command: list[str], output: Path, environment: dict[str, str]) -> Iterator[None]:
    with output.open("wb") as file:
        process = subprocess.Popen(
            command, cwd=output.parent, env=environment, stdout=file, stderr=file, start_new_session=True
        )
    try:
        yield
    finally:
        process.terminate()
        try:
            process.wait(END)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def _wait(command: list[str], expected: str, environment: dict[str, str]) -> None:
    begun = time.monotonic()
    while True:
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False, timeout=PATIENCE)
        if done.returncode == 0 and expected in done.stdout:
            return
        assert time.monotonic() - begun < PATIENCE, f"{' '.join(command)}: {done.stdout}{done.stderr}"
        time.sleep(0.1)
