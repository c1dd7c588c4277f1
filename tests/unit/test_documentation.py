"""The documentation's generated pages: each effect, verb and group has one, and what is quoted is what is said."""

from pathlib import Path

import numpy as np
import pytest
from generator import effects, groups, messages, notebooks, signature, site

from dr_lab.cli.folders import shipped
from dr_lab.cli.verbs import verbs

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"


@pytest.fixture(scope="module")
def pages() -> dict[str, str]:
    return site.pages(figures=False)


def test_each_effect_has_its_page(pages: dict[str, str]) -> None:
    shipped_effects = {path.stem for path in (shipped() / "effect").glob("*.yaml")} - {"all"}
    assert {Path(name).stem for name in pages if name.startswith("effects/")} == shipped_effects | {"index"}
    for name in shipped_effects:
        text, effect = pages[f"effects/{name}.md"], effects.catalogue()[name]
        assert effect.law in text
        assert "## Parameters" in text
        assert all(f"({other}.md)" in text for other in effect.confused_with)


@pytest.mark.parametrize("name", sorted(effects.catalogue()))
def test_the_plot_of_an_effect_shows_something(name: str) -> None:
    shown = signature.signature(effects.catalogue()[name])
    assert np.abs(shown.residual).max() > 1e-4


def test_bounds_on_a_page_are_those_of_the_class(pages: dict[str, str]) -> None:
    # The motor arm needs 0.6 N·m in the logs, and the yaml's factor is 1.
    assert "| `torque` | `N·m` | 0 | 0 | 0.6 |" in pages["effects/coulomb_friction.md"]


def test_each_verb_and_each_group_has_its_page(pages: dict[str, str]) -> None:
    assert {f"verbs/{verb}.md" for verb in verbs()} <= set(pages)
    folders = {path.parent.relative_to(shipped()) for path in shipped().rglob("*.yaml")} - {Path()}
    own = {path for path in folders if path.parts[0] not in {"base", "hydra"}}
    assert {f"groups/{path.as_posix().replace('/', '.')}.md" for path in own} == {
        name for name in pages if name.startswith("groups/") and not name.endswith("index.md")
    }


def test_a_group_s_page_shows_each_option_with_its_file(pages: dict[str, str]) -> None:
    for group in groups.groups():
        for path in (shipped() / group).glob("*.yaml"):
            assert f"## {path.stem}\n" in pages[f"groups/{group.replace('/', '.')}.md"]
            assert path.read_text(encoding="utf-8").strip() in pages[f"groups/{group.replace('/', '.')}.md"]


def test_a_verb_s_page_shows_keys_with_their_comments(pages: dict[str, str]) -> None:
    assert (
        "| `most` | `4` | effects added at most; one that sits at several joints counts once |"
        in pages["verbs/close.md"]
    )
    assert "| `seed` | `0` | of every random draw |" in pages["verbs/train.md"]
    assert "`plan.env`" not in pages["verbs/train.md"]  # which only hands on


def test_links_of_generated_pages_lead_to_pages(pages: dict[str, str]) -> None:
    entries = {name: text.split("```{toctree}") for name, text in pages.items()}
    listed = {
        f"{name.rpartition('/')[0]}/{entry}.md"
        for name, parts in entries.items()
        if len(parts) == 2
        for entry in parts[1].partition("```")[0].split()
        if not entry.startswith(":")
    }
    assert listed | {name for name in pages if name.endswith("index.md")} == set(pages)


def test_pages_are_built_and_not_kept(pages: dict[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(site, "pages", lambda *, figures: pages)
    assert "docs/generated/" in (ROOT / ".gitignore").read_text(encoding="utf-8").split()
    (tmp_path / "effects").mkdir()
    (tmp_path / "effects/phlogiston.md").write_text("of an effect that is no more")
    site.write(tmp_path, figures=False)
    assert not (tmp_path / "effects/phlogiston.md").exists()
    assert (tmp_path / "effects/backlash.md").exists()


def test_questions_quote_what_the_source_says() -> None:
    asked, texts = messages.quoted(DOCS / "faq.md"), messages.templates(ROOT / "dr_lab")
    assert len(asked) >= 20
    assert [message for message in asked if not messages.said(message, texts)] == []


def test_a_message_that_is_no_longer_said_is_seen() -> None:
    assert messages.said("no … in …. Did", ["There is no … … in …. Did you mean"])
    assert not messages.said("in … There is no", ["There is no … in …"])


def test_a_notebook_becomes_text_and_code(tmp_path: Path) -> None:
    path = tmp_path / "one.py"
    path.write_text("# %% [markdown]\n# # Title\n#\n# Text.\n\n# %%\n# why\nprint(1)\n")
    text = notebooks.page(path)
    assert text.startswith("# Title\n\nText.\n")
    assert "````python\n# why\nprint(1)\n````" in text
