"""One small machine for each type of actuator, tendon and equality of MuJoCo, and logs that it makes itself."""

import mujoco
import numpy as np

from dr_lab.physics.model import Model
from dr_lab.trajectory import Array, Log, Signal
from tests.diagnosis_machines import clock, log_of, model_of

NOISE = 2e-4  # rad or m
_STEP = 0.002  # s
_ROD = '<inertial mass="0.5" pos="0 0 -0.3" diaginertia="0.005 0.005 0.001"/>'
_ROD_ON = f'{_ROD}<joint name="hinge" axis="0 1 0" damping="0.05"/>'
_ARM = f'<body name="rod">{_ROD_ON}<site name="tip" pos="0 0 -0.5"/></body>'
_TWO = f"""<body name="rod">{_ROD_ON}<site name="tip" pos="0 0 -0.5"/>
  <body name="second" pos="0 0 -0.5">{_ROD}<joint name="elbow" axis="0 1 0" damping="0.05"/></body></body>"""
_BESIDE = f"""{_ARM}<body name="second" pos="0.2 0 0">{_ROD}<joint name="elbow" axis="0 1 0" damping="0.05"/>
  </body>"""
_ANCHOR = '<site name="wall" pos="0.3 0 -0.2"/>'
_COUPLED = """<tendon><fixed name="band" {0}><joint joint="hinge" coef="1"/><joint joint="elbow" coef="-0.5"/></fixed>
  </tendon>"""
_PLATE = """<geom name="floor" type="plane" size="2 2 0.1" friction="0.4"/><body name="rod" pos="0 0 0.0499">
  <joint name="hinge" type="slide" axis="1 0 0" damping="1"/><joint name="lift" type="slide" axis="0 0 1"/>
  <geom name="plate" type="box" size="0.1 0.1 0.05" mass="0.5"/></body>"""
_MOTOR = '<motor name="drive" joint="hinge"/>'
_DC = '<dcmotor name="drive" joint="hinge" gear="5" resistance="2" motorconst="0.1" {0}/>'

# name -> (bodies, actuators, what else the file has); commands are random steps within ±1 unless `_COMMANDS` says.
_MACHINES: dict[str, tuple[str, str, str]] = {
    "motor": (_ARM, _MOTOR, ""),
    "motor_delay": (_ARM, '<motor name="drive" joint="hinge" delay="0.021" nsample="12"/>', ""),
    "position": (_ARM, '<position name="drive" joint="hinge" kp="8" kv="0.3"/>', ""),
    "position_timeconst": (_ARM, '<position name="drive" joint="hinge" kp="8" kv="0.3" timeconst="0.05"/>', ""),
    "position_slow": (_ARM, '<position name="drive" joint="hinge" kp="8" kv="0.3" timeconst="0.4"/>', ""),
    "velocity": (_ARM, '<velocity name="drive" joint="hinge" kv="1"/>', ""),
    "intvelocity": (_ARM, '<intvelocity name="drive" joint="hinge" kp="8" kv="0.3" actrange="-2 2"/>', ""),
    "damper": (_ARM, '<damper name="drive" joint="hinge" kv="0.5" ctrlrange="0 1"/>', ""),
    "cylinder": (_ARM, '<cylinder name="drive" joint="hinge" timeconst="0.08" area="1" bias="0 0 -0.1"/>', ""),
    "cylinder_slow": (_ARM, '<cylinder name="drive" joint="hinge" area="2"/>', ""),
    "muscle": (
        _ARM + _ANCHOR,
        '<muscle name="drive" tendon="cord" force="8" lengthrange="0.2 0.9"/>',
        '<tendon><spatial name="cord"><site site="wall"/><site site="tip"/></spatial></tendon>',
    ),
    "adhesion": (
        _PLATE,
        '<motor name="drive" joint="hinge" gear="4"/><adhesion name="stick" body="rod" ctrlrange="0 1" gain="3"/>',
        "",
    ),
    "filter": (_ARM, '<general name="drive" joint="hinge" dyntype="filter" dynprm="0.03"/>', ""),
    "filterexact": (_ARM, '<general name="drive" joint="hinge" dyntype="filterexact" dynprm="0.06"/>', ""),
    "actearly": (_ARM, '<general name="drive" joint="hinge" dyntype="filterexact" dynprm="0.04" actearly="true"/>', ""),
    "integrator": (_ARM, '<general name="drive" joint="hinge" dyntype="integrator" gainprm="3"/>', ""),
    "user": (_ARM, '<general name="drive" joint="hinge" dyntype="user" actdim="1"/>', ""),
    "dcmotor": (_ARM, _DC.format(""), ""),
    "dcmotor_inductance": (_ARM, _DC.format('inductance="0.04 0"'), ""),
    "dcmotor_friction": (_ARM, _DC.format('lugre="20 0.1 0.02 0.03 0.1"'), ""),
    "dcmotor_thermal": (_ARM, _DC.format('thermal="10 5 0 0.004 25 25"'), ""),
    "dcmotor_controller": (_ARM, _DC.format('input="pos" controller="3 2 0.1 4 0 0" inductance="0.02 0"'), ""),
    "pid": (_ARM, '<pid name="drive" joint="hinge" kp="8" kv="0.3" ki="10"/>', ""),
    "pid_slew": (_ARM, '<pid name="drive" joint="hinge" kp="8" kv="0.3" slewmax="3"/>', ""),
    "crank": (
        _ARM + '<body name="rail" pos="0.1 0 -0.8"><site name="slider" pos="0 0 0" zaxis="0 0 1"/></body>',
        '<motor name="drive" cranksite="tip" slidersite="slider" cranklength="0.4" gear="2"/>',
        "",
    ),
    "jet": (_ARM, '<motor name="drive" site="tip" gear="1 0 0 0 0 0"/>', ""),
    "tendon_fixed": (
        _TWO,
        '<motor name="drive" tendon="band"/>',
        _COUPLED.format('stiffness="2" damping="0.05" springlength="0.1" frictionloss="0.02" armature="0.01"'),
    ),
    "tendon_spatial": (
        _ARM + _ANCHOR,
        _MOTOR,
        """<tendon><spatial name="cord" stiffness="10" damping="0.2" springlength="0.3"><site site="wall"/>
          <site site="tip"/></spatial></tendon>""",
    ),
    "tendon_friction": (
        _ARM + _ANCHOR,
        _MOTOR,
        """<tendon><spatial name="cord" frictionloss="0.3"><site site="wall"/><site site="tip"/></spatial></tendon>""",
    ),
    "tendon_limit": (_TWO, _MOTOR, _COUPLED.format('limited="true" range="-0.4 0.4"')),
    "equality_joint": (
        _BESIDE,
        _MOTOR,
        '<equality><joint joint1="hinge" joint2="elbow" polycoef="0 0.8 0 0 0" solref="0.05 1"/></equality>',
    ),
    "equality_connect": (
        _BESIDE,
        _MOTOR,
        '<equality><connect body1="rod" body2="second" anchor="0.1 0 -0.5" solref="0.05 1"/></equality>',
    ),
    "equality_weld": (
        _TWO,
        _MOTOR,
        '<equality><weld body1="rod" body2="second" solref="0.1 0.5"/></equality>',
    ),
    "equality_tendon": (
        _TWO,
        _MOTOR,
        _COUPLED.format("") + '<equality><tendon tendon1="band" polycoef="0.1 0 0 0 0" solref="0.05 1"/></equality>',
    ),
}
_COMMANDS = {"damper": (0.0, 1.0), "muscle": (0.0, 1.0), "dcmotor": (-6.0, 6.0)}
NAMES = tuple(_MACHINES)


