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
    _write_out_damping(spec)
    return spec


def _write_out_damping(spec: mujoco.MjSpec) -> None:
    """Give servos that have a ``dampratio`` the kv that MuJoCo makes of it.

    MuJoCo computes kv whenever it compiles, of kp and the inertia that it finds then. But a controller keeps its gain,
    whatever it is that it carries.
    Source: MuJoCo 4.0, XML reference, actuator/position/dampratio.
    """
    by_ratio = [each for each in spec.actuators if each.gainprm[0] == -each.biasprm[1] != 0.0 < each.biasprm[2]]
    if by_ratio:
        model = compiled(spec.copy())
        for servo in by_ratio:
            servo.biasprm[2] = model.actuator(servo.name).biasprm[2]
