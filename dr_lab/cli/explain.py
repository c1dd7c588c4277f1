"""One clear message for every way in which a command can fail."""

import re
import traceback
from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import yaml
from hydra.errors import (
    HydraException,
    InstantiationException,
    MissingConfigException,
    OverrideParseException,
)
from omegaconf.errors import MissingMandatoryValue, OmegaConfBaseException

from dr_lab.cli.compose import choices, compose_with_hydra
from dr_lab.cli.deeper_groups import ending_in
from dr_lab.cli.experiments import GROUP as EXPERIMENT
from dr_lab.cli.experiments import experiments
from dr_lab.cli.groups import nested_options, options, subgroups
from dr_lab.cli.overrides import RefusedKey, refused_key
from dr_lab.cli.targets import of_the_user
from dr_lab.cli.verbs import description
from dr_lab.errors import ConfigError, DrLabError, UnknownNameError
from dr_lab.extras import MissingLibraryError, lacking
from dr_lab.files import why_no_folder

USER_FAULT = 2
OUR_FAULT = 1


def explain(error: Exception, verb: str, folders: Sequence[Path]) -> tuple[str, int]:
    """What to tell the user, and the exit code.

    Args:
        error: what was raised.
        verb: the verb that was running.
        folders: configuration folders, first searched first.

    Returns:
        The message, and 2 where the user can mend the cause or 1 where it looks like a fault of dr_lab.
    """
    for cause in _chain(error):
        if isinstance(cause, DrLabError):
            return str(cause), USER_FAULT
        if (library := lacking(cause)) is not None:
            return str(MissingLibraryError(verb, library)), USER_FAULT
    if isinstance(error, InstantiationException):
        return _instantiation(error), OUR_FAULT
    mendable = _mendable(error, verb, folders)
    if mendable is not None:
        return mendable, USER_FAULT
    detail = f"{type(error).__name__}: {error}"
    own = _line_of_the_user(error)
    if own is not None:
        return f"{detail}\nIt comes from code of yours: {own}. HYDRA_FULL_ERROR=1 shows the way there.", USER_FAULT
    return f"{detail}\nThis looks like a fault of dr_lab; HYDRA_FULL_ERROR=1 shows where it happened.", OUR_FAULT


@contextmanager
def raised_plainly(verb: str, folders: Sequence[Path]) -> Iterator[None]:
    """Let what Hydra and OmegaConf raise during a block be raised as the errors of dr_lab that it stands for.

    Args:
        verb: that is composed and built.
        folders: configuration folders, first searched first.

    Raises:
        DrLabError: the one that Hydra wrapped, else one with what the command line says.
    """
    try:
        yield
    except (HydraException, OmegaConfBaseException, yaml.MarkedYAMLError) as error:
        for cause in _chain(error):
            if isinstance(cause, DrLabError):
                raise cause from None
        message, code = explain(error, verb, folders)
        if code == OUR_FAULT:
            raise
        raise ConfigError(message) from error


def _mendable(error: Exception, verb: str, folders: Sequence[Path]) -> str | None:
    """What to tell of an error of others that the user can mend, or None where it is none of these."""
    if isinstance(error, yaml.MarkedYAMLError):
        return _syntax(error)
    if isinstance(error, HydraException | OmegaConfBaseException):
        return _composition(str(error), verb, folders) or _configuration(error, verb, folders)
    if isinstance(error, ValueError) and _raised_by_hydra(error):
        return _refused(str(error))
    if isinstance(error, OSError) and error.filename is not None:
        return _file_error(error)
    return None


def _file_error(error: OSError) -> str:
    """A file or folder that the system refuses; while Hydra runs alone it makes the run folder and nothing else."""
    modules = [str(frame.f_globals.get("__name__")) for frame, _ in traceback.walk_tb(error.__traceback__)]
    if "hydra.core.utils" in modules and "dr_lab.cli.job" not in modules:
        why = why_no_folder(Path(error.filename), error)
        return (
            f"Cannot make the run folder {error.filename}: {why}. Choose another place: outputs=FOLDER, or "
            "hydra.run.dir=FOLDER if you gave that."
        )
    return f"{error.filename}: {error.strerror}. Choose another one, or change its permissions."


