"""Recorded flights as rosbag2 bags, read and written without ROS.

The writer makes a folder with `metadata.yaml` (version 9) and `<name>_0.mcap`: checksummed chunks of one
second compressed with zstd, and for every channel its ros2msg definition, type hash and offered QoS, as `ros2
bag record` of ROS 2 Jazzy does. The reader takes these, other rosbag2 bags (MCAP, sqlite3), and ROS 1 bags by
a topic map.
"""

from q2q_model.bag.flight_facts import FlightFacts, facts_as_text, facts_from_text, read_facts
from q2q_model.bag.flight_in_bag import read_flight
from q2q_model.bag.foreign.mapped_flight import read_mapped_flight
from q2q_model.bag.foreign.mapped_messages import MappedBag
from q2q_model.bag.foreign.topic_map import TopicMap, load_topic_map
from q2q_model.bag.log_topic import LOG_TOPIC, read_flight_log, write_log_row
from q2q_model.bag.reader import BagReader, RawMessage, TimedSignal
from q2q_model.bag.storage.bag_path import is_bag
from q2q_model.bag.storage.errors import BagError, BagRepairWarning
from q2q_model.bag.writer import BagWriter, OfferedQos

__all__ = [
    "LOG_TOPIC",
    "BagError",
    "BagReader",
    "BagRepairWarning",
    "BagWriter",
    "FlightFacts",
    "MappedBag",
    "OfferedQos",
    "RawMessage",
    "TimedSignal",
    "TopicMap",
    "facts_as_text",
    "facts_from_text",
    "is_bag",
    "load_topic_map",
    "read_facts",
    "read_flight",
    "read_flight_log",
    "read_mapped_flight",
    "write_log_row",
]
