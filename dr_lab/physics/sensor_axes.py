"""One axis of a sensor that reports a vector: logs often hold one axis of a gyroscope or an accelerometer."""

import mujoco

AXES = ("x", "y", "z")


def sensor_axes(model: mujoco.MjModel) -> dict[str, tuple[int, int]]:
    """Index of the sensor and of the axis, by ``<sensor>.<axis>``, of all named sensors of three numbers.

    A sensor that the model itself calls so comes first.
    """
    named = {model.sensor(i).name: i for i in range(model.nsensor) if model.sensor(i).name}
    vectors = [(name, i) for name, i in named.items() if int(model.sensor_dim[i]) == len(AXES)]
    axes = {f"{name}.{axis}": (i, k) for name, i in vectors for k, axis in enumerate(AXES)}
    return {name: place for name, place in axes.items() if name not in named}
