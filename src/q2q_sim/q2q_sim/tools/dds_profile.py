"""Keep Fast DDS's timer threads off the core on which a tick is computed.

Every reliable publication sets a timer, and so wakes a thread that does nothing: on the publisher's core it
pushes the publisher aside three times a message. On another core a tick takes a tenth less. A profile of the
user's own (FASTDDS_DEFAULT_PROFILES_FILE, or its old name) is left alone; another middleware ignores ours.

Source: Fast DDS 2.14, XML profiles, `timed_events_thread` (ThreadSettings: affinity is a mask of cores).
"""

import os
from collections.abc import Collection, Mapping
from pathlib import Path

VARIABLES = ("FASTDDS_DEFAULT_PROFILES_FILE", "FASTRTPS_DEFAULT_PROFILES_FILE")
MOST_CORE = 63
"""Cores above this do not fit the mask."""
PROFILE = """<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns="http://www.eprosima.com"><profiles>
  <participant profile_name="timers_aside" is_default_profile="true"><rtps>
    <timed_events_thread><affinity>{mask}</affinity></timed_events_thread>
  </rtps></participant>
</profiles></dds>
"""


def profile_environment(folder: Path, cores: Collection[int]) -> Mapping[str, str]:
    """Write a profile that keeps timers on `cores` into a folder; return what tells Fast DDS of it."""
    usable = [core for core in cores if core <= MOST_CORE]
    if not usable or any(os.environ.get(name) for name in VARIABLES):
        return {}
    path = folder / "dds_profile.xml"
    path.write_text(PROFILE.format(mask=sum(1 << core for core in usable)))
    return {VARIABLES[0]: str(path)}
