"""Whether the chunks of an MCAP file are what was written: Rerun's reader goes on with the numbers of damaged ones."""

from io import BytesIO
from pathlib import Path
from typing import BinaryIO

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.reader import SeekingReader
from mcap.records import Chunk, ChunkIndex
from mcap.stream_reader import get_chunk_data_stream

_HEAD = 9  # bytes of a record's opcode and length


def damaged_chunks(path: Path, topic: str) -> tuple[int, int]:
    """How many of the chunks that hold a topic are damaged, by their place and their checksum, and how many there are.

    Args:
        path: a file with a summary, which says where the chunks lie; without one nothing is checked.
        topic: only its chunks are read.
    """
    with path.open("rb") as file:
        try:
            summary = SeekingReader(file).get_summary()
        except Exception:  # struct's, Unicode's, MCAP's own, depending on the bytes
            summary = None
        if summary is None:
            return 0, 0
        numbers = {number for number, channel in summary.channels.items() if channel.topic == topic}
        places = [
            p for p in summary.chunk_indexes if not p.message_index_offsets or numbers & {*p.message_index_offsets}
        ]
        return sum(not _is_whole(file, place) for place in places), len(places)


def _is_whole(file: BinaryIO, index: ChunkIndex) -> bool:
    file.seek(index.chunk_start_offset)
    head, body = file.read(_HEAD), file.read(index.chunk_length - _HEAD)
    if head != bytes([Opcode.CHUNK]) + len(body).to_bytes(8, "little"):
        return False
    try:
        get_chunk_data_stream(Chunk.read(ReadDataStream(BytesIO(body))), validate_crc=True)
    except Exception:  # struct's, Unicode's, the decompressor's, MCAP's own, depending on the bytes
        return False
    return True
