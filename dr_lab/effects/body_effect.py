"""What effects at a moving body have in common."""

from typing import Any

import mujoco
import numpy as np

from dr_lab.errors import ModelError, UnknownNameError
from dr_lab.physics.inertias import require_apart


def moving_bodies(model: mujoco.MjModel) -> tuple[str, ...]:
    """Names of the moving bodies with mass."""
    return tuple(
        model.body(i).name
        for i in range(1, model.nbody)
        if model.body(i).name and model.body_weldid[i] != 0 and model.body_mass[i] > 0
    )


def body_of(spec: mujoco.MjSpec, name: str) -> Any:  # noqa: ANN401 (MjsBody)
    """A body of a spec.

    Raises:
        UnknownNameError: there is no such body; the message lists those that exist.
    """
    body = spec.body(name)
    if body is None:
        raise UnknownNameError("body", name, [b.name for b in spec.bodies if b.name], f"model {spec.modelname!r}")
    return body


def with_inertial(spec: mujoco.MjSpec, name: str) -> Any:  # noqa: ANN401 (MjsBody)
    """A body of a spec, whose mass, centre and inertia stand in the spec; those that follow from geoms are written out.

    Raises:
        UnknownNameError: there is no such body.
        ModelError: the compiler would overwrite them, or change other bodies with them.
    """
    if spec.compiler.inertiafromgeom == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE:
        raise ModelError(
            f'Body {name!r} needs <inertial>, which inertiafromgeom="true" ignores. Set the compiler\'s '
            'inertiafromgeom to "auto".'
        )
    require_apart(spec, name)
    body = body_of(spec, name)
    if not body.explicitinertial:
        compiled = spec.copy().compile().body(name)
        body.mass, body.explicitinertial = float(compiled.mass[0]), True
        body.ipos, body.iquat, body.inertia = compiled.ipos, compiled.iquat, compiled.inertia
        body.fullinertia = np.full(6, np.nan)
    return body
