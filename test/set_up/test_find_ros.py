"""scripts/setup.d/find_ros.sh: which ROS a shell has, apart from what env.sh of a checkout put there."""

from pathlib import Path

from fresh_checkout import Checkout

LISTS = ("PATH", "PYTHONPATH", "AMENT_PREFIX_PATH", "CMAKE_PREFIX_PATH", "LD_LIBRARY_PATH")
FIND_ROS = f"""ROOT=$PWD; . scripts/setup.d/find_ros.sh; find_ros
printf '%s\\n' "$ROS_KIND" {" ".join(f'"${name}"' for name in LISTS)}"""


def add_environment(root: Path) -> Path:
    """Write what find_ros reads of a .venv on the ROS wheels; return it."""
    environment = root / ".venv"
    files = {
        "q2q/origin": "wheels 3.12\n",
        "share/rosidl_default_generators/package.xml": "",
        "bin/python3": "#!/bin/sh\n",  # imports rclpy: succeeds at whatever it is told
    }
    for name, text in files.items():
        (environment / name).parent.mkdir(parents=True, exist_ok=True)
        (environment / name).write_text(text)
    (environment / "bin/python3").chmod(0o755)
    return environment


def test_shells_of_other_checkouts_are_no_sourced_ros(checkout: Checkout) -> None:
    """The .venv of the second checkout was removed, and rebuilt on that of the first."""
    first, second = checkout.root.parent / "first one", checkout.root.parent / "second"
    environments = [add_environment(root) for root in (first, second)]
    overlay = f"{first}/install/q2q_msgs"
    shell = {
        "VIRTUAL_ENV": str(environments[0]),
        "ROS_DISTRO": "jazzy",
        "PATH": ":".join([*(f"{one}/bin" for one in environments), checkout.env["PATH"], f"{first}/scripts"]),
        "PYTHONPATH": f"{first}/build/q2q_sim:/home/me/python:{overlay}/lib/python3.12/site-packages",
        "AMENT_PREFIX_PATH": f"{overlay}:{environments[0]}",
        "CMAKE_PREFIX_PATH": f"{overlay}:/home/me/cmake",
        "LD_LIBRARY_PATH": f"{overlay}/lib:/opt/cuda/lib:{first} not/lib",
    }
    checkout.tool("python3", "exit 1")
    kind, *lists = checkout.shell(FIND_ROS, **shell).stdout.splitlines()
    assert kind == "wheels"
    kept = (checkout.env["PATH"], "/home/me/python", "", "/home/me/cmake", f"/opt/cuda/lib:{first} not/lib")
    assert dict(zip(LISTS, lists, strict=True)) == dict(zip(LISTS, kept, strict=True))
