"""What was typed for jobs, and what of it tells them apart."""

from collections.abc import Mapping, Sequence


def by_key(overrides: Sequence[str]) -> dict[str, str]:
    """Values of overrides by their keys.

    Args:
        overrides: ``key=value``, or ``+key=value``; of ``~key`` the value is empty.
    """
    pairs = (override.lstrip("+").partition("=") for override in overrides)
    return {key: value for key, _, value in pairs}


def differing(jobs: Sequence[Mapping[str, str]]) -> list[str]:
    """Keys that not all jobs have with the same value, in the order in which they were typed.

    Args:
        jobs: overrides of each, by key.
    """
    keys = dict.fromkeys(key for job in jobs for key in job)
    return [key for key in keys if len({job.get(key) for job in jobs}) > 1]
