"""What was typed for jobs, and what of it tells them apart."""

import re
from collections.abc import Mapping, Sequence

_NESTED = re.compile(r"((?:\{[^{}:,\s]+:)+)([^{},]*)(\}+)")


def by_key(overrides: Sequence[str]) -> dict[str, str]:
    """Values of overrides by their keys.

    Args:
        overrides: ``key=value``, or ``+key=value``; of ``~key`` the value is empty. ``key={name:{name:value}}``, as
            Hydra wants a name that holds a dot, counts as ``key.name.name=value``.
    """
    pairs = (override.lstrip("+").partition("=") for override in overrides)
    return dict(_flat(key, value) for key, _, value in pairs)


def _flat(key: str, value: str) -> tuple[str, str]:
    nested = _NESTED.fullmatch(value)
    if nested is None or nested[1].count("{") != len(nested[3]):
        return key, value
    return ".".join([key, *nested[1].strip("{:").split(":{")]), nested[2]


def differing(jobs: Sequence[Mapping[str, str]]) -> list[str]:
    """Keys that not all jobs have with the same value, in the order in which they were typed.

    Args:
        jobs: overrides of each, by key.
    """
    keys = dict.fromkeys(key for job in jobs for key in job)
    return [key for key in keys if len({job.get(key) for job in jobs}) > 1]
