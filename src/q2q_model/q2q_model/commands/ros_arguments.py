"""Words of a command line that are for ROS: those from `--ros-args` to a `--`, or to the end."""

import sys
from collections.abc import Sequence

ROS_ARGS = "--ros-args"
"""Start of the arguments for ROS, which a launch file adds to every program."""


def outside_ros(arguments: Sequence[str] | None) -> list[str]:
    """Return the words (None: those of sys.argv) before `--ros-args`, and after a `--` that ends these."""
    return split_at_ros(arguments)[0]


def split_at_ros(arguments: Sequence[str] | None) -> tuple[list[str], list[str]]:
    """Return the words (None: those of sys.argv) as of `outside_ros`, and those that are for ROS."""
    own, ros, of_ros = list[str](), list[str](), False
    for word in sys.argv[1:] if arguments is None else arguments:
        if of_ros and word == "--":
            of_ros = False
        elif word == ROS_ARGS:
            of_ros = True
        else:
            (ros if of_ros else own).append(word)
    return own, ros
