"""Random streams that are keyed by what they are for, so that adding one draw never shifts another."""

import zlib

import numpy as np

from dr_lab.errors import ConfigError


def stream(seed: int, *keys: str | int) -> np.random.Generator:
    """An independent random generator for one purpose.

    The same seed and keys give the same numbers on every machine, in whatever order streams are made.

    Args:
        seed: the experiment's seed, ≥ 0.
        keys: what the numbers are for, e.g. ``("truth", "arm.mass")`` or ``("log_1", "excitation")``.

    Returns:
        NumPy's PCG64 generator seeded by the seed and the keys.

    Raises:
        ConfigError: the seed is negative.
    """
    if seed < 0:
        raise ConfigError(f"seed is {seed}; expected an integer of at least 0.")
    words = [zlib.crc32(str(key).encode()) for key in keys]
    return np.random.default_rng([seed, *words])


def derived_seed(seed: int, *keys: str | int) -> int:
    """The seed, below 2³¹, of a generator that is not NumPy's; arguments and errors as `stream`.

    A sum such as ``seed + 1`` would give the next experiment the same numbers.
    """
    return int(stream(seed, *keys).integers(2**31))
