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

RECORD = QoSProfile(depth=1000, reliability=ReliabilityPolicy.RELIABLE)
"""Queue of the recorder: 10 s of a topic at 100 Hz."""

MANY_WRITERS = QoSProfile(depth=256, reliability=ReliabilityPolicy.RELIABLE)
"""Tick signals of one writer for each vehicle: a depth of 1 would keep the last writer's only."""
