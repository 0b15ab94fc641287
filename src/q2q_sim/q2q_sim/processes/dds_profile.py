"""Keep Fast DDS's timer threads off the core on which a tick is computed, and have it acknowledge soon.

Every reliable publication sets a timer, and so wakes a thread that does nothing: on the publisher's core it
pushes the publisher aside three times a message. On another core a tick takes a tenth less. A profile of the
user's own (VARIABLES) is left alone; another middleware ignores ours.

A reader says what it has taken when its writer asks, by default every 3 s: a flight that waits at its end
until all is with the recorder would wait that long for one topic after another.

Source: Fast DDS 2.14, XML profiles, `timed_events_thread` (ThreadSettings: affinity is a mask of cores) and
`heartbeatPeriod` (WriterTimes).
"""

import os
from collections.abc import Collection, Mapping
from pathlib import Path

VARIABLES = ("FASTRTPS_DEFAULT_PROFILES_FILE", "FASTDDS_DEFAULT_PROFILES_FILE")
"""What names a profile: up to Fast DDS 2, whose form ours has, and from 3 on."""
MOST_CORE = 63
"""Cores above this do not fit the mask."""
HEARTBEAT_NS = 100_000_000
"""How often a writer asks its readers what they have, while they have not acknowledged all [ns]."""
PROFILE = """<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns="http://www.eprosima.com"><profiles>
  <participant profile_name="timers_aside" is_default_profile="true"><rtps>
    <timed_events_thread><affinity>{mask}</affinity></timed_events_thread>
  </rtps></participant>
  <data_writer profile_name="acknowledged_soon" is_default_profile="true"><times>
    <heartbeatPeriod><sec>0</sec><nanosec>{heartbeat}</nanosec></heartbeatPeriod>
  </times></data_writer>
</profiles></dds>
"""


def profile_environment(folder: Path, cores: Collection[int]) -> Mapping[str, str]:
    """Write a profile that keeps timers on `cores` into a folder; return what tells Fast DDS of it."""
    usable = [core for core in cores if core <= MOST_CORE]
    if not usable or any(os.environ.get(name) for name in VARIABLES):
        return {}
    path = folder / "dds_profile.xml"
    path.write_text(PROFILE.format(mask=sum(1 << core for core in usable), heartbeat=HEARTBEAT_NS))
    return {VARIABLES[0]: str(path)}
