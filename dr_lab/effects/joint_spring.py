"""A further spring at a joint, combined with the joint's own without approximation."""

import mujoco
import numpy as np
from numpy.polynomial import Polynomial

from dr_lab.effects.joint_effect import joint_of
from dr_lab.errors import ModelError


def add_spring(spec: mujoco.MjSpec, site: str, pull: Polynomial, rest: float) -> None:
    """Let a joint be pulled by τ = −pull(q) as well, a polynomial of degree 3 at most.

    Together with the joint's own f(x) = −(a x + b x² + c x³), x = q − q₀, this is again a cubic. MuJoCo knows no
    constant term, so the sum is written about a q at which it vanishes.

    Args:
        spec: is edited.
        site: joint.
        pull: by the position in rad or m.
        rest: where the further spring rests, rad or m; of several places without force the nearest is taken.

    Raises:
        UnknownNameError: there is no such joint.
        ModelError: the joint's ``springdamper`` would overwrite it, or it would yield with the joint's own spring.

    Source: MuJoCo joint/stiffness, joint/springref and joint/springyield, computation chapter ("Polynomial forces").
    """
    joint = joint_of(spec, site)
    if joint.springyield > 0:
        raise ModelError(
            f"Joint {site!r} has springyield {joint.springyield:g}, at which a further spring would yield as the "
            "joint's own does. Take springyield out of the MJCF, or write the spring as effect=formula."
        )
    if not pull.coef.any():
        return
    hinge = joint.type == mujoco.mjtJoint.mjJNT_HINGE
    unit = np.pi / 180 if hinge and spec.compiler.degree else 1.0  # of springref in the spec, in rad or m
    total = Polynomial([0.0, *joint.stiffness])(Polynomial([-joint.springref * unit, 1.0])) + pull
    at = _root(total, near=rest)
    joint.stiffness = [total.deriv(order)(at) / factorial for order, factorial in ((1, 1), (2, 2), (3, 6))]
    joint.springref = at / unit


def _root(polynomial: Polynomial, near: float) -> float:
    """The real root nearest to `near` (a spring that always pulls back has exactly one)."""
    if polynomial.trim().degree() == 1:
        return float(-polynomial.coef[0] / polynomial.coef[1])
    roots = polynomial.trim().roots()
    real = roots[np.isreal(roots)].real
    return float(real[np.argmin(np.abs(real - near))])
