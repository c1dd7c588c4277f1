"""Logs of the experiment that an earlier run proposes, played on a simulated machine."""

import csv
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from dr_lab.bounds import Count, require_bounds
from dr_lab.channel_names import joint_of
from dr_lab.errors import ConfigError, DataError
from dr_lab.plants.played import Played
from dr_lab.plants.rig import Rig
from dr_lab.reports.gap_entries import ExperimentEntry
from dr_lab.reports.report import read_gap
from dr_lab.sources.plant import PlantSource
from dr_lab.sources.source import NamedLog
from dr_lab.trajectory import Array

_SERIES = "next"


@dataclass(frozen=True)
class NextExperimentSource:
    """What ``next_experiment.csv`` of a run commands, from the pose that its report asks for.

    The logs are next_1, next_2 …, so that they may lie beside those that the run has read. They are taken after the
    logs that the bench makes by itself, with noise of their own.

    Attributes:
        bench: the machine, its instruments and its topics.
        run: folder of a run of ``dr-lab close``, ``diagnose`` or ``add``.
        repeats: how often the experiment is played.

    Raises:
        ConfigError: it is to be played less than once.
    """

    bench: PlantSource
    run: str
    repeats: Count

    def __post_init__(self) -> None:
        require_bounds(self, "")

    def logs(self, seed: int) -> Iterator[NamedLog]:
        """The experiment's logs; errors as `rig`."""
        return replace(self.bench, plant=self.rig()).logs(seed)

    def companions(self, seed: int) -> Mapping[str, bytes]:
        """``truth.yaml``, as of every log of the machine."""
        return self.bench.companions(seed)

    def rig(self) -> Rig:
        """The bench, ready to play the experiment.

        Raises:
            ConfigError: the run has no report, its report no experiment, or it is none of this machine.
            DataError: the report cannot be read, or its commands are no table of numbers.
        """
        folder, rig = Path(self.run).expanduser(), self.bench.plant
        entry = _proposed(folder)
        time, commands = _rows(folder / entry.command_file, rig.actuators)
        pose = {joint_of(name): at for name, at in entry.start.items()}
        if not set(pose) <= set(rig.joints):
            raise _other_machine(folder, "moves", pose, rig.joints)
        return replace(
            rig,
            operator=Played(time, commands),
            peaks=[1.0] * self.repeats,
            start={**rig.start, **pose},
            duration=float(entry.duration or time[-1]),
            epoch=rig.epoch + len(rig.peaks) * rig.pause,
            series=_SERIES,
        )


def _proposed(folder: Path) -> ExperimentEntry:
    entry = read_gap(folder, "run").judged.next_experiment
    if entry is None:
        raise ConfigError(
            f"The report of run={folder} proposes no experiment: it found nothing to separate or to sharpen."
        )
    if entry.reason:
        raise ConfigError(
            f"The report of run={folder} proposes no experiment: the gentlest that was tried would leave "
            f"{entry.reason}. Its report.md says what may help."
        )
    return entry


def _rows(path: Path, actuators: Sequence[str]) -> tuple[Array, Array]:
    """Times of shape (r,) and commands of shape (r, m), in the order of the machine's actuators."""
    if not path.is_file():
        raise ConfigError(f"The report of the run speaks of {path}, which is not there. Copy the whole run folder.")
    with path.open(encoding="utf-8", newline="") as file:
        lines = [line for line in csv.reader(file) if line]
    header, rows = next(iter(lines), []), lines[1:]
    if header and set(header[1:]) != set(actuators):
        raise _other_machine(path, "commands", header[1:], actuators)
    try:
        table = np.array(rows, dtype=float)
    except ValueError:  # a line is shorter than others, or holds a word
        table = np.empty((0, 0))
    if not (
        rows and table.shape[1:] == (len(header),) and np.isfinite(table).all() and (np.diff(table[:, 0]) > 0).all()
    ):
        raise DataError(
            f"{path} holds no table of what is to be commanded; expected the line time_s,{','.join(actuators)} and "
            "below it lines of as many finite numbers, whose times increase. Copy the file from the run once more."
        )
    return table[:, 0], table[:, [header.index(name) for name in actuators]]


def _other_machine(path: Path, verb: str, asked: Iterable[str], there: Iterable[str]) -> ConfigError:
    return ConfigError(
        f"The experiment of {path} {verb} {', '.join(asked)}; this machine has {', '.join(there)}. "
        "Give the plant whose logs the run has read, such as plant=pendulum."
    )
