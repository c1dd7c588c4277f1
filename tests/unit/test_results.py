"""RESULTS.md is read by question: each is listed, answered, and has one table whose commands can still be typed."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
RESULTS = (ROOT / "benchmarks/RESULTS.md").read_text(encoding="utf-8")
HEADER = ["what", "command", "figure", "goal", "commit or day"]
WORDS = 60  # of a cell at most


def anchor(heading: str) -> str:
    """The anchor that GitHub and MyST give a heading."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def cells(line: str) -> list[str]:
    return [cell.strip() for cell in re.split(r"(?<!\\)\|", line.strip().strip("|"))]


def questions() -> dict[str, str]:
    """The text below each heading of third level."""
    parts = re.split(r"^(#{2,3}) (.+)$", RESULTS, flags=re.MULTILINE)[1:]
    sections = zip(parts[::3], parts[1::3], parts[2::3], strict=True)
    return {heading: text for level, heading, text in sections if level == "###"}


def test_the_list_of_questions_is_that_of_the_headings() -> None:
    listed = re.findall(r"^ +\* \[(.+)\]\(#(.+?)\) \S", RESULTS, flags=re.MULTILINE)
    assert listed == [(heading, anchor(heading)) for heading in questions()]


@pytest.mark.parametrize("question", questions())
def test_a_question_has_an_answer_and_one_table(question: str) -> None:
    text = questions()[question].strip()
    assert not text.startswith("|")
    tables = re.findall(r"(?:^\|.*\n?)+", text, flags=re.MULTILINE)
    assert len(tables) == 1
    header, _, *rows = [cells(line) for line in tables[0].splitlines()]
    assert header == HEADER
    assert [row for row in rows if len(row) != len(HEADER)] == []
    assert [cell for row in rows for cell in row if len(cell.split()) > WORDS] == []


def test_what_results_name_exists() -> None:
    experiments = {name for names in re.findall(r"experiment=([a-z0-9_,]+)", RESULTS) for name in names.split(",")}
    assert {name for name in experiments if not (ROOT / f"conf/experiment/{name}.yaml").exists()} == set()
    files = set(re.findall(r"\b(?:tests|benchmarks|conf|docs|launchers)/[\w/]+\.(?:py|yaml|md|xml)", RESULTS))
    assert {name for name in files if not (ROOT / name).exists()} == set()
    assert len(experiments) > 20
    assert len(files) > 20


def test_references_to_results_lead_to_questions() -> None:
    pages = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md", *(ROOT / "docs").glob("*.md")]
    anchors = [name for page in pages for name in re.findall(r"RESULTS\.md#([\w-]+)", page.read_text(encoding="utf-8"))]
    assert anchors
    assert set(anchors) <= {anchor(heading) for heading in questions()}
