"""Parameters of the bag playback node."""

from dataclasses import dataclass

from q2q_model.tunable import check_bounds, tunable


@dataclass(frozen=True, slots=True)
class PlayParams:
    """Parameters of `bag_play`."""

    bag: str = tunable("", "bag folder to play", read_only=True)
    rate: float = tunable(
        1.0, "speed of playback relative to the recording", low=0.001, high=1000.0, read_only=True
    )
    start: float = tunable(
        0.0,
        "time to skip, from the first message of the bag, whether or not its topic is played",
        unit="s",
        low=0.0,
        read_only=True,
    )
    loop: bool = tunable(False, "start again at the end of the bag", read_only=True)  # noqa: FBT003
    topics: tuple[str, ...] = tunable((), "topics to play; empty: all", read_only=True)
    topic_map: str = tunable(
        "", "topic map of a bag that q2q did not record, as for `identify --topics`", read_only=True
    )
    clock: bool = tunable(False, "publish /clock with the bag's time", read_only=True)  # noqa: FBT003
    wait_for: str = tunable(
        "",
        "topic to wait for: the next tick is played once a message on it has the stamp of the current"
        " tick; empty: messages are played at `rate`",
        read_only=True,
    )
    autostart: bool = tunable(
        default=True,
        description="play as soon as readers are matched; false: when ~/start is called",
        read_only=True,
    )

    def __post_init__(self) -> None:
        """Check the bounds."""
        check_bounds(self)
