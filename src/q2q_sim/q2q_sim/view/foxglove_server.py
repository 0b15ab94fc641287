"""Foxglove server of a scene, on this machine only.

The SDK (foxglove-sdk) is optional: it is imported when a server is opened.
"""

from typing import TYPE_CHECKING

from q2q_model.node.loopback import LOOPBACK
from q2q_model.signals.stamps import stamp_parts
from q2q_model.signals.values import Three
from q2q_sim.view.shapes import ARROW_HEAD, Scene, Shape, ShapeKind, arrow_quat

if TYPE_CHECKING:
    from foxglove import messages

TOPIC = "/scene"
WORLD = "world"
HEAD_LENGTH = 0.05
"""Length of an arrow's head [m]."""


class FoxgloveScene:
    """Foxglove server with its channels."""

    def __init__(self, port: int) -> None:
        """Listen on a port of this machine; with 0 the system chooses.

        Raises:
            ValueError: foxglove-sdk is not installed.
            OSError: the port is taken.
        """
        try:
            import foxglove
            from foxglove import channels, messages
        except ImportError as missing:
            raise ValueError(
                "foxglove: foxglove-sdk is not installed: pip install -r requirements/view.txt, "
                "or leave foxglove:=false"
            ) from missing
        context = self._context = foxglove.Context()  # kept: channels end with their context
        try:
            self._server = foxglove.start_server(name="q2q", host=LOOPBACK, port=port, context=context)
        except RuntimeError as refusal:
            raise OSError(f"foxglove: port {port}: {refusal}") from refusal
        self._channel = channels.SceneUpdateChannel(TOPIC, context=context)
        self._messages = messages
        self._shown: set[str] = set()

    @property
    def port(self) -> int:
        """Return the port it listens on."""
        return int(self._server.port)

    def show(self, scene: Scene, stamp_ns: int) -> None:
        """Replace the scene."""
        sec, nanosec = stamp_parts(stamp_ns)
        stamp = self._messages.Timestamp(sec=sec, nsec=nanosec)
        entities = [self._entity(shape, scene, stamp) for shape in scene.shapes]
        now = {_name(shape, scene) for shape in scene.shapes}
        gone = [
            self._messages.SceneEntityDeletion(
                timestamp=stamp, type=self._messages.SceneEntityDeletionType.MatchingId, id=name
            )
            for name in sorted(self._shown - now)
        ]
        self._shown = now
        self._channel.log(self._messages.SceneUpdate(entities=entities, deletions=gone), log_time=stamp_ns)

    def close(self) -> None:
        """Close the server."""
        self._server.stop()

    def _entity(self, shape: Shape, scene: Scene, stamp: "messages.Timestamp") -> "messages.SceneEntity":
        red, green, blue, opacity = shape.colour
        colour = self._messages.Color(r=red, g=green, b=blue, a=opacity)
        name, parts = _name(shape, scene), self._parts(shape, colour)
        return self._messages.SceneEntity(timestamp=stamp, frame_id=WORLD, id=name, **parts)

    def _parts(self, shape: Shape, colour: "messages.Color") -> "dict[str, list[messages.CubePrimitive]]":
        """Return the primitives of a shape by the entity's field they belong to."""
        match shape.kind:
            case ShapeKind.BOX:
                pose, size = self._pose(shape), self._size(shape)
                return {"cubes": [self._messages.CubePrimitive(pose=pose, size=size, color=colour)]}
            case ShapeKind.CYLINDER:
                return {"cylinders": [self._cylinder(shape, colour)]}
            case ShapeKind.TEXT:
                return {"texts": [self._text(shape, colour)]}
            case ShapeKind.ARROW:
                return {"arrows": [self._arrow(shape, colour)]}
            case ShapeKind.LINE:
                return {"lines": [self._line(shape, colour)]}

    def _cylinder(self, shape: Shape, colour: "messages.Color") -> "messages.CylinderPrimitive":
        pose, size = self._pose(shape), self._size(shape)
        return self._messages.CylinderPrimitive(
            pose=pose, size=size, bottom_scale=1.0, top_scale=1.0, color=colour
        )

    def _text(self, shape: Shape, colour: "messages.Color") -> "messages.TextPrimitive":
        pose, height = self._pose(shape), shape.size[2]
        return self._messages.TextPrimitive(
            pose=pose, billboard=True, font_size=height, color=colour, text=shape.text
        )

    def _pose(self, shape: Shape) -> "messages.Pose":
        x, y, z = shape.points[0]
        quat = arrow_quat(*shape.points[:2]) if shape.kind == ShapeKind.ARROW else shape.quat
        qx, qy, qz, qw = quat
        make = self._messages
        return make.Pose(
            position=make.Vector3(x=x, y=y, z=z), orientation=make.Quaternion(x=qx, y=qy, z=qz, w=qw)
        )

    def _size(self, shape: Shape) -> "messages.Vector3":
        x, y, z = shape.size
        return self._messages.Vector3(x=x, y=y, z=z)

    def _arrow(self, shape: Shape, colour: "messages.Color") -> "messages.ArrowPrimitive":
        length, width = _length(*shape.points), shape.size[0]
        head = min(HEAD_LENGTH, length)
        return self._messages.ArrowPrimitive(
            pose=self._pose(shape),
            shaft_length=length - head,
            shaft_diameter=width,
            head_length=head,
            head_diameter=ARROW_HEAD * width,
            color=colour,
        )

    def _line(self, shape: Shape, colour: "messages.Color") -> "messages.LinePrimitive":
        make = self._messages
        return make.LinePrimitive(
            type=make.LinePrimitiveLineType.LineStrip,
            pose=make.Pose(position=make.Vector3(), orientation=make.Quaternion(w=1.0)),
            thickness=shape.size[0],
            points=[make.Point3(x=x, y=y, z=z) for x, y, z in shape.points],
            color=colour,
        )


def _name(shape: Shape, scene: Scene) -> str:
    return f"{shape.group}/{scene.names[shape.row]}"


def _length(tail: Three, tip: Three) -> float:
    return float(sum((to - start) ** 2 for start, to in zip(tail, tip, strict=True)) ** 0.5)
