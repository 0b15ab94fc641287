"""Command line of a node: what may stand next to the arguments for ROS.

ROS itself ignores a word that it does not know, so a misspelt `--dry-run` would fly.
"""

from collections.abc import Mapping, Sequence
from typing import NoReturn

from q2q_model.commands.command_line import CommandLine
from q2q_model.commands.ros_arguments import ROS_ARGS, outside_ros

HOW = f"parameters follow {ROS_ARGS}: {ROS_ARGS} -p name:=value"


class NodeCommandLine(CommandLine):
    """Parser of the words that are not for ROS: `--help`, and options that stand for parameters."""

    def __init__(self, package: str, name: str, about: str | None, flags: Mapping[str, str]) -> None:
        """Create the parser of a node.

        Args:
            package: of the node.
            name: of the node.
            about: what the node does.
            flags: parameters that an option sets to true, each with its meaning: `dry_run` by `--dry-run`.
        """
        super().__init__(name, about, f"  ros2 run {package} {name} {ROS_ARGS} -p name:=value")
        self._flags = tuple(flags)
        for parameter, meaning in flags.items():
            self.add_argument(f"--{parameter.replace('_', '-')}", action="store_true", help=meaning)

    def error(self, message: str) -> NoReturn:
        """Exit with status 2 and one line that says where parameters belong."""
        super().error(f"{message}; {HOW}" if ":=" in message else message)

    def for_ros(self, argv: Sequence[str]) -> list[str]:
        """Return the arguments for ROS; exit with 0 after `--help`, with 2 on an unknown word.

        Args:
            argv: arguments of the process, without its name.
        """
        given = vars(self.parse_args(outside_ros(argv)))
        set_true = [f"{name}:=true" for name in self._flags if given[name]]
        return [*argv, *(word for one in set_true for word in (ROS_ARGS, "-p", one))]
