"""A small machine for the tests of the command line: two verbs whose workflows only remember their arguments."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType
from typing import Any

from dr_lab.__main__ import main
from dr_lab.errors import DataError

FILES = {
    "compare.yaml": """\
        # compare the two
        #
        # dr-lab compare model=swing
        defaults:
          - base: run
          - model: swing
          - effect: all
          - _self_
          - experiment: null
        horizon: 0.5  # s, predicted open loop
        names: [a]
        """,
    "add.yaml": """\
        # add one effect
        defaults:
          - base: run
          - model: swing
          - effect: ???
          - _self_
        effect:
          joint: null
        """,
    "model/swing.yaml": """\
        # a swing. It has one joint.
        _target_: parts.Machine
        name: swing
        mjcf: ${conf:model/swing.xml}
        parameters:
          arm.mass: {low: 1.0, high: 2.0}
        """,
    "model/swing.xml": "<mujoco/>",
    "model/door.yaml": "_target_: parts.Machine\nname: door\nmjcf: none\nparameters: {}\n",
    "model/broken.yaml": "_target_: parts.broken\nname: broken\n",
    "effect/all.yaml": "# @package _global_\n# every effect\ndefaults: ${every:effect}\n",
    "effect/rust.yaml": "# @package effects.rust\n# rust in the joint\n_target_: parts.Effect\nname: rust\n",
    "effect/wind.yaml": "# @package effects.wind\n_target_: parts.Effect\nname: wind\n",
    "experiment/night.yaml": "# @package _global_\ndefaults:\n  - override /model: door\nseed: 7\n",
}


@dataclass(frozen=True)
class Machine:
    name: str
    mjcf: str
    parameters: dict[str, dict[str, float]] = field(default_factory=dict)


@dataclass(frozen=True)
class Effect:
    name: str


def broken(name: str) -> Machine:
    raise DataError(f"{name} has no legs")


class CommandLine:
    """Runs `dr-lab` in this process, keeps what the workflows were called with and leaves files that are asked for."""

    def __init__(self) -> None:
        self.calls: list[dict[str, Any]] = []
        self.files: list[str] = []

    def __call__(self, *arguments: str) -> int:
        return main(arguments)

    def compare(
        self,
        *,
        model: Machine,
        effects: dict[str, Effect],
        horizon: float,
        names: list[str],
        seed: int,
        threads: int | None,
        run_dir: Path,
    ) -> None:
        self.calls.append(locals())
        for name in self.files:
            (run_dir / name).touch()

    def add(
        self,
        *,
        model: Machine,
        effects: dict[str, Effect],
        effect: dict[str, str | None],
        seed: int,
        threads: int | None,
        run_dir: Path,
    ) -> None:
        self.calls.append(locals())


def module(name: str, **content: Callable[..., Any] | type) -> ModuleType:
    made = ModuleType(name)
    vars(made).update(content)
    return made


def write(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    lines = text.splitlines()
    margin = min((len(line) - len(line.lstrip()) for line in lines if line.strip()), default=0)
    path.write_text("\n".join(line[margin:] for line in lines) + "\n")
