"""Compiling a spec."""

import warnings
from collections.abc import Iterator
from contextlib import contextmanager

import mujoco


def compiled(spec: mujoco.MjSpec) -> mujoco.MjModel:
    """The compiled spec, without MuJoCo's notice that ``settotalmass`` is old: files of others still use it.

    Raises:
        ValueError: it does not compile.
    """
    with _unnoticed():
        return spec.compile()


def written(spec: mujoco.MjSpec) -> str:
    """The spec, compiled, as MJCF text, without that notice.

    Raises:
        ValueError: it does not compile.
    """
    with _unnoticed():
        spec.compile()
        return spec.to_xml()


@contextmanager
def _unnoticed() -> Iterator[None]:
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "compiler attribute 'settotalmass'", UserWarning)
        yield
