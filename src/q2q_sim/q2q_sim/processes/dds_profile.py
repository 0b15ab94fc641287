"""Fast DDS profile: timer threads off the core of the tick, and frequent acknowledgements.

Every reliable publication sets a timer, which wakes an idle thread: on the publisher's core it preempts the
publisher three times a message. On another core a tick takes a tenth less. A profile of the user takes
precedence; other middleware ignores ours. It replaces that of q2q_model.node.loopback, so it includes it.

A reader acknowledges on the writer's heartbeat, by default every 3 s, for which a flight would wait at its
end for each topic of the recorder.

Source: Fast DDS 2.14, XML profiles, `timed_events_thread` (ThreadSettings: affinity is a mask of cores) and
`heartbeatPeriod` (WriterTimes).
"""

import os
from collections.abc import Collection, Mapping
from pathlib import Path

from q2q_model.node.loopback import PROFILE, PROFILE_VARIABLES, has_own_profile, restriction, stays_here

MOST_CORE = 63
"""Cores above this do not fit the mask."""
HEARTBEAT_NS = 100_000_000
"""Heartbeat period of writers with unacknowledged samples [ns]."""
OPEN = """<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns="http://www.eprosima.com"><profiles>
  <participant profile_name="timers_aside" is_default_profile="true"><rtps></rtps></participant>
</profiles></dds>
"""
"""Profile for nodes that are not restricted to loopback."""
TIMERS = "<timed_events_thread><affinity>{mask}</affinity></timed_events_thread>"
WRITERS = f"""<data_writer profile_name="acknowledged_soon" is_default_profile="true"><times>
    <heartbeatPeriod><sec>0</sec><nanosec>{HEARTBEAT_NS}</nanosec></heartbeatPeriod>
  </times></data_writer>"""


def profile_environment(folder: Path, cores: Collection[int]) -> Mapping[str, str]:
    """Write a profile with timers on `cores` into a folder; return its environment variables."""
    usable = [core for core in cores if core <= MOST_CORE]
    if not usable or has_own_profile(os.environ):
        return {}
    timers = TIMERS.format(mask=sum(1 << core for core in usable))
    text = PROFILE.read_text() if stays_here(os.environ) else OPEN
    path = folder / "dds_profile.xml"
    path.write_text(
        text.replace("</rtps>", f"{timers}</rtps>").replace("</profiles>", f"  {WRITERS}\n</profiles>")
    )
    return restriction(path) if stays_here(os.environ) else {PROFILE_VARIABLES[0]: str(path)}
