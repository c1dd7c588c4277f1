"""The improved model as plain MJCF, and the rollout that it reproduces."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import mujoco
import numpy as np
import yaml

from dr_lab.comparison.study import Study
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.fit.states import StateFit, fit_states
from dr_lab.diagnosis.windows.channels import Tape
from dr_lab.diagnosis.windows.windows import Windows
from dr_lab.files import atomic, write_text
from dr_lab.physics.compiling import written
from dr_lab.physics.context import ContextEstimate
from dr_lab.physics.law import Law
from dr_lab.physics.model import Model, ModelEffect
from dr_lab.physics.parameter import Parameter
from dr_lab.physics.signal import Reading
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class Played:
    """A model played over windows that follow one another.

    Attributes:
        replay: the windows.
        fit: their fitted starts.
    """

    replay: Replay
    fit: StateFit

    @cached_property
    def tape(self) -> Tape:
        """What the model does from the fitted starts."""
        return self.replay.simulate(self.fit.z[None], self.fit.delta[None])[0]


@dataclass(frozen=True)
class ExportRemainder:
    """What one context needs that MJCF cannot express; fulfils `physics.model.ModelEffect`.

    Attributes:
        effects: the model's effects.
        values: the context, by parameter name.
        option: the model's options.
        label: what stands for it among effects.
        parameters: none, the values are fixed.
    """

    effects: tuple[ModelEffect, ...]
    values: Mapping[str, float]
    option: mujoco.MjOption
    label: str = "beside_model.xml"
    parameters: tuple[Parameter, ...] = ()

    def prepare(self, spec: mujoco.MjSpec) -> None:
        """Nothing, as `edit`."""

    def edit(self, spec: mujoco.MjSpec, values: Mapping[str, float]) -> None:
        """Nothing: the physics is in the file."""

    def reading(self, values: Mapping[str, Array], channel: str, read: Reading, begin: Array) -> Reading:
        """What the effects' sensors report of a channel."""
        del values
        for effect in self.effects:
            read = effect.reading(self._columns, channel, read, begin)
        return read

    def command(self, values: Mapping[str, Array], actuator: str, series: Array, option: mujoco.MjOption) -> Array:
        """What the effects make of an actuator's commands."""
        del values
        for effect in self.effects:
            series = effect.command(self._columns, actuator, series, option)
        return series

    def drivers(self, values: Mapping[str, Array], compiled: mujoco.MjModel) -> tuple[Law, ...]:
        """What the effects' drivers do with commands, the same in all simulations."""
        del values
        fixed = {name: np.array([value]) for name, value in self.values.items()}
        return tuple(law for effect in self.effects for law in effect.drivers(fixed, compiled))

    def force_laws(self, values: Mapping[str, Array], models: Sequence[mujoco.MjModel]) -> tuple[Law, ...]:
        """What acts from step to step, the same in all simulations."""
        del values
        fixed = {name: np.array([value]) for name, value in self.values.items()}
        return tuple(law for effect in self.effects for law in effect.force_laws(fixed, models))

    def lacking(self, values: Mapping[str, float], option: mujoco.MjOption) -> str:
        """What the file lacks, in one line."""
        del values, option
        return "; ".join(self.sentences())

    def sentences(self) -> list[str]:
        """What the file lacks, effect by effect."""
        missing = (effect.lacking(self.values, self.option) for effect in self.effects)
        return [f"model.xml cannot say: {each}." for each in missing if each]

    @property
    def _columns(self) -> dict[str, Array]:
        return {name: np.full((1, 1, 1), value) for name, value in self.values.items()}


def mjcf(model: Model, z: Array) -> str:
    """The model at context z as MJCF text; meshes and pictures stay where they are, and the text says where that is."""
    spec = model.spec_at(z)
    _keep_assets(spec)
    return written(spec)


def write_model(path: Path, model: Model, z: Array) -> tuple[Model, ExportRemainder]:
    """Write the model at context z as MJCF and read it back.

    MJCF text keeps six digits; everything that is recorded afterwards is simulated from the model read back.

    Returns:
        The model read back, without parameters, and what it needs beside the file, which is among its effects.
    """
    beside = ExportRemainder(model.effects, model.space.mapping(z), model.spec.option)
    comments = "".join(f"<!-- {sentence} -->\n" for sentence in beside.sentences())
    write_text(path, comments + mjcf(model, z))
    return Model(
        model.name, mujoco.MjSpec.from_file(str(path)), (), {}, (beside,) if beside.sentences() else ()
    ), beside


def _keep_assets(spec: mujoco.MjSpec) -> None:
    """Let the files that a spec names be found from any folder."""
    base = Path(spec.modelfiledir).absolute()
    if any(asset.file for asset in (*spec.meshes, *spec.hfields, *spec.skins)):
        spec.compiler.meshdir = str(base / spec.compiler.meshdir)
    if any(texture.file or any(texture.cubefiles) for texture in spec.textures):
        spec.compiler.texturedir = str(base / spec.compiler.texturedir)


def play(study: Study, model: Model, z: Array, windows: Windows) -> Played:
    """Fit the starts of consecutive windows and keep the replay."""
    return Played(*fit_states(model, z, windows, study.bench.solver, study.bench.threads))


def write_rollout(path: Path, played: Played) -> None:
    """Store what MuJoCo alone needs to repeat the rollout.

    Arrays: ``state`` (w, nstate) start states (`mjSTATE_INTEGRATION`), ``ctrl`` (w, s, nu) as MuJoCo got it, ``qpos``
    (w, s + 1, nq) and ``qvel`` (w, s + 1, nv) recorded, ``begin`` (w,) start times in s and ``log`` (w,) names of logs.
    """
    tape, windows = played.tape, played.replay.windows
    arrays = {
        "state": tape.start[0],
        "ctrl": tape.controls[0],
        "qpos": tape.qpos[0],
        "qvel": tape.qvel[0],
        "begin": windows.begin,
        "log": np.array([windows.logs[k] for k in windows.log]),
    }
    with atomic(path) as temporary, open(temporary, "wb") as file:
        np.savez_compressed(file, **arrays)


def write_context(path: Path, estimate: ContextEstimate) -> None:
    """Write mean, covariance and bounds of the fitted context as yaml, ready to randomise around."""
    space = estimate.space
    content = {
        "schema": "dr_lab/context/1",
        "names": list(space.names),
        "units": [p.unit for p in space.parameters],
        "mean": estimate.mean.tolist(),
        "std": estimate.std.tolist(),
        "covariance": estimate.covariance.tolist(),
        "low": space.low.tolist(),
        "high": space.high.tolist(),
        "nominal": space.nominal.tolist(),
    }
    write_text(path, yaml.safe_dump(content, sort_keys=False, allow_unicode=True))