def _line_of_the_user(error: Exception) -> str | None:
    """The last line of the user's own code, such as a task or a target, on the way to an error."""
    calls = [
        (frame.f_code.co_filename, line, frame.f_globals) for frame, line in traceback.walk_tb(error.__traceback__)
    ]
    own = [f"{file}, line {line}" for file, line, names in calls if of_the_user(str(names.get("__name__")))]
    return own[-1] if own else None


def _raised_by_hydra(error: Exception) -> bool:
    """Whether Hydra's own code raised it, as it does for flags that exclude one another."""
    frames = [frame for frame, _ in traceback.walk_tb(error.__traceback__)]
    return bool(frames) and str(frames[-1].f_globals.get("__name__")).startswith("hydra.")


def _refused(text: str) -> str:
    """What Hydra refuses with a plain ValueError, in our words where its own speak of Python."""
    if text.startswith("Config group override must be"):
        return "A group takes the name of one of its options, or a list of names; leave a group out with '~group'."
    return text


def _chain(error: BaseException | None) -> Iterator[BaseException]:
    """An error and what led to it; OmegaConf keeps the cause of a failed resolver only as context."""
    while error is not None:
        yield error
        error = error.__cause__ or (None if error.__suppress_context__ else error.__context__)


def _syntax(error: yaml.MarkedYAMLError) -> str:
    mark = error.problem_mark
    where = f"{mark.name}, line {mark.line + 1}: " if mark is not None else ""
    return f"{where}{error.problem}. This is not valid yaml; indent with spaces and quote texts that hold ': ' or ' #'."


def _instantiation(error: InstantiationException) -> str:
    *_, root = _chain(error)
    key = re.search(r"full_key: (\S+)", str(error))
    where = f"Building {key[1]} failed. " if key else ""
    return f"{where}{type(root).__name__}: {root}\nHYDRA_FULL_ERROR=1 shows where it happened."


def _configuration(error: Exception, verb: str, folders: Sequence[Path]) -> str:
    """A fault that Hydra or OmegaConf found while composing."""
    if isinstance(error, OverrideParseException):
        return _unreadable(str(error.override), verb)
    if isinstance(error, MissingConfigException):
        return _missing_option(error, verb, folders)
    refused = refused_key(error)
    if refused is not None:
        return str(_unknown_key(refused, error, verb, folders))
    cause = next((e for e in _chain(error) if isinstance(e, OmegaConfBaseException)), None)
    if cause is not None:
        return _omegaconf(cause)
    return str(error).strip()


def _composition(text: str, verb: str, folders: Sequence[Path]) -> str | None:
    """What Hydra says of the defaults list, in our words: a group without a choice, an experiment of another verb."""
    needed = re.match(r"You must specify '([^']+)'", text)
    if needed is not None:
        available = ", ".join(options(needed[1], folders))
        return f"No {needed[1]} is chosen. Give one: dr-lab {verb} {needed[1]}=NAME. Available: {available}."
    several = re.match(r"Ambiguous value for argument '([^=]+)=(.+)'\n", text)
    if several is not None:
        key, value = several.groups()
        return (
            f"{key}={value} gives several values. As a list: '{key}=[{value}]'. One job for each: add -m (--multirun). "
            f"As one text: \"{key}='{value}'\"."
        )
    foreign = re.match(r"In 'experiment/([^']+)': Could not override '([^']+)'", text)
    if foreign is None:
        return None
    lines = description(options("experiment", folders)[foreign[1]])
    own = next((f" Its own command: {line}" for line in lines if line.startswith("dr-lab ")), "")
    return f"Experiment {foreign[1]!r} is not one of dr-lab {verb}, which has no group {foreign[2]!r}.{own}"


def _unreadable(override: str, verb: str) -> str:
    """An override that Hydra's grammar does not hold; shows how the shell and Hydra get the value whole."""
    key, equals, value = override.partition("=")
    if not equals:
        return f"Cannot read {override!r}; expected key=value, without spaces. The keys: dr-lab {verb} --help."
    if not key or not value or value[0] in "{[\"'=":
        return (
            f"Cannot read {override!r}; expected key=value. Quote a text that holds spaces, commas, brackets or other "
            "signs, once for the shell and once for Hydra: 'key=\"text\"'."
        )
    return f"Cannot read {override!r}. Quote the value, once for the shell and once for Hydra: '{key}=\"{value}\"'."


