"""The fitted context that a run leaves: `context.yaml`, which `fit`, `add`, `close` and `train` (a Gaussian) write."""

from pathlib import Path

import numpy as np
import yaml

from dr_lab.errors import ConfigError
from dr_lab.physics.context import ContextEstimate, ContextSpace
from dr_lab.physics.parameter import Parameter

FILE = "context.yaml"
SCHEMA = "dr_lab/context/1"


def read_context(run: str | Path) -> ContextEstimate:
    """What a run knows about the context of its model.

    Args:
        run: the run folder, or its `context.yaml`.

    Raises:
        ConfigError: there is no such file, or it is not a fitted context.
    """
    given = Path(run).expanduser()
    path = given / FILE if given.is_dir() else given
    remedy = "Give the folder of a run of dr-lab close, add or fit, or of a training that learnt a Gaussian."
    if not given.exists():
        raise ConfigError(f"There is no folder {given}. {remedy}")
    if not path.is_file():
        raise ConfigError(f"run={run} has no {FILE}. {remedy}")
    content = yaml.safe_load(path.read_text(encoding="utf-8"))
    if not isinstance(content, dict) or content.get("schema") != SCHEMA:
        raise ConfigError(f"{path} is no fitted context: expected schema {SCHEMA}.")
    columns = (content[key] for key in ("names", "units", "nominal", "low", "high"))
    parameters = tuple(Parameter(*each) for each in zip(*columns, strict=True))
    return ContextEstimate(
        ContextSpace(parameters),
        np.asarray(content["mean"], dtype=float),
        np.asarray(content["covariance"], dtype=float),
    )
