"""Compiling a spec."""

import warnings

import mujoco


def compiled(spec: mujoco.MjSpec) -> mujoco.MjModel:
    """The compiled spec, without MuJoCo's notice that ``settotalmass`` is old: files of others still use it.

    Raises:
        ValueError: it does not compile.
    """
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "compiler attribute 'settotalmass'", UserWarning)
        return spec.compile()
