"""The keys of a configuration as the user would type them."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

from omegaconf import DictConfig, OmegaConf

_OTHER_KEY = re.compile(r"\$\{(\w[\w.]*)\}")


@dataclass(frozen=True)
class Place:
    """A key of a configuration; a value that is another key's, such as that of ``plan.frames``, goes by the other key.

    Attributes:
        key: dotted, empty for the whole configuration.
        sources: key that is to be typed, by key that takes its value by interpolation.
    """

    key: str = ""
    sources: Mapping[str, str] = field(default_factory=dict)

    def below(self, name: object) -> "Place":
        """The place of a key of what lies here."""
        key = f"{self.key}.{name}" if self.key else str(name)
        while key in self.sources:
            key = self.sources[key]
        return replace(self, key=key)

    def item(self, index: int) -> "Place":
        """The place of an item of the list that lies here."""
        return replace(self, key=f"{self.key}[{index}]")

    def __str__(self) -> str:
        return self.key


def interpolated(cfg: DictConfig) -> dict[str, str]:
    """The keys of a configuration that are nothing but another key, each with that.

    Args:
        cfg: composed configuration; no key of it leads back to itself.
    """
    return dict(_interpolated(OmegaConf.to_container(cfg, resolve=False), ""))


def _interpolated(value: object, path: str) -> Iterator[tuple[str, str]]:
    if isinstance(value, Mapping):
        for key, child in value.items():
            yield from _interpolated(child, f"{path}.{key}" if path else str(key))
    elif isinstance(value, str) and (found := _OTHER_KEY.fullmatch(value)):
        yield path, found[1]
