"""A spec whose elements stay what they are, whatever a context makes of others."""

import mujoco

from dr_lab.physics.compiling import compiled
from dr_lab.physics.naming import name_elements


def settled(spec: mujoco.MjSpec) -> mujoco.MjSpec:
    """A copy of a spec that compiles to the same machine, in which nothing changes with what a parameter varies.

    Every body, joint, actuator and sensor has a name. Bodies that are welded together stay apart: where MuJoCo fuses
    them (``fusestatic``, as it does with a URDF), one would have the inertia of the others, and these no names.
    Nothing sleeps (``flag/sleep``), for batches forget between two calls what does.
    """
    spec = spec.copy()
    name_elements(spec)
    spec.compiler.fusestatic = False
    spec.option.enableflags &= ~int(mujoco.mjtEnableBit.mjENBL_SLEEP)
    _write_out_gains(spec)
    return spec


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
