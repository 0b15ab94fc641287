"""Quality-of-service profiles."""

from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

TICK = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE)
"""Tick signals between q2q nodes: reliable, so that lockstep never loses one."""

TICK_WRITER = QoSProfile(depth=1000, reliability=ReliabilityPolicy.RELIABLE)
"""Publisher side of TICK: buffers 10 s of a topic at 100 Hz for a slow recorder."""

LATCHED = QoSProfile(
    depth=1,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)
"""Plans, models, summaries: a late subscriber receives the last one."""

OUTSIDE = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
"""Streams from other software: matches any publisher."""

EVERY_TICK = QoSProfile(depth=1000, reliability=ReliabilityPolicy.RELIABLE)
"""Queue of a reader that joins topics by tick: 10 s of a topic at 100 Hz."""

RECORD = QoSProfile(depth=100_000, reliability=ReliabilityPolicy.RELIABLE)
"""Queue of the recorder, beyond the 5000 messages that Fast DDS 2.14 keeps: it counts the others as lost."""

RECORD_BEST_EFFORT = QoSProfile(depth=RECORD.depth, reliability=ReliabilityPolicy.BEST_EFFORT)
"""Queue of the recorder for a topic that some publisher sends best effort, as drivers of sensors do."""

RECORD_LATCHED = QoSProfile(
    depth=RECORD.depth, reliability=RECORD.reliability, durability=DurabilityPolicy.TRANSIENT_LOCAL
)
"""Queue of the recorder for a topic that all publishers latch: it gets what they sent before."""

SENSOR = QoSProfile(depth=100, reliability=ReliabilityPolicy.BEST_EFFORT)
"""Sensors' samples from any publisher, each of which counts: 1 s at 100 Hz."""

EVERY_SAMPLE = QoSProfile(depth=EVERY_TICK.depth, reliability=ReliabilityPolicy.BEST_EFFORT)
"""Sensors' samples from any publisher for a reader that joins them by tick."""

MANY_WRITERS = QoSProfile(depth=256, reliability=ReliabilityPolicy.RELIABLE)
"""Tick signals of one writer for each vehicle: a depth of 1 would keep the last writer's only."""
