"""Copy of a bag with some of its topics: keep_topics.py BAG OUT TOPIC...

`fly --record` adds what verdict and numbers need; the bags kept here hold only what their readers use.
"""

import sys
from collections.abc import Sequence
from pathlib import Path

from q2q_model.bag import BagReader, BagWriter, read_facts


def keep_topics(bag: Path, out: Path, topics: Sequence[str]) -> None:
    """Write the messages of `topics` in `bag`, with its facts, to a new bag `out`."""
    reader = BagReader(bag)
    with BagWriter(out, read_facts(bag)) as writer:
        for topic in topics:
            writer.add_topic(topic, reader.topics[topic])
        for message in reader.raw(topics):
            writer.write_raw(message.topic, message.stamp_ns, message.data)


if __name__ == "__main__":
    keep_topics(Path(sys.argv[1]), Path(sys.argv[2]), [f"/{topic}" for topic in sys.argv[3:]])
