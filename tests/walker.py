"""A body on two legs of two joints each, which stands and walks on a plane; only MuJoCo knows where it is."""

import mujoco
import numpy as np

from dr_lab.trajectory import Array

_LEG = """<body name="{0}_thigh" pos="{1} 0 0"><inertial mass="0.5" pos="0 0 -0.1" diaginertia="2e-3 2e-3 3e-4"/>
  <joint name="{0}_hip" axis="0 1 0" damping="0.2" armature="0.01"/>
  <body name="{0}_shin" pos="0 0 -0.2"><inertial mass="0.2" pos="0 0 -0.1" diaginertia="1e-3 1e-3 1e-4"/>
    <joint name="{0}_knee" axis="0 1 0" damping="0.2" armature="0.01"/>
    <geom name="{0}_foot" type="{2}" size="0.02 0.15" pos="0 0 -0.2" euler="90 0 0" contype="1" conaffinity="2"/>
  </body></body>"""
MJCF = """<mujoco model="walker"><option timestep="0.001" integrator="implicitfast"/>
<worldbody><geom name="floor" type="plane" size="9 9 0.1" contype="2" conaffinity="1"/>
  <body name="trunk" pos="0 0 0.6"><freejoint name="base"/>
    <inertial mass="5" pos="0 0 0" diaginertia="0.05 0.05 0.05"/>{}</body></worldbody>
<actuator>{}</actuator>
<sensor><framequat name="turn" objtype="xbody" objname="trunk"/></sensor></mujoco>"""
JOINTS = tuple(f"{leg}_{joint}" for leg in ("front", "hind") for joint in ("hip", "knee"))


def walker(foot: str = "capsule") -> str:
    """MJCF of the machine, whose servos hold its joints."""
    legs = "".join(_LEG.format(name, x, foot) for name, x in (("front", 0.2), ("hind", -0.2)))
    servos = "".join(f'<position name="{j}" joint="{j}" kp="80" kv="2"/>' for j in JOINTS)
    return MJCF.format(legs, servos)


def walked(seconds: float = 2.0) -> tuple[mujoco.MjModel, Array, Array]:
    """The model, and positions and velocities every 20 ms once it has settled."""
    model = mujoco.MjModel.from_xml_string(walker())
    data, found = mujoco.MjData(model), list[tuple[Array, Array]]()
    for k in range(round(seconds / model.opt.timestep)):
        swing = 0.15 * np.sin(2 * np.pi * 1.0 * data.time)
        data.ctrl[:] = [0.5 + swing, -1.0, 0.5 - swing, -1.0]
        mujoco.mj_step(model, data)
        if data.time > 1.0 and k % 20 == 0:
            found.append((data.qpos.copy(), data.qvel.copy()))
    qpos, qvel = (np.array(part) for part in zip(*found, strict=True))
    return model, qpos, qvel
