"""What a channel's name tells: ``<joint>.position``, ``<joint>.velocity``, ``sensor.<name>``, or an actuator's name."""

POSITION, VELOCITY = "position", "velocity"
_SENSOR = "sensor."


def is_sensor(name: str) -> bool:
    """Whether it is a sensor's channel, or one axis of it, whatever the sensor is called."""
    return name.startswith(_SENSOR)


def quantity(name: str) -> str:
    """What is measured at a joint, ``position`` or ``velocity``; ``""`` for any other channel.

    A sensor may be called so as well: ``sensor.position`` is no joint's.
    """
    last = name.rpartition(".")[2]
    return last if last in (POSITION, VELOCITY) and not is_sensor(name) else ""


def sensor_of(name: str) -> str:
    """The sensor of a channel that `is_sensor`, with its axis."""
    return name.removeprefix(_SENSOR)


def joint_of(name: str) -> str:
    """The joint of a channel that has a `quantity`."""
    return name.rpartition(".")[0]
