"""The effect catalogue: an overview, and a page for each effect, from its class and its yaml."""

import inspect
import re
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from hydra.utils import instantiate

from dr_lab.cli.compose import compose
from dr_lab.cli.folders import shipped
from dr_lab.cli.groups import options
from dr_lab.cli.verb_help import commented
from dr_lab.cli.verbs import summary
from dr_lab.effects.effect import FAMILIES, Effect
from dr_lab.effects.learned_force import LearnedForce
from dr_lab.physics.radial_basis import Input, RadialBasis
from generator.signature import put
from generator.text import code, literal, plain, table

_SECTION = re.compile(r"^(Parameters[^:]*|Limits|Raises|Source|Attributes):", re.MULTILINE)
_SIGNATURE = (
    "First measured less simulated position, the model lacking the effect: same start, same commands. Then, where "
    "there are no contacts and one joint, what that model would need besides, by inverse dynamics along the measured "
    "motion (of a sensor, the residual again)."
)
_OPEN = ("effects.formula.expression='-k*sin(3*q)'", "effects.formula.free={k:{unit:Nm,nominal:0,low:-1,high:1}}")


@cache
def catalogue() -> Mapping[str, Effect]:
    """Every effect that ships, by name; the open one has its yaml's example, the learned one an example's force."""
    cfg = compose("diagnose", ["effect=[all,formula,residual_force]", *_OPEN])
    found = {name: instantiate(node, _convert_="all") for name, node in sorted(cfg.effects.items())}
    return {**found, "residual_force": replace(found["residual_force"], learned={"joint": _example()})}


def _example() -> LearnedForce:
    """A hill of potential on the way of the plots' machine: a force to either side of 0.2 rad."""
    angles = np.array([0.05, 0.35])
    inputs = (Input("angle", "joint", 0.15),)
    basis = RadialBasis(inputs, np.stack([np.cos(angles), np.sin(angles)], axis=1) / 0.15, near=1.0, far=2.0)
    return LearnedForce(basis, np.array([-0.3, 0.3]), "N·m")


def pages(*, figures: bool) -> dict[str, str]:
    """Markdown by path below ``generated/``.

    Args:
        figures: whether the pages show ``<effect>.svg``.
    """
    found = {f"effects/{name}.md": _page(name, effect, figures=figures) for name, effect in catalogue().items()}
    return {"effects/index.md": _index(), **found}


def sections(effect: Effect) -> dict[str, str]:
    """An effect's docstring in parts, by title; what comes first is called ``""``.

    Args:
        effect: of the catalogue.
    """
    parts = _SECTION.split(inspect.cleandoc(type(effect).__doc__ or ""))
    names = ["", *(name.split(" ")[0] for name in parts[1::2])]
    return dict(zip(names, (text.strip("\n") for text in parts[0::2]), strict=True))


def _index() -> str:
    lines = [
        "# Effect catalogue",
        "",
        "What a model may lack. `dr-lab diagnose` tries each effect at every site where it can act. The pages are made "
        "from the classes in `dr_lab/effects` and from `conf/effect`; an effect of your own joins by being there "
        "([Extending](../../extending.md)).",
        "",
    ]
    for family in FAMILIES:
        members = {name: effect for name, effect in catalogue().items() if effect.family == family}
        rows = [(f"[{name}]({name}.md)", plain(_what(name)), literal(effect.law)) for name, effect in members.items()]
        lines += [f"## {family.capitalize()}", "", *table(("effect", "what it is", "law"), rows)]
    return "\n".join([*lines, "```{toctree}", ":hidden:", "", *catalogue(), "```", ""])


def _page(name: str, effect: Effect, *, figures: bool) -> str:
    parts = sections(effect)
    lines = [f"# {name}", "", f"*{plain(_what(name))}* · family {effect.family}", ""]
    lines += [*code(effect.law), plain(parts[""]), ""]
    lines += ["**Fingerprint:** " + plain(effect.fingerprint) + ".", ""]
    if effect.confused_with:
        lines += ["**Confused with:** " + _links(effect.confused_with) + ".", ""]
    if effect.holds:
        lines += ["**Special cases:** " + _links(tuple(effect.holds)) + ". The poorest that is not beaten stands.", ""]
    if figures:
        lines += ["## Signature", "", f"```{{image}} {name}.svg", f":alt: signature of {name}", "```", ""]
        lines += [_SIGNATURE, ""]
    lines += ["## Parameters", "", _capital(plain(parts["Parameters"].strip())), "", *_bounds(effect)]
    for title in ("Limits", "Raises", "Source"):
        if title in parts:
            lines += [f"## {title}", "", _capital(plain(parts[title].strip())), ""]
    if effect.lacks:
        lines += ["## In the exported MJCF", "", f"The file lacks {plain(effect.lacks)}.", ""]
    return "\n".join([*lines, *_settings(name, parts.get("Attributes", ""))])


def _bounds(effect: Effect) -> list[str]:
    bench, placed = put(effect)
    short = len(placed.label) + 1
    rows = [
        (literal(p.name[short:]), literal(p.unit), *(f"{x:.4g}" for x in (p.nominal, p.low, p.high)))
        for p in placed.parameters
    ]
    told = f"Bounds follow from the size of the motion in the logs; here those on the plot's machine, `{bench.name}`."
    return [told, "", *table(("parameter", "unit", "absent", "low", "high"), rows)]


def _settings(name: str, attributes: str) -> list[str]:
    path = options("effect", (shipped(),))[name]
    values: dict[str, Any] = yaml.safe_load(path.read_text(encoding="utf-8"))
    meaning = {
        k: " ".join(v.split()) for k, v in re.findall(r"^\s*(\w+): ((?:.|\n(?!\s*\w+: ))+)", attributes, re.MULTILINE)
    }
    rows = [
        (literal(key), literal(str(values[key])), plain(meaning.get(key, "")), plain(comment))
        for key, comment in commented(path)
        if key in values
    ]
    if not rows:
        return []
    head = ("key", "value", "meaning", "unit or source")
    return [f"## Settings: `conf/effect/{name}.yaml`", "", *table(head, rows)]


def _capital(text: str) -> str:
    """Begin with a capital where a word begins; a symbol stays as it is."""
    return text[0].upper() + text[1:] if re.match(r"[a-z]{2,} ", text) and not text.startswith("tau") else text


def _what(name: str) -> str:
    return summary(options("effect", (shipped(),))[name])


def _links(names: tuple[str, ...]) -> str:
    return ", ".join(f"[{name}]({name}.md)" for name in names)


def figure_path(folder: Path, name: str) -> Path:
    """Where the plot of an effect lies.

    Args:
        folder: of the generated pages.
        name: of the effect.
    """
    return folder / "effects" / f"{name}.svg"
