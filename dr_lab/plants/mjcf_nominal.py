"""Machines whose documents are an MJCF file."""

import copy
from abc import ABC
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import mujoco

from dr_lab.errors import ModelError
from dr_lab.plants.nominal import Nominal
from dr_lab.trajectory import Array

# Contact forces to rounding, so that the integrator's error estimate sees no noise of the solver.
_PRECISE = {"tolerance": 1e-14, "ls_tolerance": 1e-4, "iterations": 200, "ls_iterations": 200}


@dataclass(frozen=True, kw_only=True)
class MjcfNominal(Nominal, ABC):
    """A machine whose documents are an MJCF file, whichever engine plays it.

    Attributes:
        mjcf: the file.
        free: what is not exactly known: ``<body>.mass``, whose inertia scales with it, or ``<joint>.damping``.

    Raises:
        ModelError: the model is not one of hinges and slides with one command to each actuator.
    """

    mjcf: str
    free: Sequence[str]

    def documented(self) -> dict[str, float]:
        """Masses (kg) and dampings (N·m·s/rad or N·s/m) as the file has them."""
        return {name: float(_field(self._model, name)[0]) for name in self.free}

    def model(self, true: Mapping[str, float]) -> mujoco.MjModel:
        """A copy of the compiled file with given masses and dampings."""
        model = copy.copy(self._model)
        for name, value in true.items():
            field = _field(model, name)
            if name.endswith(".mass"):
                model.body(name.removesuffix(".mass")).inertia[:] *= value / field[0]
            field[0] = value
        return model

    @cached_property
    def _model(self) -> mujoco.MjModel:
        spec = mujoco.MjSpec.from_file(str(Path(self.mjcf)))
        for body in spec.bodies:
            body.simple = 0  # what is hidden may move its centre
        model = spec.compile()
        if model.nq != model.nv or model.nv != model.njnt or model.nu != model.nactuator:
            raise ModelError(f"{self.mjcf}: a plant is made of hinges and slides, with one command to each actuator.")
        for option, value in _PRECISE.items():
            setattr(model.opt, option, value)
        return model


def _field(model: mujoco.MjModel, name: str) -> Array:
    """Where a free parameter stands in the compiled model, shape (1,)."""
    element, _, attribute = name.rpartition(".")
    return model.body(element).mass if attribute == "mass" else model.joint(element).damping
