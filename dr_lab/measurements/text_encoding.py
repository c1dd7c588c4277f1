"""The encoding of a text file, which no text file says."""

import codecs
from itertools import pairwise

import pyarrow as pa

_UTF_16 = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
_CHUNK = 1 << 20  # bytes that are decoded at a time


def as_utf8(content: pa.Buffer) -> tuple[pa.Buffer, str]:
    """The text as UTF-8, and what it was read as, if that is something else; else an empty name.

    1. A text that begins with the byte order mark of UTF-16 is that, as PowerShell and LabVIEW write it.
    2. What is valid UTF-8 is UTF-8.
    3. All else is read as Latin-1, the Western European encoding of older programs, in which any bytes are valid: its
       numbers are right in any case.

    Raises:
        UnicodeError: it is no text, or begins as UTF-16 does and goes on as something else.
    """
    if bytes(content[:2]) in _UTF_16:
        return _recoded(content, "utf-16"), "UTF-16"
    if b"\0" in bytes(content[:_CHUNK]):
        raise UnicodeError("it holds zero bytes, as no text does")
    if _is_utf8(content):
        return content, ""
    return _recoded(content, "latin-1"), "Latin-1"


def _recoded(content: pa.Buffer, encoding: str) -> pa.Buffer:
    return pa.py_buffer(bytes(content).decode(encoding).encode())


def _is_utf8(content: pa.Buffer) -> bool:
    decoder = codecs.getincrementaldecoder("utf-8")()
    try:
        for start, end in pairwise([*range(0, len(content), _CHUNK), len(content)]):
            decoder.decode(bytes(content[start:end]))
        decoder.decode(b"", final=True)
    except UnicodeDecodeError:
        return False
    return True
