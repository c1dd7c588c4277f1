"""Inertias that MuJoCo infers from shapes, written out."""

from collections.abc import Iterable

import mujoco
import numpy as np

from dr_lab.errors import ModelError
from dr_lab.physics.compiling import compiled
from dr_lab.physics.shared_target import SharedTarget, places
from dr_lab.physics.target import Target

BODY = ("mass", "inertia", "inertia_scale", "ipos")
_SHAPE = ("size", "density", "mass")
_OF_ALL_BODIES = {"settotalmass": -1.0, "boundmass": 0.0, "boundinertia": 0.0}  # and where MuJoCo leaves bodies alone


def written_out(spec: mujoco.MjSpec, targets: Iterable[Target | SharedTarget]) -> mujoco.MjSpec:
    """The spec, with every body's inertia explicit where a target asks for one that is inferred.

    Gymnasium's machines, for example, give shapes and a density. The compiled model stays the same. Where the compiler
    changes all bodies together, as by ``settotalmass``, what one body gets would be taken from the others. So what the
    compiler makes of them is explicit, too, unless a target varies a shape or density.

    Args:
        spec: the caller's own copy; it may be edited.
        targets: what will vary.

    Raises:
        ModelError: another target varies a shape or density, which explicit inertias would no longer follow.
    """
    every = [*places(targets)]
    wanted = [p for p in every if p.kind == "body" and p.attribute in BODY and _inferred(spec, p.element)]
    shapes = [p for p in every if p.kind == "geom" and p.attribute in _SHAPE]
    if not wanted and (shapes or not _changed_together(spec)):
        return spec
    if shapes:
        raise ModelError(
            f"Targets {wanted[0]} and {shapes[0]} exclude each other: a body's mass is either given or follows from "
            "its shapes. Delete one of the two parameters, or give the bodies an <inertial>."
        )
    nominal = compiled(spec.copy())
    for body in spec.bodies[1:]:
        row = nominal.body(body.name)
        body.mass, body.explicitinertial = float(row.mass[0]), True
        body.ipos, body.iquat, body.inertia = row.ipos.copy(), row.iquat.copy(), row.inertia.copy()
        body.fullinertia = np.full(6, np.nan)
    spec.compiler.inertiafromgeom = int(mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_FALSE)
    for attribute, off in _OF_ALL_BODIES.items():
        setattr(spec.compiler, attribute, off)
    return spec


def require_apart(spec: mujoco.MjSpec, name: str) -> None:
    """Check that a change of one body's inertia leaves the other bodies, and what is given is what MuJoCo compiles.

    Raises:
        ModelError: the compiler changes all bodies together.
    """
    changed = _changed_together(spec)
    if changed:
        raise ModelError(
            f"Body {name!r} needs an inertia that is its own, but the compiler's {changed[0]} changes those of all "
            f"bodies, and a parameter varies a shape or density. Delete {changed[0]} from the MJCF, or that parameter."
        )


def _changed_together(spec: mujoco.MjSpec) -> list[str]:
    """Attributes of the compiler that change the inertias of all bodies."""
    return [attribute for attribute in _OF_ALL_BODIES if getattr(spec.compiler, attribute) > 0]


def _inferred(spec: mujoco.MjSpec, name: str) -> bool:
    body = spec.body(name)
    return body is not None and bool(body.geoms) and not body.explicitinertial