def machine(name: str, integrator: str = "implicitfast") -> Model:
    """A machine by name."""
    bodies, actuators, rest = _MACHINES[name]
    return model_of(
        f"""<mujoco model="{name}"><compiler angle="radian"/><option timestep="{_STEP}" integrator="{integrator}"/>
        <worldbody>{bodies}</worldbody>{rest}<actuator>{actuators}</actuator></mujoco>"""
    )


def own_log(model: Model, seed: int, seconds: float = 4.0, noise: float = NOISE) -> Log:
    """A noisy log of the machine's joints under random steps of every command, begun at rest in its reference."""
    compiled, rng = model.nominal(), np.random.default_rng(seed)
    low, high = _COMMANDS.get(model.name.split("_")[0] if "controller" not in model.name else "", (-1.0, 1.0))
    times = np.arange(0.0, seconds, 0.14)
    commands = {}
    for i in range(compiled.nactuator):
        limits = compiled.actuator_ctrlrange[compiled.actuator_ctrladr[i]]
        least, most = limits if limits.any() else (low, high)
        values, name = rng.uniform(least, most, len(times)), compiled.actuator(i).name
        commands[name] = Signal(name, "", times, values)
    time, qpos = _motion(compiled, commands, round(seconds / compiled.opt.timestep))
    outputs = {
        f"{compiled.joint(i).name}.position": (time, qpos[:, i] + noise * rng.normal(size=len(time)))
        for i in range(compiled.njnt)
        if compiled.joint(i).name != "lift"
    }
    log = log_of(f"own_{seed}", outputs)
    return Log(log.name, log.outputs, commands)


def _motion(compiled: mujoco.MjModel, commands: dict[str, Signal], steps: int) -> tuple[Array, Array]:
    data, rows, step = mujoco.MjData(compiled), [], compiled.opt.timestep
    for k in range(steps):
        for name, signal in commands.items():
            held = signal.value[np.searchsorted(signal.time, k * step + 1e-9, side="right") - 1]
            data.ctrl[compiled.actuator_ctrladr[compiled.actuator(name).id]] = held
        rows.append(data.qpos.copy())
        mujoco.mj_step(compiled, data)
    return clock(steps, step), np.array(rows)
