"""Going on with an earlier run: only one with the same settings is gone on with."""

import shlex
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path

from omegaconf import DictConfig, ListConfig, OmegaConf

from dr_lab.errors import ConfigError
from dr_lab.reports.typed import typed
from dr_lab.run_command import CONFIG_FILE, config_dirs_of, verb_of

_NOT_SETTINGS = ("defaults", "made_with", "outputs", "resume")
_SHOWN = 3  # differences
_WIDTH = 60  # letters of a value
_ABSENT = "absent"


def require_same_settings(cfg: DictConfig, run: Path, verb: str, may_differ: Collection[str]) -> None:
    """Refuse to go on with a run whose recorded configuration is another one.

    Configurations are compared as written, before interpolation: what follows from a key that may differ
    (``anneal_frames: ${frames}``) differs with it, and a file's place on this machine is no difference.

    Args:
        cfg: the composed configuration without Hydra's node.
        run: folder of the earlier run.
        verb: e.g. ``"train"``.
        may_differ: top-level keys that change nothing of what the run has done so far.

    Raises:
        ConfigError: a setting differs, or the folder is not that of a run.
    """
    path = run / CONFIG_FILE
    remedy = f"Give resume=FOLDER of a run of dr-lab {verb}."
    if not run.is_dir():
        raise ConfigError(f"There is no folder {run}. {remedy}")
    if not path.is_file():
        raise ConfigError(f"resume={run} holds no {CONFIG_FILE}. {remedy}")
    of = verb_of(run)
    if of not in ("", verb):
        raise ConfigError(f"resume={run} is a run of dr-lab {of}. {remedy}")
    recorded = OmegaConf.load(path)
    left_out = {*_NOT_SETTINGS, *may_differ}
    here, there = _settings(cfg, left_out), _settings(recorded, left_out)
    different = [key for key in {**here, **there} if here.get(key, _ABSENT) != there.get(key, _ABSENT)]
    if not different:
        return
    shown = "; ".join(f"{key} is {_text(here, key)}, there {_text(there, key)}" for key in different[:_SHOWN])
    more = f"; and {len(different) - _SHOWN} more" if len(different) > _SHOWN else ""
    words = [word for word in OmegaConf.select(recorded, "made_with.overrides") or () if not word.startswith("resume=")]
    folders = shlex.join(["--config-dir", str(run), *config_dirs_of(run)])
    raise ConfigError(
        f"resume={run} is a run with other settings: {shown}{more}. Its overrides were: {shlex.join(words) or 'none'}. "
        f"Give the same (only {', '.join(may_differ)} may change), or go on with its recorded configuration: "
        f"dr-lab {verb} {folders} --config-name config {typed('resume', run)}. "
        "Or start a new run, without resume."
    )


def _settings(config: DictConfig | ListConfig, left_out: Collection[str]) -> dict[str, object]:
    """Values as written, by dotted key; a list is one value."""
    values = OmegaConf.to_container(config, resolve=False)
    assert isinstance(values, dict)
    return dict(_leaves({key: value for key, value in values.items() if key not in left_out}, ""))


def _leaves(value: object, path: str) -> Iterator[tuple[str, object]]:
    if not isinstance(value, Mapping) or not value:
        yield path, value
        return
    for key, child in value.items():
        yield from _leaves(child, f"{path}.{key}" if path else str(key))


def _text(settings: Mapping[str, object], key: str) -> str:
    text = str(settings.get(key, _ABSENT))
    return text if len(text) <= _WIDTH else f"{text[:_WIDTH]}…"
