"""What effects at actuators have in common."""

from collections.abc import Sequence
from typing import Any, ClassVar

import mujoco
import numpy as np

from dr_lab.effects.effect import Effect
from dr_lab.errors import UnknownNameError
from dr_lab.trajectory import Array

ALL_ACTUATORS = "all_actuators"
_LAW = ("gaintype", "gainprm", "biastype", "biasprm", "dyntype", "dynprm", "forcerange", "trntype")


class ActuatorEffect(Effect):
    """An effect at a named actuator with a single command, or at all of them alike.

    Drives of one make share what they lack, and a late bus is late for all of them. So the site ``all_actuators``
    stands for all actuators at which the effect can sit, with the same values, where these are two or more. Drives of
    unlike sizes share times and factors alone (`sizeless`).

    Attributes:
        sizeless: whether the parameters are times and factors, which mean the same at drives of any size.
    """

    sizeless: ClassVar[bool] = False
    by_command: ClassVar[bool] = True

    def sites(self, model: mujoco.MjModel) -> tuple[str, ...]:
        """Names of the actuators at which it can sit, and what stands for all of them."""
        single = self._single(model)
        shared = len(single) > 1 and ALL_ACTUATORS not in single and (self.sizeless or _alike(model, single))
        return (*single, ALL_ACTUATORS) if shared else single

    def elements(self, model: mujoco.MjModel, site: str) -> tuple[str, ...]:
        """The actuator, or all of them."""
        single = self._single(model)
        return single if site == ALL_ACTUATORS and ALL_ACTUATORS not in single else (site,)

    def acts_at(self, model: mujoco.MjModel, row: int) -> bool:
        """Whether it can sit at an actuator with one command, by row; at each of them unless an effect says less."""
        del model, row
        return True

    def _single(self, model: mujoco.MjModel) -> tuple[str, ...]:
        rows = [row for row in range(model.nactuator) if int(model.actuator_ctrlnum[row]) == 1]
        return tuple(model.actuator(row).name for row in rows if model.actuator(row).name and self.acts_at(model, row))


def actuator_of(spec: mujoco.MjSpec, name: str) -> Any:  # noqa: ANN401 (MjsActuator)
    """The actuator of a spec.

    Raises:
        UnknownNameError: there is no such actuator; the message lists those that exist.
    """
    actuator = spec.actuator(name)
    if actuator is None:
        names = [a.name for a in spec.actuators if a.name]
        raise UnknownNameError("actuator", name, names, f"model {spec.modelname!r}")
    return actuator


def idle_at_zero(model: mujoco.MjModel, row: int) -> bool:
    """Whether an actuator's force does not depend on position, so that the command 0 asks for no place."""
    return not model.actuator_biasprm[row, 1]


def _alike(model: mujoco.MjModel, names: Sequence[str]) -> bool:
    """Whether drives are of one make: their forces follow the same law of command and motion, whatever their axes."""
    first, *others = (_force_law(model, model.actuator(name).id) for name in names)
    return all(np.array_equal(first, other) for other in others)


def _force_law(model: mujoco.MjModel, row: int) -> Array:
    """All numbers of an actuator that give its force, and what it acts on."""
    law = [np.atleast_1d(getattr(model, f"actuator_{name}")[row]) for name in _LAW]
    joint = model.actuator_trntype[row] == mujoco.mjtTrn.mjTRN_JOINT
    moved = model.jnt_type[model.actuator_trnid[row, 0]] if joint else -1
    return np.concatenate([*law, np.abs(model.actuator_gear[row]), [moved]])
