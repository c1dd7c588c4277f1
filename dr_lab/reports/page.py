"""What a report says to a person, section by section: `report.md` and `report.html` are made of it."""

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Section:
    """A part of a page.

    Attributes:
        key: names the section whatever its title is, for figures that belong to it.
        title: its heading; empty where it needs none.
        body: Markdown with tables and without mathematics, so that every viewer shows it; empty if there is nothing to
            say.
    """

    key: str
    title: str
    body: str


@dataclass(frozen=True)
class Page:
    """A report for a person.

    Attributes:
        title: its heading.
        lead: Markdown of what a reader wants to know first, the answer in its first sentence.
        sections: what follows.
    """

    title: str
    lead: str
    sections: Sequence[Section]

    def markdown(self) -> str:
        """The page as Markdown; sections of which nothing is said are left out."""
        said = [_markdown(section) for section in self.sections if section.body.strip()]
        return "\n\n".join(part for part in (f"# {self.title}", self.lead, *said) if part) + "\n"


def _markdown(section: Section) -> str:
    return f"## {section.title}\n\n{section.body}" if section.title else section.body
