"""MarkerArray of a scene, for RViz and other viewers."""

from geometry_msgs.msg import Point, Pose, Vector3
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from q2q_model.ros.topics.messages import header_at, pose_message
from q2q_sim.view.shapes import ARROW_HEAD, Scene, Shape, ShapeKind

TYPES = {
    ShapeKind.BOX: Marker.CUBE,
    ShapeKind.CYLINDER: Marker.CYLINDER,
    ShapeKind.ARROW: Marker.ARROW,
    ShapeKind.LINE: Marker.LINE_STRIP,
    ShapeKind.TEXT: Marker.TEXT_VIEW_FACING,
}
BY_POINTS = (ShapeKind.ARROW, ShapeKind.LINE)
"""Shapes drawn by points, not by a pose."""


def marker_array(scene: Scene, stamp_ns: int) -> MarkerArray:
    """Return the markers of a scene; the first deletes all earlier ones."""
    header = header_at(stamp_ns)
    clear = Marker(header=header, action=Marker.DELETEALL)
    return MarkerArray(markers=[clear, *(_marker(shape, header) for shape in scene.shapes)])


def _marker(shape: Shape, header: Header) -> Marker:
    red, green, blue, opacity = shape.colour
    by_points = shape.kind in BY_POINTS
    return Marker(
        header=header,
        ns=shape.group,
        id=shape.row,
        type=TYPES[shape.kind],
        action=Marker.ADD,
        pose=Pose() if by_points else pose_message(shape.points[0], shape.quat),
        scale=_scale(shape),
        color=ColorRGBA(r=red, g=green, b=blue, a=opacity),
        points=[Point(x=x, y=y, z=z) for x, y, z in shape.points] if by_points else [],
        text=shape.text,
    )


def _scale(shape: Shape) -> Vector3:
    x, y, z = shape.size
    return Vector3(x=x, y=ARROW_HEAD * x, z=0.0) if shape.kind == ShapeKind.ARROW else Vector3(x=x, y=y, z=z)
