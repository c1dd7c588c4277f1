"""What lies between the physics and the log: readings of channels, and commands on their way to actuators."""

from collections.abc import Callable

from dr_lab.trajectory import Array

Reading = Callable[[Array], Array]
"""Values of one channel for c contexts × w windows: times in s after the windows' start, shape (c or 1, w, m), to
values, shape (c, w, m, size)."""
