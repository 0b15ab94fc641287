"""Fast DDS profile: timer threads seldom awake and off the core of the tick, and frequent acknowledgements.

A reliable publication starts a timer for each reader, until whose end requests to send the sample again are
ignored. By default it ends at once, in a thread that wakes for every reader and message, and waits for the
lock of the writer that is still sending. One of SUPPRESSION_NS covers the messages that follow, and a tick
switches threads 35 times instead of 57. On another core than the tick, the thread does not preempt it.

A reader acknowledges on the writer's heartbeat, by default every 3 s, for which a flight would wait at its
end for each topic of the recorder.

A profile of the user takes precedence; other middleware ignores ours. It replaces that of
q2q_model.node.loopback, so it includes it.

Source: Fast DDS 2.14, XML profiles, `timed_events_thread` (ThreadSettings: affinity is a mask of cores),
`heartbeatPeriod` and `nackSupressionDuration` (WriterTimes); StatefulWriter.cpp, ReaderProxy.cpp.
"""

import os
from collections.abc import Collection, Mapping
from pathlib import Path

from q2q_model.node.loopback import PROFILE, PROFILE_VARIABLES, has_own_profile, restriction, stays_here

MOST_CORE = 63
"""Cores above this do not fit the mask."""
HEARTBEAT_NS = 100_000_000
"""Heartbeat period of writers with unacknowledged samples [ns]."""
SUPPRESSION_NS = 50_000_000
"""Time for which a writer ignores requests for samples that it has just sent [ns]; it also asks for no
acknowledgement of these, so it is shorter than HEARTBEAT_NS."""
OPEN = """<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns="http://www.eprosima.com"><profiles>
  <participant profile_name="timers_aside" is_default_profile="true"><rtps></rtps></participant>
</profiles></dds>
"""
"""Profile for nodes that are not restricted to loopback."""
TIMERS = "<timed_events_thread><affinity>{mask}</affinity></timed_events_thread>"
WRITERS = f"""<data_writer profile_name="acknowledged_soon" is_default_profile="true"><times>
    <heartbeatPeriod><sec>0</sec><nanosec>{HEARTBEAT_NS}</nanosec></heartbeatPeriod>
    <nackSupressionDuration><sec>0</sec><nanosec>{SUPPRESSION_NS}</nanosec></nackSupressionDuration>
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
