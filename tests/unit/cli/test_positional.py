"""Words without a key: files, whatever they are called."""

from pathlib import Path

import pytest
from hydra.core.override_parser.overrides_parser import OverridesParser

from dr_lab.cli.arguments import checked
from dr_lab.cli.compose import compose
from dr_lab.cli.folders import shipped
from dr_lab.cli.positional import is_plain, spelt_out

FOLDERS = (shipped(),)


def values(words: list[str]) -> dict[str, object]:
    """What Hydra makes of a command line."""
    overrides = OverridesParser.create().parse_overrides(spelt_out("init", words, FOLDERS))
    return {override.key_or_group: override.value() for override in overrides}


def test_words_become_the_keys_of_the_verb() -> None:
    assert spelt_out("init", ["two.xml", "a.csv", "name=x", "b.csv", "--resolve"], FOLDERS) == [
        'robot="two.xml"',
        'logs=["a.csv","b.csv"]',
        "name=x",
        "--resolve",
    ]
    assert spelt_out("init", ["two.xml"], FOLDERS) == ['robot="two.xml"']
    flags = ["--cfg", "job", "-p", "folder", "--info"]
    assert spelt_out("init", [*flags, "two.xml", "job"], FOLDERS) == ['robot="two.xml"', 'logs=["job"]', *flags]
    assert spelt_out("close", ["two.xml"], FOLDERS) == ["two.xml"]


@pytest.mark.parametrize(
    "name", ["a b.csv", "run,1[0].csv", "k=3.csv", "ä'ö.csv", 'say "x".csv', "{a}(b).csv", "a:b.csv"]
)
def test_names_reach_the_verb_as_they_are(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path(name).touch()
    assert values(["two.xml", name, "output=x"]) == {"robot": "two.xml", "logs": [name], "output": "x"}


@pytest.mark.parametrize(
    ("word", "plain"),
    [("arm.xml", True), ("~/logs/a.csv", True), ("~effects.wind", False), ("--resume", False), ("name=arm", False)],
)
def test_names_of_files_are_told_from_flags_and_keys(word: str, plain: bool) -> None:
    assert is_plain(word) == plain


def test_a_key_that_only_feeds_another_may_be_passed_by() -> None:
    """`folder.path=X` says what `output=X` would; `output`, which then feeds nothing, is no unknown key."""
    cfg = compose("init", ["robot=two.xml", "logs=[a.csv]", "folder.path=X"])
    workflow, passed = checked("init", cfg, FOLDERS)
    assert workflow.__name__ == "init"
    assert "output" not in passed
    assert cfg.folder.path == "X"
