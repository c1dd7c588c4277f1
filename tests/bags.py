"""rosbag2 folders as ROS 2 writes them, for tests."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.rosbag2.enums import CompressionFormat, CompressionMode
from rosbags.typesys import Stores, get_typestore

from dr_lab.ros2 import FLOAT64_MULTI_ARRAY, JOINT_STATE, encode_float_arrays, encode_joint_states
from dr_lab.trajectory import Array

START = 1_700_000_000_000_000_000  # ns


def write_bag(
    path: Path,
    joints: Sequence[str],
    time: Array,
    position: Array,
    *,
    command: Array | None = None,
    stamped: Array | None = None,
    storage: StoragePlugin = StoragePlugin.SQLITE3,
    compressed: bool = False,
) -> Path:
    """Joint states, and commands as a Float64MultiArray without labels, at the same times.

    Args:
        path: of the folder.
        joints: k names.
        time: s, shape (n,).
        position: rad, shape (n, k).
        command: shape (n, m).
        stamped: s, of the joint states' headers, shape (n,); as they were logged where it is None.
        storage: of the messages.
        compressed: message by message with zstd.
    """
    stamps = START + np.rint(1e9 * time).astype(np.int64)
    headers = stamps if stamped is None else START + np.rint(1e9 * stamped).astype(np.int64)
    topics = [("/joint_states", JOINT_STATE, encode_joint_states(headers, joints, position))]
    if command is not None:
        rows = encode_float_arrays([""] * command.shape[1], command)
        topics.append(("/effort_controller/commands", FLOAT64_MULTI_ARRAY, rows))
    writer = Writer(path, version=8, storage_plugin=storage)
    if compressed:
        writer.set_compression(CompressionMode.MESSAGE, CompressionFormat.ZSTD)
    store = get_typestore(Stores.ROS2_HUMBLE)
    with writer:
        for topic, kind, rows in topics:
            connection = writer.add_connection(topic, kind.name, typestore=store)
            for stamp, row in zip(stamps.tolist(), rows, strict=True):
                writer.write(connection, stamp, row.tobytes())
    return path
