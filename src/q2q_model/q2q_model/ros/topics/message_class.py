"""Class of a message type named as in bags."""

from importlib import import_module


def message_class(kind: str) -> type:
    """Return the class of a type, such as "std_msgs/msg/String".

    Raises:
        ValueError: its package is not installed, or has no such message.
    """
    package, _, name = kind.split("/")
    try:
        found: type = getattr(import_module(f"{package}.msg"), name)
    except (ImportError, AttributeError) as missing:
        raise ValueError(f"message type {kind} is not installed here") from missing
    return found
