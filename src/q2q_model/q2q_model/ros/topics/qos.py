"""Quality-of-service profiles.

| profile | reliability | durability | depth | used by |
|---|---|---|---|---|
| TICK_WRITER | reliable | volatile | 1000 | publishers of tick signals |
| TICK | reliable | volatile | 1 | readers of tick signals; both sides of /clock; Crazyswarm2 bridge |
| EVERY_TICK | reliable | volatile | 1000 | online identification, which joins topics by tick |
| MANY_WRITERS | reliable | volatile | 256 | readers of what every vehicle writes: commands, predictions |
| LATCHED | reliable | transient local | 1 | both sides of plans, models, summaries and status |
| OUTSIDE | best effort | volatile | 1 | readers of other software, of which the newest counts; the viewer |
| SENSOR | best effort | volatile | 100 | controllers that read accelerometers |
| EVERY_SAMPLE | best effort | volatile | 1000 | EVERY_TICK's reader, for accelerometers |
| RECORD | reliable | volatile | 100000 | recorder |
| RECORD_LATCHED | reliable | transient local | 100000 | recorder, if all publishers of a topic latch it |
| RECORD_BEST_EFFORT | best effort | volatile | 100000 | recorder, if some publisher is best effort |

A reader gets nothing from a publisher that promises less than it asks for: a best-effort reader matches any,
a transient-local one only publishers that keep their last messages for late readers. TICK_WRITER and
EVERY_TICK are equal, but one is the queue of a publisher, the other that of a reader.
"""

from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

TICK_WRITER = QoSProfile(depth=1000, reliability=ReliabilityPolicy.RELIABLE)
"""Publisher side of TICK: buffers 10 s of a topic at 100 Hz for a slow recorder."""

TICK = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE)
"""Tick signals between q2q nodes: reliable, so that lockstep never loses one."""

EVERY_TICK = QoSProfile(depth=1000, reliability=ReliabilityPolicy.RELIABLE)
"""Queue of a reader that joins topics by tick: 10 s of a topic at 100 Hz."""

MANY_WRITERS = QoSProfile(depth=256, reliability=ReliabilityPolicy.RELIABLE)
"""Tick signals of one writer for each vehicle: a depth of 1 would keep the last writer's only."""

LATCHED = QoSProfile(
    depth=1,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)
"""Plans, models, summaries: a late subscriber receives the last one."""

OUTSIDE = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
"""Streams from other software: matches any publisher."""

SENSOR = QoSProfile(depth=100, reliability=ReliabilityPolicy.BEST_EFFORT)
"""Sensors' samples from any publisher, each of which counts: 1 s at 100 Hz."""

EVERY_SAMPLE = QoSProfile(depth=EVERY_TICK.depth, reliability=ReliabilityPolicy.BEST_EFFORT)
"""Sensors' samples from any publisher for a reader that joins them by tick."""

RECORD = QoSProfile(depth=100_000, reliability=ReliabilityPolicy.RELIABLE)
"""Queue of the recorder, beyond the 5000 messages that Fast DDS 2.14 keeps: it counts the others as lost."""

RECORD_LATCHED = QoSProfile(
    depth=RECORD.depth, reliability=RECORD.reliability, durability=DurabilityPolicy.TRANSIENT_LOCAL
)
"""Queue of the recorder for a topic that all publishers latch: it gets what they sent before."""

RECORD_BEST_EFFORT = QoSProfile(depth=RECORD.depth, reliability=ReliabilityPolicy.BEST_EFFORT)
"""Queue of the recorder for a topic that some publisher sends best effort, as drivers of sensors do."""
