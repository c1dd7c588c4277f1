"""The verbs and the groups of the configuration, from conf/."""

import itertools
from typing import Any

import yaml
from omegaconf import DictConfig

from dr_lab.cli.compose import INTERNAL_GROUPS, choices, compose_with_hydra
from dr_lab.cli.folders import shipped
from dr_lab.cli.groups import options, side_by_side
from dr_lab.cli.verb_help import commented
from dr_lab.cli.verbs import description, summary, verbs
from generator.text import code, literal, plain, table


def pages() -> dict[str, str]:
    """Markdown by path below ``generated/``."""
    found = {f"verbs/{verb}.md": _verb(verb) for verb in verbs()}
    found |= {f"groups/{_slug(group)}.md": _group(group) for group in groups()}
    return {"verbs/index.md": _verbs(), "groups/index.md": _groups(), **found}


def groups() -> list[str]:
    """Every folder of conf/ that holds options, sorted; those that only Hydra uses are none."""
    folders = {path.parent.relative_to(shipped()).as_posix() for path in shipped().glob("*/**/*.yaml")}
    return sorted(group for group in folders if group.split("/")[0] not in INTERNAL_GROUPS)


def _slug(group: str) -> str:
    return group.replace("/", ".")


def _verbs() -> str:
    rows = [(f"[dr-lab {verb}]({verb}.md)", plain(text)) for verb, text in verbs().items()]
    told = "Every verb takes `group=option` and `key=value`; `dr-lab VERB --help` says the same in the terminal."
    lines = ["# Verbs", "", told, "", *table(("verb", "what it does"), rows)]
    return "\n".join([*lines, "```{toctree}", ":hidden:", "", *verbs(), "```", ""])


def _verb(verb: str) -> str:
    first, *examples = description(shipped() / f"{verb}.yaml")
    lines = [f"# dr-lab {verb}", "", f"{plain(_sentence(first))}.", ""]
    typed = [f"$ {line}" for line in examples if line]
    lines += code("\n".join(typed), "console") if typed else []
    cfg = compose_with_hydra(verb, [], (shipped(),))
    known = set(groups())
    rows = [
        (f"[{group}](../groups/{_slug(group)}.md)" if group in known else literal(group), literal(chosen or "null"))
        for group, chosen in choices(cfg).items()
    ]
    lines += ["## Groups", "", *table(("group", "option taken"), rows)] if rows else []
    lines += [*_keys(verb, cfg), "## File", "", f"`conf/{verb}.yaml`:", ""]
    return "\n".join([*lines, *code((shipped() / f"{verb}.yaml").read_text(encoding="utf-8"), "yaml")])


def _keys(verb: str, cfg: DictConfig) -> list[str]:
    """The keys of a verb's own file and of what every verb shares."""
    rows = []
    for path in (shipped() / f"{verb}.yaml", *options("base", (shipped(),)).values()):
        values = yaml.safe_load(path.read_text(encoding="utf-8"))
        found = {key: (_shown(_value(values, key)), text) for key, text in commented(path) if key.split(".")[0] in cfg}
        # What only hands on another key's value is nothing to set.
        own = {key: pair for key, pair in found.items() if pair[1] or not pair[0].startswith("${")}
        rows += [(literal(key), literal(value), plain(text)) for key, (value, text) in own.items()]
    return ["## Keys", "", *table(("key", "default", "what it is"), rows)]


def _value(node: Any, key: str) -> object:  # noqa: ANN401  as YAML is read
    for part in key.split("."):
        node = node[part]
    return node


def _shown(value: object) -> str:
    return "null" if value is None else str(value).lower() if isinstance(value, bool) else str(value)


def _groups() -> str:
    rows = []
    for group in groups():
        files = options(group, (shipped(),))
        names = ", ".join(literal(name) for name in itertools.islice(files, 4))
        rows.append((f"[{group}]({_slug(group)}.md)", str(len(files)), names + (", …" if len(files) > 4 else "")))
    told = (
        "Each folder of `conf/` is a group, each file in it an option. `group=option` takes one; a file of the same "
        "name in your own folder (`--config-dir FOLDER`) takes its place."
    )
    lines = ["# Configuration groups", "", told, "", *table(("group", "options", "such as"), rows)]
    return "\n".join([*lines, "```{toctree}", ":hidden:", "", *map(_slug, groups()), "```", ""])


def _group(group: str) -> str:
    files = options(group, (shipped(),))
    lines = [f"# {group}", ""]
    if side_by_side(files):
        lines += [f"Several at once: `{group}=[a,b]`.", ""]
    rows = [(f"[{name}](#{_anchor(name)})", plain(_sentence(summary(path)))) for name, path in files.items()]
    lines += table(("option", "what it is"), rows)
    for name, path in files.items():
        lines += [f"## {name}", "", *code(path.read_text(encoding="utf-8"), "yaml")]
    return "\n".join(lines)


def _anchor(name: str) -> str:
    return name.lower()


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:].removesuffix(".")
