"""MuJoCo's own stopwatch."""

import ctypes
import sys
from contextlib import suppress

import mujoco


def stop_timers() -> None:
    """Take MuJoCo's clock away for this process; `mujoco.set_mjcb_time(None)` gives it back.

    The Python bindings install a clock, which every stage of every step reads twice to fill `MjData.timer`; of a small
    machine that is a third of the time. MuJoCo without a clock calls no timing function (MuJoCo 4.0, simulation
    chapter, "Diagnostics"). The bindings can exchange the clock but not clear it, so it is cleared in the library that
    they are linked against.
    """
    bindings = ctypes.CDLL(sys.modules[mujoco.MjModel.__module__].__file__)
    with suppress(ValueError):  # where a module does not show its libraries' symbols the clock goes on: only slower
        ctypes.c_void_p.in_dll(bindings, "mjcb_time").value = None
