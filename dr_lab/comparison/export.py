"""The improved model as plain MJCF, and the rollout that it reproduces."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import mujoco
import numpy as np
import yaml

from dr_lab.comparison.plain_file import stand_ins
from dr_lab.comparison.study import Study
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.fit.states import StateFit, fit_states
from dr_lab.diagnosis.windows.channels import Tape
from dr_lab.diagnosis.windows.windows import Windows
from dr_lab.effects.effect import PlacedEffect
from dr_lab.files import atomic, write_text
from dr_lab.physics.compiling import written
from dr_lab.physics.context import ContextEstimate, ContextSpace
from dr_lab.physics.effect_parts import SpecEdit
from dr_lab.physics.mjcf import mjcf
from dr_lab.physics.model import Model
from dr_lab.physics.model_effect import ModelEffect
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
class ExportedModel(Model):
    """A model read back from its file, at the one context that the file was written at.

    Its spec holds what MJCF can express of the effects; their other parts act beside it.

    Attributes:
        fixed: the context, by parameter name.
    """

    fixed: Mapping[str, float] = field(default_factory=dict)

    @cached_property
    def space(self) -> ContextSpace:
        """No parameter: the values are fixed."""
        return ContextSpace(())

    def spec_at(self, z: Array) -> mujoco.MjSpec:
        """Fresh copy of the file's spec."""
        del z
        return self.spec.copy()

    def values(self, z: Array) -> dict[str, Array]:
        """The fixed values, the same in all contexts, shape (1,)."""
        del z
        return {name: np.array([value]) for name, value in self.fixed.items()}


def inexpressible(model: Model, z: Array) -> list[str]:
    """What MJCF cannot express of the model at context z, in a sentence for each effect."""
    values, placed = model.space.mapping(z), [each for each in model.effects if isinstance(each, PlacedEffect)]
    missing = (each.effect.lacking(each.site, each.local(values), model.spec.option) for each in placed)
    return [f"model.xml cannot say: {each}." for each in missing if each]


def write_model(path: Path, model: Model, z: Array) -> tuple[ExportedModel, list[str]]:
    """Write the model at context z as MJCF and read it back.

    MJCF text keeps six digits; everything that is recorded afterwards is simulated from the model read back. Where the
    file lacks an effect, dry friction stands in for it if that comes near; the model read back has the effect instead.

    Returns:
        The model read back, beside whose spec the effects act if the file lacks anything, and what the file lacks.
    """
    exact, stand_in = mjcf(model, z), stand_ins(model, z)
    missing = [*inexpressible(model, z), *(each.told for each in stand_in)]
    read = mujoco.MjSpec.from_string(exact)
    alone = read.copy()
    for each in stand_in:
        each.write(alone)
    comments = "".join(f"<!-- {sentence} -->\n" for sentence in missing)
    write_text(path, comments + (written(alone) if stand_in else exact))
    effects = _beside(model, z) if missing else ()
    return ExportedModel(model.name, read, (), {}, effects, fixed=model.space.mapping(z)), missing


def _beside(model: Model, z: Array) -> tuple[ModelEffect, ...]:
    """The effects that act beside the file: all but those that a replay would take in place of what the file has."""
    values, option = model.space.mapping(z), model.spec.option
    live = {each.label for each, _, part in model.having(SpecEdit) if part.expressible(each.local(values), option)}
    return tuple(each for each in model.effects if each.replayed(model.spec) is each or each.label not in live)


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
