"""Machines and commands that several tests of the plants use."""

import math
from dataclasses import replace

import numpy as np

from dr_lab.plants.command import Command
from dr_lab.plants.drive import Motor
from dr_lab.plants.furuta import Furuta
from dr_lab.plants.moments import Moments
from dr_lab.plants.motion import Accuracy
from dr_lab.trajectory import Array

TIGHT = Accuracy(relative=1e-12, absolute=1e-13, longest_step=0.005)
MOTOR = Motor(constant=0.042, resistance=8.4)
QUBE = Furuta(
    links=(Moments.rod(0.095, 0.085), Moments.rod(0.024, 0.129)),
    length=0.085,
    damping=(1e-4, 5e-5),
    armature=(0.0, 0.0),
    gravity=(0.0, 0.0, -9.81),
    drives=(MOTOR,),
)
UNPLUGGED = replace(MOTOR, constant=0.0)
# Without motor and damping nothing takes energy out.
LOSSLESS = replace(QUBE, damping=(0.0, 0.0), drives=(UNPLUGGED,))
WEIGHTLESS = Moments(0.0, 0.0, 0.0)
# A pole without mass but with a rotor: the arm turns alone.
ARM_ALONE = replace(LOSSLESS, links=(QUBE.links[0], WEIGHTLESS), armature=(0.0, 1.0))
# An arm that nothing moves: the pole swings alone.
POLE_ALONE = replace(LOSSLESS, armature=(1e9, 0.0))


def no_command() -> Command:
    return Command(np.array([0.0]), np.array([0.0]))


def lively_command(duration: float) -> Command:
    """Sines held for 4 ms each, up to 6 V."""
    edge = np.arange(0.001, duration, 0.004)
    wave = 3.0 * np.sin(8.0 * edge) + 2.0 * np.sin(19.0 * edge + 1.0) + 1.5 * np.sin(3.0 * edge + 2.0)
    return Command(edge, np.clip(wave, -6.0, 6.0))


def samples(duration: float) -> Array:
    return np.arange(0.0, duration, 0.002)


def angular_frequency(machine: Furuta) -> float:
    """ω of the hanging pole's small swings with a free arm: ω² = S g / (J − (L S)² / M_θθ)."""
    (around, across), (_, pole) = machine.mass((0.0, 0.0))
    return math.sqrt(-machine.links[1].first * machine.gravity[2] / (pole - across**2 / around))
