"""Evaluations, told apart by how their policies were trained instead of by the folders that these lie in."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml

from dr_lab.summaries.configuration import experiment
from dr_lab.sweeps.overrides import by_key

TRAINED = "trained"  # key of an evaluation's configuration below which that of the training then stands
_FOLDER = "run"  # override that names the folder
_CONFIG = "config.yaml"


def of_training(
    trained: str, overrides: Mapping[str, str], configuration: Mapping[str, Any]
) -> tuple[Mapping[str, str], Mapping[str, Any]]:
    """Overrides and configuration of an evaluation with those of the training in place of its folder.

    So evaluations of policies that differ in nothing but the seed of their training are alike but for ``trained.seed``.

    Args:
        trained: folder of the training run; where it is gone, or no longer says how it was made, it stands for itself.
        overrides: of the evaluation.
        configuration: of the evaluation.
    """
    own = {key: value for key, value in overrides.items() if key != _FOLDER}
    kept = {key: value for key, value in configuration.items() if key not in (_FOLDER, TRAINED)}
    try:
        training = yaml.safe_load((Path(trained) / _CONFIG).read_text(encoding="utf-8"))
        typed = by_key([str(override) for override in training["made_with"]["overrides"]])
    except (OSError, ValueError, yaml.YAMLError, TypeError, KeyError):
        return own | {TRAINED: trained}, kept | {TRAINED: trained}
    return own | {f"{TRAINED}.{key}": value for key, value in typed.items()}, kept | {TRAINED: experiment(training, ())}


def with_trained(keys: Sequence[str]) -> list[str]:
    """Keys as they stand in a run's configuration, and in that of the training which an evaluation holds."""
    return [*keys, *(f"{TRAINED}.{key}" for key in keys)]
