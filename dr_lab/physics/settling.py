"""A spec whose elements stay what they are, whatever a context makes of others."""

import mujoco
import numpy as np

from dr_lab.errors import ModelError
from dr_lab.physics.compiling import compiled
from dr_lab.physics.naming import name_elements

_SAME = 1e-9  # m, and of quaternions; rounding


def settled(spec: mujoco.MjSpec) -> mujoco.MjSpec:
    """A copy of a spec that compiles to the same machine, in which nothing changes with what a parameter varies.

    Every body, joint, actuator and sensor has a name. Bodies that are welded together stay apart: where MuJoCo fuses
    them (``fusestatic``, as it does with a URDF), one would have the inertia of the others, and these no names.
    Nothing sleeps (``flag/sleep``), for batches forget between two calls what does. The frames of free bodies stay
    where they are (``compiler/alignfree``, ``freejoint/align``).

    Raises:
        ModelError: the compiler would move the frame of a free body with its centre of mass.
    """
    spec = spec.copy()
    name_elements(spec)
    spec.compiler.fusestatic = False
    spec.option.enableflags &= ~int(mujoco.mjtEnableBit.mjENBL_SLEEP)
    _write_out_gains(spec)
    _keep_free_frames(spec)
    return spec


def _keep_free_frames(spec: mujoco.MjSpec) -> None:
    """Let no free body be aligned with its inertial frame, which a changed mass would move, and its position with it.

    Source: MuJoCo 4.0, XML reference, freejoint/align.

    Raises:
        ModelError: the alignment moves a frame of the nominal machine, so that without it positions mean another place.
    """
    free = [joint for joint in spec.joints if joint.type == mujoco.mjtJoint.mjJNT_FREE]
    if not (spec.compiler.alignfree or any(joint.align == mujoco.mjtAlignFree.mjALIGNFREE_TRUE for joint in free)):
        return
    aligned = compiled(spec.copy())
    spec.compiler.alignfree = False
    for joint in free:
        joint.align = mujoco.mjtAlignFree.mjALIGNFREE_FALSE
    plain = compiled(spec.copy())
    moved = [
        plain.body(row).name
        for row in range(plain.nbody)
        for field in ("body_pos", "body_quat")
        if not np.allclose(getattr(aligned, field)[row], getattr(plain, field)[row], atol=_SAME)
    ]
    if moved:
        raise ModelError(
            f"MuJoCo moves the frame of {', '.join(dict.fromkeys(moved))} into its centre of mass (compiler alignfree, "
            "freejoint align), which other masses would move again, and with it what its positions mean. Take the "
            "attribute out of the MJCF, and log positions of the frame as the file has it, or save the file as MuJoCo "
            'compiles it (compiler savecompiled="true").'
        )


def _write_out_gains(spec: mujoco.MjSpec) -> None:
    """Give servos with a ``dampratio`` their kv, and muscles without a ``force`` theirs, as MuJoCo makes them.

    MuJoCo computes both whenever it compiles, of the inertia that it finds then. But a controller keeps its gain, and a
    muscle its strength, whatever it is that they carry.
    Source: MuJoCo 4.0, XML reference, actuator/position/dampratio and actuator/muscle (force, scale).
    """
    servos = [each for each in spec.actuators if each.gainprm[0] == -each.biasprm[1] != 0.0 < each.biasprm[2]]
    muscles = [each for each in spec.actuators if each.gaintype == mujoco.mjtGain.mjGAIN_MUSCLE]
    if not servos and not muscles:
        return
    model = compiled(spec.copy())
    for servo in servos:
        servo.biasprm[2] = model.actuator(servo.name).biasprm[2]
    for muscle in muscles:
        acceleration = float(model.actuator(muscle.name).acc0[0])  # by a unit of force
        passive = muscle.biastype == mujoco.mjtBias.mjBIAS_MUSCLE
        for law in (muscle.gainprm, muscle.biasprm) if passive else (muscle.gainprm,):
            force, scale = law[2:4]
            law[2] = force if force >= 0 else scale / max(acceleration, mujoco.mjMINVAL)
