"""Whether a declared parameter changes anything."""

from collections.abc import Callable

import mujoco
import numpy as np

from dr_lab.errors import ModelError
from dr_lab.physics.context import ContextSpace
from dr_lab.physics.parameter import Parameter
from dr_lab.trajectory import Array

Compile = Callable[[Array], mujoco.MjModel]


def require_live(model: str, parameter: Parameter, space: ContextSpace, compile_at: Compile) -> None:
    """Check that a parameter changes the compiled model between its bounds.

    A bound that does not compile is an infeasible context, which is a change.

    Args:
        model: the model's name.
        parameter: which one.
        space: the model's context.
        compile_at: a model's `compile`.

    Raises:
        ModelError: it changes nothing.
    """
    ends = []
    for bound in (parameter.low, parameter.high):
        z = space.nominal
        z[space.index(parameter.name)] = bound
        ends.append(_fingerprint(compile_at, z))
    if ends[0] and ends[0] == ends[1]:
        raise ModelError(
            f"Parameter {parameter.name!r} of model {model!r} changes nothing between {parameter.low:g} and "
            f"{parameter.high:g}. Point its target at something the physics uses, or delete it."
        )


def _fingerprint(compile_at: Compile, z: Array) -> bytes:
    """The compiled model's bytes; empty where the context does not compile."""
    try:
        at_z = compile_at(z)
    except ModelError:
        return b""
    buffer = np.zeros(mujoco.mj_sizeModel(at_z), np.uint8)
    mujoco.mj_saveModel(at_z, None, buffer)
    return buffer.tobytes()
