"""A controlled machine: the commands that its controller gave, played back, move it in the same way."""

import numpy as np
from plant_machines import TIGHT, samples

from dr_lab.plants.command import Command
from dr_lab.plants.drive import ForceDrive
from dr_lab.plants.hidden.actuator_delay import ActuatorDelay
from dr_lab.plants.hidden.both import Both
from dr_lab.plants.hidden.coulomb_friction import CoulombFriction
from dr_lab.plants.hidden.no_effect import NoEffect
from dr_lab.plants.hidden.saturation import Saturation
from dr_lab.plants.moments import Moments
from dr_lab.plants.motion import simulate
from dr_lab.plants.operator import Experiment
from dr_lab.plants.pendulum import Pendulum
from dr_lab.plants.servo import Servo

PENDULUM = Pendulum(
    links=(Moments.rod(0.5, 0.4),),
    damping=(0.0,),
    armature=(0.0,),
    gravity=(0.0, 0.0, -9.81),
    drives=(ForceDrive(),),
)
SERVO = Servo(stiffness={"pendulum": 20.0}, damping={"pendulum": 1.0})


def test_playing_the_commands_back_repeats_the_motion() -> None:
    issued, time = np.arange(0.001, 0.6, 0.004), samples(0.6)
    wish = 0.5 * np.sin(7.0 * issued)[:, None]
    effect = Both(Both(ActuatorDelay(0.007), Saturation(1.5)), CoulombFriction("pendulum", 0.1))
    run = Experiment(PENDULUM, effect, PENDULUM, issued, 0.0005, time, (0.2, 0.0), TIGHT)
    states, command = SERVO.operate(run, wish)
    assert np.abs(command).max() > 1.5
    played = [Command(issued + 0.0005, command[:, 0])]
    again = simulate(PENDULUM, effect, played, time, accuracy=TIGHT, start=(0.2, 0.0))
    np.testing.assert_allclose(states, again, rtol=0, atol=1e-9)


def test_gravity_is_held_where_the_machine_is_as_documented() -> None:
    issued, time = np.arange(0.0, 2.0, 0.004), np.array([2.0])
    run = Experiment(PENDULUM, NoEffect(), PENDULUM, issued, 0.0, time, (1.0, 0.0), TIGHT)
    states, command = SERVO.operate(run, np.zeros((len(issued), 1)))
    np.testing.assert_allclose(states[0], (1.0, 0.0), rtol=0, atol=1e-9)
    np.testing.assert_allclose(command, 0.5 * 0.2 * 9.81 * np.sin(1.0), rtol=1e-9)
