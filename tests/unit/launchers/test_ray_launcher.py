"""The Ray launcher: each job once, alone and in order, whatever becomes of the others."""

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import hydra
import pytest
from hydra._internal.callbacks import Callbacks
from hydra.core.global_hydra import GlobalHydra
from hydra.core.hydra_config import HydraConfig
from hydra.core.plugins import Plugins
from hydra.core.utils import JobReturn, JobStatus
from hydra.types import HydraContext, RunMode
from omegaconf import DictConfig

from dr_lab.cli.compose import HYDRA_VERSION
from dr_lab.cli.folders import shipped
from dr_lab.errors import ConfigError
from dr_lab.extras import MissingLibraryError

HOURS = 9999.0  # s; longer than any test
PATIENCE = 30.0  # s until what was killed is gone
LIGHT = "import sys, hydra_plugins.dr_lab_ray_launcher; sys.exit('ray' in sys.modules or 'torch' in sys.modules)"


@pytest.fixture
def ray(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("RAY_raylet_start_wait_time_s", "200")  # a busy machine
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def sigterm_unwinds() -> Iterator[None]:
    """As `dr-lab` has it."""
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    yield
    signal.signal(signal.SIGTERM, before)


def launch(
    task: Callable[[DictConfig], object], seeds: Sequence[int], *choices: str, first: int = 0
) -> list[JobReturn]:
    """Launch `dr-lab record seed=…` with another function in place of its work."""
    with hydra.initialize_config_dir(version_base=HYDRA_VERSION, config_dir=str(shipped())):
        loader = GlobalHydra.instance().config_loader()
        given = ["hydra/launcher=ray", "hydra.sweep.dir=sweep", *choices]
        config = loader.load_configuration("record", given, RunMode.MULTIRUN)
        context = HydraContext(loader, Callbacks())
        launcher = Plugins.instance().instantiate_launcher(context, task, config)
        return list(launcher.launch([[f"seed={seed}"] for seed in seeds], first))


def started(seed: int, folder: Path) -> int:
    return len(list(folder.glob(f"{seed}_*")))


def runs(process: int) -> bool:
    """Whether a process is there and more than an entry that nobody has read yet."""
    try:
        _, state = Path(f"/proc/{process}/stat").read_text(encoding="ascii").rsplit(") ", 1)
    except (FileNotFoundError, ProcessLookupError):
        return False
    return not state.startswith("Z")


def test_importing_the_plugin_is_light() -> None:
    assert subprocess.run([sys.executable, "-c", LIGHT], check=False).returncode == 0


def test_a_machine_without_ray_is_told(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)
    Plugins.instance()  # which loads the module, anew if it is loaded
    monkeypatch.setattr(sys.modules["hydra_plugins.dr_lab_ray_launcher"], "find_spec", lambda name: None)
    with pytest.raises(MissingLibraryError, match=r"needs ray, .*, on every machine"):
        launch(print, [0])


def test_jobs_that_no_machine_can_hold_are_told() -> None:
    Plugins.instance()
    require_room = sys.modules["hydra_plugins.dr_lab_ray_launcher"]._require_room
    gone = {"Alive": False, "Resources": {"CPU": 64.0, "robot": 1.0}}
    machines = [
        {"Alive": True, "Resources": {"CPU": 2.0, "robot": 1.0}},
        {"Alive": True, "Resources": {"CPU": 4.0}},
        gone,
    ]
    for fits in ({}, {"num_cpus": 4, "num_gpus": 0, "memory": None}, {"num_cpus": 2, "resources": {"robot": 1}}):
        require_room(machines, fits)
    with pytest.raises(
        ConfigError, match=r"asks for \{'CPU': 4, 'robot': 1\}.*: \{'CPU': 2.0, 'robot': 1.0\}; \{'CPU': 4"
    ):
        require_room(machines, {"num_cpus": 4, "resources": {"robot": 1}})


@pytest.mark.daemons
@pytest.mark.usefixtures("ray")
def test_a_job_that_fails_fails_once_and_alone(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def task(cfg: DictConfig) -> str:
        (tmp_path / f"{cfg.seed}_{os.getpid()}_{time.monotonic_ns()}").touch()
        if cfg.seed == 11:
            raise ValueError(f"seed {cfg.seed}")
        if cfg.seed == 12:
            os._exit(9)
        if cfg.seed == 13:
            raise type("Local", (Exception,), {"__reduce__": lambda self: threading.Lock()})
        time.sleep(0.2 * (20 - cfg.seed))  # the last jobs end first
        return f"{HydraConfig.get().runtime.output_dir} {os.getcwd()} {os.environ['RAY_AUTH_MODE']}"

    seeds = range(10, 18)
    results = launch(task, seeds, first=4)
    good = {seed: result for seed, result in zip(seeds, results, strict=True) if result.status == JobStatus.COMPLETED}
    assert set(good) == set(seeds) - {11, 12, 13}
    for seed, result in good.items():
        assert result.return_value == f"{tmp_path / 'sweep' / str(seed - 6)} {tmp_path} token"
    for seed, kind in ((11, ValueError), (12, Exception), (13, Exception)):
        with pytest.raises(kind):
            _ = results[seed - 10].return_value
    assert [started(seed, tmp_path) for seed in seeds] == [1] * len(seeds)
    lines = [line for line in capsys.readouterr().out.splitlines() if " jobs, " in line]
    assert [line.split()[0] for line in lines] == [str(n) for n in range(1, len(seeds) + 1)]
    assert sum(line.endswith("failed") for line in lines) == 3


@pytest.mark.daemons
@pytest.mark.usefixtures("ray", "sigterm_unwinds")
@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGTERM])
def test_ctrl_c_or_sigterm_stops_the_jobs(sent: signal.Signals, tmp_path: Path) -> None:
    def task(cfg: DictConfig) -> None:
        (tmp_path / f"{cfg.seed}_{os.getpid()}").touch()
        try:
            while True:
                time.sleep(0.01)  # Ray's interrupt waits for the end of a longer one
        except KeyboardInterrupt:
            if cfg.seed == 1:
                time.sleep(HOURS)
            (tmp_path / "in_order").touch()
            raise

    def press() -> None:
        while not (started(0, tmp_path) and started(1, tmp_path)):
            time.sleep(0.01)
        os.kill(os.getpid(), sent)

    pressing = threading.Thread(target=press, daemon=True)
    pressing.start()
    with pytest.raises(KeyboardInterrupt):
        launch(task, range(3), "+hydra.launcher.init.num_cpus=2", "hydra.launcher.grace=2")
    pressing.join()
    assert (tmp_path / "in_order").exists()
    assert not started(2, tmp_path)
    begun = time.monotonic()
    while any(runs(int(marker.name[2:])) for marker in tmp_path.glob("?_*")):
        assert time.monotonic() - begun < PATIENCE
        time.sleep(0.1)
