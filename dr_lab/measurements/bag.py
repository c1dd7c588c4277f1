"""rosbag2 logs: ``.db3`` files, and folders with a metadata.yaml whatever their storage.

Their messages are those of an MCAP file; they are written into one, and read as such.
"""

import shutil
import tempfile
import weakref
from collections.abc import Iterable, Mapping
from pathlib import Path

from mcap.writer import CompressionType, Writer
from rosbags.interfaces import Connection, MessageDefinitionFormat
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore

from dr_lab.errors import DataError
from dr_lab.measurements.field_list import BULKY
from dr_lab.measurements.mcap import McapSource, Topic
from dr_lab.trajectory import Note

_FILE = "messages.mcap"
_REMEDY = "Record with ROS 2 Jazzy or later, which stores definitions, or run ros2 bag convert where the type is known."


class BagSource(McapSource):
    """A bag, read from an MCAP file that lasts as long as this object.

    Pictures and other bulky messages are not taken along. Bags before ROS 2 Jazzy hold no message definitions; those
    that ROS itself ships are known, and topics of other types are left out.

    Args:
        path: ``.db3`` file or bag folder.

    Raises:
        DataError: it cannot be read, or holds no messages.
    """

    def __init__(self, path: Path) -> None:
        folder = Path(tempfile.mkdtemp(prefix="dr_lab_bag_"))
        weakref.finalize(self, shutil.rmtree, folder, ignore_errors=True)
        self._unknown = _convert(path, folder / _FILE)
        super().__init__(folder / _FILE, path)

    @property
    def notes(self) -> tuple[Note, ...]:
        """Those of the messages, and the topics whose type nothing describes."""
        if not self._unknown:
            return super().notes
        message = f"{self.name}: {self._undefined(self._unknown)}; left out."
        return (*super().notes, Note("undefined", "", message, len(self._unknown)))

    def _undefined(self, topics: Iterable[str]) -> str:
        return f"no definition of {', '.join(f'{topic} ({self._unknown[topic]})' for topic in topics)}"

    def _without_messages(self) -> str:
        if not self._unknown:
            return super()._without_messages()
        return f"{self._origin}: {self._undefined(self._unknown)}, and nothing else is in it. {_REMEDY}"

    def _topic(self, name: str) -> Topic:
        if name in self._unknown:
            raise DataError(f"Topic {name!r} of {self.name} cannot be read: {self._undefined([name])}. {_REMEDY}")
        return super()._topic(name)


def _convert(path: Path, target: Path) -> dict[str, str]:
    """Write a bag's messages into an MCAP file; returns the topics left out, with their types."""
    try:
        with Reader(path) as reader, target.open("wb") as file:
            wanted = [c for c in reader.connections if c.msgtype not in BULKY]
            texts = {c.id: text for c in wanted if (text := _definition(c)) is not None}
            _write(reader, texts, Writer(file, compression=CompressionType.NONE))
            return {c.topic: c.msgtype for c in wanted if c.id not in texts}
    except Exception as error:  # rosbags', SQLite's, zstd's and the system's own, depending on the bytes
        raise DataError(
            f"Cannot read {path}: {str(error).rstrip('.') or type(error).__name__}. Expected what rosbag2 writes (a "
            ".db3 file, or a folder with metadata.yaml and its files). Copy it again, restore metadata.yaml with "
            "ros2 bag reindex, or leave it out of logs."
        ) from error


def _write(reader: Reader, texts: Mapping[int, str], writer: Writer) -> None:
    writer.start(profile="ros2", library="dr_lab")
    known = [c for c in reader.connections if c.id in texts]
    channels = {
        c.id: writer.register_channel(
            c.topic, "cdr", writer.register_schema(c.msgtype, "ros2msg", texts[c.id].encode())
        )
        for c in known
    }
    messages = reader.messages(known) if known else ()  # an empty choice would mean all topics
    for number, (connection, time, data) in enumerate(messages):
        writer.add_message(channels[connection.id], log_time=time, publish_time=time, data=data, sequence=number)
    writer.finish()


def _definition(connection: Connection) -> str | None:
    """Text of a topic's message definition: the bag's own, or that which ROS ships; None where unknown."""
    own = connection.msgdef
    if own.format == MessageDefinitionFormat.MSG and own.data:
        return own.data
    store = get_typestore(Stores.LATEST)
    known = connection.msgtype in store.fielddefs
    return store.generate_msgdef(connection.msgtype, ros_version=2)[0] if known else None
