"""Bags as `ros2 bag record` writes them, of logs of robots."""

from __future__ import annotations

from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

STORE = get_typestore(Stores.ROS2_JAZZY)
STRING = "std_msgs/msg/String"


def write_bag(folder, topics, storage="mcap", kind=STRING):
    """Write a bag with a text per message, the messages of all topics in turn; return its folder."""
    plugin = StoragePlugin[storage.upper()]
    with Writer(folder, version=9, storage_plugin=plugin) as bag:
        ways = {topic: bag.add_connection(topic, kind, typestore=STORE) for topic in topics}
        for at in range(max(map(len, topics.values()))):
            for topic, texts in topics.items():
                if at < len(texts):
                    message = STORE.types[kind](texts[at])
                    bag.write(ways[topic], 1_000_000_000 + 1_000 * at, STORE.serialize_cdr(message, kind))
    return folder
