"""Fast DDS profile: timer threads off the core of the tick, and frequent acknowledgements.

Every reliable publication sets a timer, which wakes an idle thread: on the publisher's core it preempts the
publisher three times a message. On another core a tick takes a tenth less. A profile of the user (VARIABLES)
takes precedence; other middleware ignores ours.

A reader acknowledges on the writer's heartbeat, by default every 3 s, for which a flight would wait at its
end for each topic of the recorder.

Source: Fast DDS 2.14, XML profiles, `timed_events_thread` (ThreadSettings: affinity is a mask of cores) and
`heartbeatPeriod` (WriterTimes).
"""

import os
from collections.abc import Collection, Mapping
from pathlib import Path

VARIABLES = ("FASTRTPS_DEFAULT_PROFILES_FILE", "FASTDDS_DEFAULT_PROFILES_FILE")
"""Environment variables of a profile: up to Fast DDS 2, the version of ours, and from 3."""
MOST_CORE = 63
"""Cores above this do not fit the mask."""
HEARTBEAT_NS = 100_000_000
"""Heartbeat period of writers with unacknowledged samples [ns]."""
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
    """Write a profile with timers on `cores` into a folder; return its environment variables."""
    usable = [core for core in cores if core <= MOST_CORE]
    if not usable or any(os.environ.get(name) for name in VARIABLES):
        return {}
    path = folder / "dds_profile.xml"
    path.write_text(PROFILE.format(mask=sum(1 << core for core in usable), heartbeat=HEARTBEAT_NS))
    return {VARIABLES[0]: str(path)}
