"""Turn arguments and nodes into a launch description; used by the launch files, needs `launch_ros`."""

from collections.abc import Callable, Mapping, Sequence

from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from launch import LaunchContext, LaunchDescription
from q2q_sim.tools.launching import Argument
from q2q_sim.tools.processes import NodeSpec


def describe(
    arguments: Sequence[Argument],
    nodes: Callable[[Mapping[str, str]], list[NodeSpec]],
    renamed: Mapping[str, str] | None = None,
) -> LaunchDescription:
    """Return the description; `renamed` maps a topic to the argument that holds its outside name."""

    def start(context: LaunchContext) -> list[Node]:
        given = {one.name: LaunchConfiguration(one.name).perform(context) for one in arguments}
        names = [(topic, given[argument]) for topic, argument in (renamed or {}).items()]
        return [_node(spec, names) for spec in nodes(given)]

    return LaunchDescription([*map(_declared, arguments), OpaqueFunction(function=start)])


def _declared(one: Argument) -> DeclareLaunchArgument:
    return DeclareLaunchArgument(
        one.name, default_value=one.default, description=one.words, choices=list(one.choices) or None
    )


def _node(spec: NodeSpec, names: list[tuple[str, str]]) -> Node:
    values = {
        key: list(value) if isinstance(value, tuple) else value for key, value in spec.parameters.items()
    }
    return Node(
        package=spec.package,
        executable=spec.executable,
        name=spec.executable,
        parameters=[{key: value for key, value in values.items() if value != []}],
        remappings=[(topic, outside) for topic, outside in names if topic != outside],
        output="screen",
    )
