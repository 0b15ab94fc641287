"""Name the qualities of service of the house."""

from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

TICK = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE)
"""Signals of a tick between our nodes: reliable, so that lockstep never loses one."""

TICK_WRITER = QoSProfile(depth=1000, reliability=ReliabilityPolicy.RELIABLE)
"""The writer's side of TICK: it keeps what a slow recorder has not taken yet, 10 s of a topic at 100 Hz."""

LATCHED = QoSProfile(
    depth=1,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)
"""Plans, models, summaries: a late reader gets the last one."""

OUTSIDE = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
"""Streams from other software, read without a deadline: matches any writer."""

RECORD = QoSProfile(depth=1000, reliability=ReliabilityPolicy.RELIABLE)
"""The recorder's queue: 10 s of a topic at 100 Hz."""
