"""Encodings of the message definitions in .db3 files."""

import sqlite3
from contextlib import closing
from pathlib import Path

from q2q_model.bag.storage.bag_path import storage_files

READ = ("ros2msg", "ros2idl")
"""Encodings that are read."""
OTHERS = """
SELECT name, encoding FROM topics JOIN message_definitions ON type = topic_type
WHERE encoding NOT IN (?, ?) ORDER BY topics.id
"""


def unread_encoding(bag: Path) -> str:
    """Return why the first message definition of another encoding in a bag is not read; empty without one."""
    for file in storage_files(bag):
        if (found := _first_other(file)) is not None:
            topic, encoding = found
            return (
                f"{file.name}: the message definition of topic {topic} has encoding {encoding!r}; "
                f"{' and '.join(READ)} are read"
            )
    return ""


def _first_other(file: Path) -> tuple[str, str] | None:
    """Return topic and encoding; None for a file that is no database, or is older than encodings."""
    if file.suffix != ".db3":
        return None
    try:
        with closing(sqlite3.connect(f"{file.resolve().as_uri()}?immutable=1", uri=True)) as database:
            row = database.execute(OTHERS, READ).fetchone()
    except sqlite3.Error:
        return None
    return None if row is None else (str(row[0]), str(row[1]))
