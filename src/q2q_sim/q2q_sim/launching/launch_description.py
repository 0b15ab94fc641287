"""Launch description from arguments and nodes, for the launch files; needs `launch_ros`."""

from collections.abc import Callable, Mapping, Sequence

from launch.actions import DeclareLaunchArgument, LogInfo, OpaqueFunction, Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from launch import LaunchContext, LaunchDescription, LaunchDescriptionEntity
from q2q_sim.launching.launch_arguments import COMMON_ARGUMENTS, YES, Argument, undeclared
from q2q_sim.launching.launched_nodes import ENDS_ALL
from q2q_sim.processes.processes import NodeSpec, plain_values


def describe_launch(
    arguments: Sequence[Argument],
    nodes: Callable[[Mapping[str, str]], list[NodeSpec]],
    renamed: Mapping[str, str] | None = None,
    others: Callable[[Mapping[str, str]], list[LaunchDescriptionEntity]] = lambda _: [],
) -> LaunchDescription:
    """Return the description; arguments that it does not have are ignored, with a warning.

    Args:
        arguments: of the launch file; `namespace` and `use_sim_time` are added.
        nodes: returns the nodes, or raises ValueError before any is started.
        renamed: maps a topic to the argument with its outside name.
        others: returns further actions, such as the launch file of another package.
    """

    def start(context: LaunchContext) -> list[LaunchDescriptionEntity]:
        given = {one.name: LaunchConfiguration(one.name).perform(context) for one in every}
        warning = undeclared(context.launch_configurations, given)
        names = [(topic, given[argument]) for topic, argument in (renamed or {}).items()]
        started = [*(_node(spec, names, given) for spec in nodes(given)), *others(given)]
        return [*([LogInfo(msg=warning)] if warning else []), *started]

    every = (*arguments, *COMMON_ARGUMENTS)
    return LaunchDescription([*map(_declared, every), OpaqueFunction(function=start)])


def _declared(one: Argument) -> DeclareLaunchArgument:
    return DeclareLaunchArgument(
        one.name, default_value=one.default, description=one.description, choices=list(one.choices) or None
    )


def _node(spec: NodeSpec, names: list[tuple[str, str]], given: Mapping[str, str]) -> Node:
    return Node(
        package=spec.package,
        executable=spec.executable,
        name=spec.executable,
        namespace=given["namespace"],
        parameters=[plain_values(spec.parameters) | {"use_sim_time": given["use_sim_time"] == YES}],
        remappings=[(topic, outside) for topic, outside in names if topic != outside],
        output="screen",
        on_exit=Shutdown(reason=f"{spec.executable} has ended") if spec.executable in ENDS_ALL else None,
    )
