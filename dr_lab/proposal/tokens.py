"""The words of a name, of a column, topic, joint or actuator."""

import re
import unicodedata

_MICRO = str.maketrans("µμ", "uu")  # the sign and the Greek letter
_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+|°")
# What ends a word that names a thing and its quantity at once, as in Motordrehzahl or jointangle; short ends are none.
_ENDS = re.compile(
    "(.{3,})(position|angle|velocity|speed|torque|force|current|voltage|winkel|drehzahl|geschwindigkeit|drehmoment|"
    "kraft|strom|spannung)"
)


def tokens(text: str) -> list[str]:
    """Lower-case words and numbers of a name, without accents; compound words are taken apart."""
    plain = "".join(c for c in unicodedata.normalize("NFD", text.translate(_MICRO)) if not unicodedata.combining(c))
    return [part for word in _WORD.findall(plain) for part in _parts(word.lower())]


def _parts(word: str) -> tuple[str, ...]:
    found = _ENDS.fullmatch(word)
    return found.groups() if found else (word,)
