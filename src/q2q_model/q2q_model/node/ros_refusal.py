"""Why ROS did not start, in one line: an argument after `--ros-args` that it does not understand."""

import re

EMPTY_RULE = re.compile(r"'-p ([^']*):='")
"""Parameter given without a value."""
SOURCE = re.compile(r",? at \S+:\d+")
"""Place in the source of rcl where an error arose."""
QUOTED = """quote texts in a list: -p "uris:=['radio://0/80/2M/E7E7E7E701']\""""


def refusal_of_ros(error: RuntimeError) -> str:
    """Return in one line why ROS did not start, without places in its source."""
    message = SOURCE.sub("", str(error)).replace("failed to initialize rcl: ", "")
    if message.startswith("["):
        return f"ROS does not know the arguments {message}; give arguments like --ros-args -p name:=value"
    if empty := EMPTY_RULE.search(message):
        name = empty[1]
        return (
            f"parameter {name} has no value: for an empty text give -p \"{name}:=''\", for an empty list "
            f"-p {name}:=[]"
        )
    return f"{message}; {QUOTED}" if "parameter override" in message and ":=[" in message else message