def _missing_option(error: MissingConfigException, verb: str, folders: Sequence[Path]) -> str:
    """An option that its group does not have; Hydra lists the others only where a single one was chosen."""
    file = error.missing_cfg_file or ""
    listed = re.search(r"^Available options in '([^']+)'", str(error), re.MULTILINE)
    group = listed[1] if listed else file.rpartition("/")[0]
    option = file.removeprefix(f"{group}/")
    if Path(option).suffix:
        return (
            f"{group}={option} names a file; expected an option. For one of your own, write FOLDER/{group}/NAME.yaml "
            f"and give --config-dir FOLDER {group}=NAME. Those that there are: dr-lab {verb} --help."
        )
    if group == EXPERIMENT:
        known = experiments(choices(compose_with_hydra(verb, [], folders)), folders)
        return str(UnknownNameError(group, option, known, f"dr-lab {verb}"))
    available = [*(error.options or options(group, folders)), *nested_options(group, folders)]
    if not group or not available:
        return str(error).splitlines()[0]
    beside = [name for name in available if name.startswith(f"{option.partition('/')[0]}/")]
    return f"{UnknownNameError(group, option, beside or available, 'the configuration')}{_own(group, option)}"


def _own(group: str, option: str) -> str:
    """Where a file of the user's with that name lies, below where she is."""
    found = next((path for path in Path.cwd().glob(f"*/{group}/{option}.yaml")), None)
    return (
        "" if found is None else f" There is one in {found.parents[1].name}: add --config-dir {found.parents[1].name}."
    )


def _unknown_key(refused: RefusedKey, error: Exception, verb: str, folders: Sequence[Path]) -> DrLabError:
    """An override that names neither a key nor a group of the verb; says what there is beside it."""
    if refused.prefix and refused.node is not None:
        known = {f"{refused.prefix}.{name}" for name in refused.node}
    else:
        cfg = compose_with_hydra(verb, [], folders)
        known = {str(name) for name in cfg if name != "hydra"} | set(choices(cfg))
    if not known:
        below = refused.key.removeprefix(f"{refused.prefix}.")
        return ConfigError(f"{refused.prefix} holds no key yet. Add one: '+{refused.prefix}={{{below}:VALUE}}'.")
    if refused.key in known:
        return ConfigError(_group_of_others(refused.key, folders) or str(error))
    unknown = UnknownNameError("key or group", refused.key, known, f"dr-lab {verb}")
    return ConfigError(f"{unknown}{'' if refused.prefix else _deeper(refused.key, known, folders)}")


def _deeper(key: str, known: Collection[str], folders: Sequence[Path]) -> str:
    """The spelling of groups that are called so and stand below others, each beside an option that brings it."""
    found = ending_in(key, known, folders)
    spelt = ", ".join(f"{spelling}=… (with {group}={option})" for spelling, (group, option) in sorted(found.items()))
    return f" Of that name below other groups: {spelt}." if found else ""


def _group_of_others(key: str, folders: Sequence[Path]) -> str | None:
    """What to tell of a group such as ``env/context`` that other options of its parent have than the chosen one."""
    parent, _, name = key.rpartition("/")
    having = [option for option, path in options(parent, folders).items() if name in subgroups(path)] if parent else []
    if not having:
        return None
    available = ", ".join(having)
    return f"The chosen {parent} has no group {key!r}. Choose one that has, or leave it out. Available: {available}."


def _omegaconf(error: OmegaConfBaseException) -> str:
    text = re.sub(r"^\w+ raised while resolving interpolation: ", "", (error.msg or str(error)).splitlines()[0])
    where = f"{error.full_key}: " if error.full_key else ""
    if isinstance(error, MissingMandatoryValue):
        return f"{where}no value. Give one: {error.full_key}=…"
    return f"{where}{text}"
