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
_ASKED = re.compile("(soll)(.{3,})")  # German compounds begin so: Sollweg
_OFTEN_CUT = ("velocity", "velocidad", "reference", "referencia", "position", "posicion")
_FEWEST = 6  # letters that are left of a cut word; fewer begin other words, too


def tokens(text: str) -> list[str]:
    """Lower-case words and numbers of a name, without accents; compound words are taken apart."""
    plain = "".join(c for c in unicodedata.normalize("NFD", text.translate(_MICRO)) if not unicodedata.combining(c))
    return [part for word in _WORD.findall(plain) for part in _parts(word.lower())]


def _parts(word: str) -> tuple[str, ...]:
    for pattern in (_ASKED, _ENDS):
        if found := pattern.fullmatch(word):
            return tuple(part for whole in found.groups() for part in _parts(whole))
    return (_whole(word),)


def _whole(word: str) -> str:
    """The word that programs cut which store eight letters: VELOCIDA, REFERENC."""
    return next((each for each in _OFTEN_CUT if len(word) >= _FEWEST and each.startswith(word)), word)
