"""A trained policy in a control loop; ``from dr_lab import load_controller``."""

import functools
from pathlib import Path

from dr_lab.cli.arguments import compose_arguments
from dr_lab.cli.folders import shipped
from dr_lab.deployment.controller import Controller
from dr_lab.envs.setting import Setting
from dr_lab.errors import ConfigError
from dr_lab.evaluators.trained_run import TrainedRun, subject_of
from dr_lab.reports.typed import typed


def load_controller(
    run: str | Path = "latest", runs: str | Path = "outputs", config_dir: Path | None = None
) -> Controller:
    """The policy that a training run left, to be driven by measured positions and velocities.

    Example:
        >>> controller = load_controller("balanced")
        >>> controller.seconds, controller.positions
        (0.01, (('arm position', 'rad'), ('pole position', 'rad')))
        >>> controller.act(qpos, qvel)  # of the robot, once a control step

    Args:
        run: folder of the training run, or ``latest`` for the newest below `runs`.
        runs: folder that collects training runs.
        config_dir: folder with the user's own groups that the run needs.

    Raises:
        DataError: there is no such run, or it has no readable checkpoint.
        ConfigError: another engine plays its task, or the task reads more than positions and velocities.
    """
    folders = (*([] if config_dir is None else [config_dir.absolute()]), shipped())
    folder = TrainedRun(str(run), str(runs), threads=1).folder()
    subject = subject_of(folder, functools.partial(compose_arguments, folders=folders), threads=1)
    if not isinstance(subject.setting, Setting):
        raise ConfigError(
            f"load_controller makes observations of the positions and velocities of a MuJoCo model, and "
            f"env={subject.setting.name} has none. Make them yourself, for the file of dr-lab export "
            f"{typed('run', folder)}."
        )
    return Controller(subject.setting, subject.policy)
