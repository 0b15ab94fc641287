"""Substitutes for Crazyswarm2's interface packages, which the ROS wheels lack: fields only.

Definitions: crazyflie_interfaces 1.0.5, motion_capture_tracking_interfaces 1.0.5, and the NamedPose of before
December 2021, which had no name of its own.
"""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from types import ModuleType

FIELDS: dict[str, dict[str, tuple[str, ...]]] = {
    "crazyflie_interfaces.msg": {
        "FullState": ("header", "pose", "twist", "acc"),
        "Status": ("header", "supervisor_info", "battery_voltage", "pm_state", "rssi"),
        "LogDataGeneric": ("header", "timestamp", "values"),
    },
    "crazyflie_interfaces.srv": {
        "Takeoff": ("group_mask", "height", "duration"),
        "Land": ("group_mask", "height", "duration"),
        "Arm": ("arm",),
        "NotifySetpointsStop": ("group_mask", "remain_valid_millisecs"),
    },
    "motion_capture_tracking_interfaces.msg": {
        "NamedPoseArray": ("header", "poses"),
        "NamedPoseArrayV2": ("header", "timestamp", "latencies", "poses"),
        "NamedPose": ("name", "pose"),
    },
}
OLD_NAMED_POSE = ("header", "pose", "twist", "acc")


class Fields:
    """Message with fixed fields; other names are refused."""

    names: tuple[str, ...] = ()

    def __init__(self, **values: object) -> None:
        unknown = values.keys() - set(self.names)
        if unknown:
            raise AttributeError(f"{type(self).__name__} has no field {', '.join(sorted(unknown))}")
        self._given = values

    def __getattr__(self, name: str) -> object:
        """Return a field."""
        if name in self.__dict__.get("_given", {}):
            return self._given[name]
        raise AttributeError(f"{type(self).__name__} has no field {name}, or it was not set")

    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]:
        """Return the names of the fields, without types."""
        return dict.fromkeys(cls.names, "")


def interface_packages(*, old_poses: bool = False) -> dict[str, ModuleType]:
    """Return modules by name, for sys.modules."""
    modules: dict[str, ModuleType] = {}
    for path, kinds in FIELDS.items():
        package, _, folder = path.partition(".")
        modules.setdefault(package, ModuleType(package))
        modules[path] = ModuleType(path)
        for name, fields in kinds.items():
            own = OLD_NAMED_POSE if old_poses and name == "NamedPose" else fields
            setattr(
                modules[path],
                name,
                _message(path, name, own) if folder == "msg" else _service(path, name, own),
            )
    return modules


@contextmanager
def standing_in() -> Iterator[None]:
    """Make absent packages importable within the context."""
    made = {name: module for name, module in interface_packages().items() if name not in sys.modules}
    sys.modules.update(made)
    try:
        yield
    finally:
        for name in made:
            sys.modules.pop(name)


def _message(module: str, name: str, fields: tuple[str, ...]) -> type:
    return type(name, (Fields,), {"names": fields, "__module__": f"{module}._{name.lower()}"})


def _service(module: str, name: str, fields: tuple[str, ...]) -> type:
    request = _message(module, f"{name}_Request", fields)
    return type(name, (), {"Request": request, "__module__": f"{module}._{name.lower()}"})
