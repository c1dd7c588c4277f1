"""What the words of names say: quantities and units, in the languages that logs were seen in."""

import re
from typing import Literal

Kind = Literal["position", "velocity", "drive", "reference", "asked velocity", "other", ""]

# Units as the last words of a name, the longest first, with the quantity that they say.
UNITS: tuple[tuple[tuple[str, ...], str, Kind], ...] = (
    (("rad", "per", "s"), "rad/s", "velocity"),
    (("deg", "per", "s"), "deg/s", "velocity"),
    (("rad", "s", "2"), "rad/s^2", "other"),
    (("m", "s", "2"), "m/s^2", "other"),
    (("rad", "s"), "rad/s", "velocity"),
    (("mrad", "s"), "mrad/s", "velocity"),
    (("rads",), "rad/s", "velocity"),
    (("deg", "s"), "deg/s", "velocity"),
    (("mm", "s"), "mm/s", "velocity"),
    (("m", "s"), "m/s", "velocity"),
    (("radps",), "rad/s", "velocity"),
    (("dps",), "deg/s", "velocity"),
    (("mmps",), "mm/s", "velocity"),
    (("mps",), "m/s", "velocity"),
    (("rpm",), "rpm", "velocity"),
    (("1", "min"), "rpm", "velocity"),
    (("u", "min"), "rpm", "velocity"),
    (("rev", "min"), "rpm", "velocity"),
    (("m", "nm"), "mN·m", "drive"),
    (("mnm",), "mN·m", "drive"),
    (("n", "m"), "N·m", "drive"),
    (("nm",), "N·m", "drive"),
    (("newton",), "N", "drive"),
    (("mv",), "mV", "drive"),
    (("m", "v"), "mV", "drive"),
    (("volt",), "V", "drive"),
    (("volts",), "V", "drive"),
    (("v",), "V", "drive"),
    (("ma",), "mA", "drive"),
    (("m", "a"), "mA", "drive"),
    (("amp",), "A", "drive"),
    (("a",), "A", "drive"),
    (("n",), "N", "drive"),
    (("rad",), "rad", "position"),
    (("mrad",), "mrad", "position"),
    (("deg",), "deg", "position"),
    (("degrees",), "deg", "position"),
    (("grad",), "deg", "position"),
    (("turn",), "turn", "position"),
    (("turns",), "turn", "position"),
    (("rev",), "turn", "position"),
    (("um",), "um", "position"),
    (("mm",), "mm", "position"),
    (("cm",), "cm", "position"),
    (("m",), "m", "position"),
)
# Units that are a whole name.
ALONE = {"rpm", "dps", "mps", "mmps", "radps", "rads", "deg", "degrees", "grad", "rad", "mrad"}
VELOCITY = {
    *("vel", "vels", "velocity", "velocities", "dot", "qd", "dq", "qvel", "speed", "omega", "rate"),
    *("drehzahl", "geschwindigkeit", "velocidad", "vitesse"),
}
SUPPLY = re.compile(r"dc(bus|link)|[uv](bus|batt?|dc)(?![a-z])")  # of words without what is between them: DCbus, Vbat
OTHER = {
    *("acc", "accel", "acceleration", "accelerations", "qdd", "ddq", "error", "errors", "temperature", "temp"),
    *("cell", "loadcell", "bus", "battery", "supply", "mains"),  # forces and voltages that drive nothing
    *("index", "frame", "count", "id", "episode", "task", "done", "reward", "time", "timestamp", "stamp", "seq"),
}
REFERENCE = {
    *("ref", "reference", "referencia", "des", "desired", "target", "goal", "setpoint", "soll", "sollwert", "set"),
    *("cmd", "command", "commands", "commanded", "action", "ctrl", "control", "controls", "con", "input"),
    *("demand", "demanded"),
}
MEASURED = {"state", "states", "feedback", "actual", "meas", "measured", "ist", "istwert"}
DRIVE = {
    *("tau", "taus", "torque", "torques", "effort", "efforts", "force", "forces", "voltage", "duty", "pwm", "current"),
    *("u", "motor", "act", "strom", "spannung", "drehmoment", "moment", "kraft"),
    *("corriente", "voltaje", "courant"),
}
POSITION = {
    *("pos", "position", "positions", "q", "qpos", "angle", "angles", "theta", "phi", "psi", "alpha", "beta", "state"),
    *("x", "y", "z", "enc", "encoder", "encoders", "joints", "winkel", "weg", "angulo", "posicion"),
}
# Words of drives that are also said of what is measured, with the words they then go with: pos_act, current position.
PRESENT: dict[str, set[str]] = {
    "act": POSITION - {"x", "y", "z", "state", "joints"},
    "current": {"pos", "position", "positions", "qpos", "angle", "angles"},
}
ELECTRIC = {"current": "A", "voltage": "V", "strom": "A", "spannung": "V"}
TORQUE_CURRENT = ("i", "q")  # of a motor that is driven by field orientation
# Single letters that are units, with the words of quantities that are measured in them.
LETTERS: dict[str, set[str]] = {
    "a": {"current", "strom", "i", "u"},
    "v": {"voltage", "spannung", "pwm", "u"},
    "n": {"force", "forces", "kraft", "effort", "efforts", "u"},
    "m": POSITION - {"angle", "angles", "theta", "phi", "psi", "alpha", "beta"},
}

AXES = {"x", "y", "z"}
GENERIC = {
    *("joint", "joints", "j", "link", "meas", "measured", "actual", "observation", "raw", "est", "estimated", "data"),
    *("main", "states", "feedback", "applied", "per", "s", "values", "controller", "position", "velocity", "group"),
}
UNTELLING = (
    GENERIC
    | VELOCITY
    | REFERENCE
    | OTHER
    | DRIVE
    | MEASURED
    | {"pos", "positions", "q", "qpos", "angle", "winkel", "weg", "angulo", "posicion", "°"}
)
