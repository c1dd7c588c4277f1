"""The text of ``dr-lab <verb> --help``, made from the configuration files and the comments in them."""

import itertools
import re
import textwrap
from collections.abc import Iterator, Sequence
from pathlib import Path

import yaml
from hydra.errors import HydraException
from omegaconf import DictConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException

from dr_lab.cli.compose import choices, compose_outline, compose_with_hydra
from dr_lab.cli.experiments import GROUP as EXPERIMENT
from dr_lab.cli.experiments import experiments
from dr_lab.cli.groups import LOADER, nested_options, options, side_by_side
from dr_lab.cli.place import interpolated
from dr_lab.cli.positional import KEY, positional
from dr_lab.cli.verbs import description, summary

WIDTH = 118
ABSENT = object()
NOT_SETTINGS = ("defaults", "hydra", "_target_", KEY)
_SENTENCE_END = re.compile(r"(?<!et al)\. (?=[A-Z])")
FLAGS = """\
Flags
  --cfg job [--resolve] [-p key]   print the composed configuration and stop
  -m, --multirun                   one job per combination: -m seed=1,2,3; the same again goes on with it
  --config-dir FOLDER              your own model/, measurements/, effect/ … files, found before ours
  --hydra-help                     everything else that Hydra can do

Remove a key with ~key; repeat a run with --config-dir RUN_FOLDER --config-name config."""


def verb_help(verb: str, overrides: Sequence[str], folders: Sequence[Path]) -> str:
    """What a verb does, its groups with their options, its keys with value and comment, and where results go.

    Args:
        verb: name of a root configuration.
        overrides: what else was typed; the shown values follow it.
        folders: configuration folders, first searched first.
    """
    try:
        return _text(verb, compose_outline(verb, overrides, folders), folders)
    except (HydraException, OmegaConfBaseException):  # a key of what an option `all` stands for, or of nothing
        return _text(verb, compose_with_hydra(verb, overrides, folders), folders)


def _text(verb: str, cfg: DictConfig, folders: Sequence[Path]) -> str:
    root = next(path for folder in folders if (path := folder / f"{verb}.yaml").is_file())
    first, *examples = description(root)
    words = "".join(f"{key.upper()} " for key in positional(verb, folders))
    lines = [f"dr-lab {verb} {words}[group=option ...] [key=value ...]", "", f"  {first}"]
    lines += [f"  {line}".rstrip() for line in examples]
    lines += ["", "Groups"]
    groups = choices(cfg)
    for group, chosen in groups.items():
        files = experiments(groups, folders) if group == EXPERIMENT else options(group, folders)
        lines += _group(group, chosen, files, nested_options(group, folders))
    lines += ["", "Keys (those of a group: --cfg job)", *_keys(cfg, root, folders)]
    if "now:" in str(OmegaConf.to_container(cfg.hydra.run, resolve=False)):
        model = "<model>/" if "model" in cfg else ""
        lines += ["", f"Results: {cfg.outputs}/{verb}/{model}<date_time>/"]
    return "\n".join([*lines, "", FLAGS])


def _group(group: str, chosen: str | None, files: dict[str, Path], nested: Sequence[str]) -> Iterator[str]:
    """A group's choice, then one line for every option where there is something to choose."""
    if not files and not nested:
        return
    together = side_by_side(files)
    hint = f"   several at once: {group}=[a,b]" if together else ""
    yield f"  {group}={'null' if chosen is None else chosen}{hint}"
    if list(files) == [chosen] and not nested:
        return
    texts = {name: _SENTENCE_END.split(summary(path))[0].removesuffix(".") for name, path in files.items()}
    width = max(map(len, texts), default=0) + 2
    for name, text in sorted(texts.items(), key=lambda option: option[0] in together):  # that of all of them first
        line = f"      {name:<{width}}{text}".rstrip()
        yield line if len(line) <= WIDTH else f"{line[: WIDTH - 2].rpartition(' ')[0]} …"
    for folder, names in itertools.groupby(nested, lambda name: name.rpartition("/")[0]):
        listed = ", ".join(name.rpartition("/")[2] for name in names)
        yield from textwrap.wrap(f"{folder}/…  {listed}", WIDTH, initial_indent=" " * 6, subsequent_indent=" " * 10)


def _keys(cfg: DictConfig, root: Path, folders: Sequence[Path]) -> Iterator[str]:
    """The keys worth showing, each with its value and comment.

    These are the root configuration's, those of groups without alternatives, and those that chosen options put beside;
    what only hands on another key's value is none of them, unless a comment says more of it.
    """
    handed_on = interpolated(cfg)
    comments = dict(commented(root))
    for path in options("base", folders).values():
        comments |= dict(commented(path))
    for group, chosen in choices(cfg).items():
        files = options(group, folders)
        if chosen in files:
            comments |= _comments_of(files[chosen], group, alone=len(files) == 1)
    shown = {}
    for key, comment in comments.items():
        if key in handed_on and not comment:
            continue
        value = OmegaConf.select(cfg, key, default=ABSENT)
        if value is not ABSENT:
            shown[f"{key}={'null' if value is None else value}"] = comment
    width = min(max(map(len, shown), default=0), 48) + 2
    for text, comment in shown.items():
        yield f"  {text:<{width - 2}}  {comment}".rstrip()


def _comments_of(path: Path, group: str, *, alone: bool) -> dict[str, str]:
    """The keys of a group's chosen option that are worth showing, with their comments."""
    header = path.read_text(encoding="utf-8").partition("\n")[0]
    if header.split() == ["#", "@package", "_global_"]:
        return {key: comment for key, comment in commented(path) if comment or alone}
    if alone and "@package" not in header:
        return {f"{group.replace('/', '.')}.{key}": comment for key, comment in commented(path)}
    return {}


def commented(path: Path) -> Iterator[tuple[str, str]]:
    """The settings that a yaml file holds, as dotted keys, each with the comment at the end of its line."""
    text = path.read_text(encoding="utf-8")
    lines = [*text.splitlines(), ""]

    def walk(node: yaml.Node | None, prefix: str) -> Iterator[tuple[str, str]]:
        if not isinstance(node, yaml.MappingNode):
            return
        for key, value in node.value:
            name = f"{prefix}{key.value}"
            if key.value in NOT_SETTINGS:
                continue
            if isinstance(value, yaml.MappingNode) and not value.flow_style:
                yield from walk(value, f"{name}.")
            else:
                rest = lines[value.end_mark.line][value.end_mark.column :]
                yield name, rest.partition("#")[2].strip()

    yield from walk(yaml.compose(text, LOADER), "")
