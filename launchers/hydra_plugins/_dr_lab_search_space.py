"""Hydra's notation for values to sweep over as Optuna's search space."""

from collections.abc import Mapping, Sequence

from hydra.core.override_parser.types import IntervalSweep, Override, RangeSweep
from optuna.distributions import BaseDistribution, CategoricalDistribution, FloatDistribution, IntDistribution

from dr_lab.errors import ConfigError

LOG = "log"


def search_space(overrides: Sequence[Override]) -> dict[str, BaseDistribution]:
    """What may be tried, by key.

    ``interval(a,b)`` is any number between, ``int(interval(a,b))`` any whole one, ``range(a,b,step)`` one of its
    numbers, ``choice(a,b)``, ``a,b`` or ``glob(*)`` one of these; ``tag(log,interval(a,b))`` and
    ``tag(log,range(a,b))`` draw on a logarithmic scale.

    Args:
        overrides: of the command line and the configuration.

    Raises:
        ConfigError: none of them leaves a choice, or one cannot be drawn from.
    """
    space = {o.get_key_element(): _sound(o) for o in overrides if o.is_sweep_override()}
    if not space:
        raise ConfigError(
            "A study needs something to try: hparams_search=NAME, or values on the command line, "
            "e.g. 'algorithm.gamma=interval(0.9,0.999)'."
        )
    return space


def _sound(override: Override) -> BaseDistribution:
    try:
        return _distribution(override)
    except ValueError as error:
        raise ConfigError(f"A study cannot draw from {override.input_line}: {error}") from error


def _distribution(override: Override) -> BaseDistribution:
    sweep = override.value()
    log = LOG in getattr(sweep, "tags", ())
    if isinstance(sweep, IntervalSweep) and sweep.start is not None and sweep.end is not None:
        if isinstance(sweep.start, int) and isinstance(sweep.end, int):
            return IntDistribution(sweep.start, sweep.end, log=log)
        return FloatDistribution(float(sweep.start), float(sweep.end), log=log)
    if isinstance(sweep, RangeSweep):
        numbers = sorted(sweep.range())
        if not numbers:
            raise ValueError("it holds no number.")
        if all(isinstance(number, int) for number in numbers):
            return IntDistribution(int(numbers[0]), int(numbers[-1]), log, abs(int(sweep.step)))
        return FloatDistribution(float(numbers[0]), float(numbers[-1]), log, abs(float(sweep.step)))
    if log:
        raise ValueError("log belongs to an interval(a,b) or a range(a,b) of whole numbers.")
    return CategoricalDistribution(list(override.sweep_string_iterator()))


def corners(space: Mapping[str, BaseDistribution]) -> list[dict[str, object]]:
    """Points of a search space in which every choice and every bound occurs.

    Args:
        space: what may be tried, by key.
    """
    extremes = {key: _extremes(distribution) for key, distribution in space.items()}
    count = max(map(len, extremes.values()))
    return [{key: values[min(at, len(values) - 1)] for key, values in extremes.items()} for at in range(count)]


def _extremes(distribution: BaseDistribution) -> Sequence[object]:
    if isinstance(distribution, CategoricalDistribution):
        return distribution.choices
    assert isinstance(distribution, FloatDistribution | IntDistribution)
    return (distribution.low, distribution.high)
