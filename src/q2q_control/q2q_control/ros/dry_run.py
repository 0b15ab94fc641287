"""Understand `--dry-run` on the command line of a node: it is the parameter dry_run."""

from collections.abc import Sequence

FLAG = "--dry-run"


def dry_run_as_parameter(arguments: Sequence[str]) -> list[str]:
    """Return the arguments with `--dry-run` told as ROS tells parameters."""
    rest = [one for one in arguments if one != FLAG]
    return [*rest, "--ros-args", "-p", "dry_run:=true"] if len(rest) < len(arguments) else rest
