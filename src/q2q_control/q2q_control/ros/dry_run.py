"""Option `--dry-run` of a node's command line, as its parameter dry_run."""

from collections.abc import Sequence

FLAG = "--dry-run"


def dry_run_as_parameter(arguments: Sequence[str]) -> list[str]:
    """Return the arguments with `--dry-run` as a ROS parameter."""
    rest = [one for one in arguments if one != FLAG]
    return [*rest, "--ros-args", "-p", "dry_run:=true"] if len(rest) < len(arguments) else rest
