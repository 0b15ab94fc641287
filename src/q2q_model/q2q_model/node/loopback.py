"""Restriction of the middleware to UDP on the loopback interface.

`ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST` limits whom a node looks for, not who finds it: rmw_fastrtps 8.4
binds its ports on every interface, and a host that names this one in `ROS_STATIC_PEERS` reads and writes all
topics. It also insists on shared memory, whose ports all domains of a machine share: nodes that start at once
collide there ("Failed init_port"), topics have stopped (Fast DDS, issues 5737 and 6117), and every flight
leaves files in /dev/shm. UDP on loopback is as fast for 2, 100 and 200 vehicles.

So the profile has one transport, on 127.0.0.1, that discovers as LOCALHOST does; rmw leaves profiles alone
under SYSTEM_DEFAULT. It announces a participant to the ports of 120, where rmw tries those of 32: as many fit
in a domain (ports from 7410 + 250 domain on, two each). Of 40, each takes 0.7 ms of processor time a second.
In the last domain, 232, these ports exceed 65535, at which Fast DDS ends the process.

Peers or a discovery server set by the user are on other machines: then nothing is restricted. A profile of
the user takes precedence. Other middleware ignores ours.

Source: Fast DDS 2.14, XML profiles, `interfaceWhiteList`; rmw_fastrtps_shared_cpp, participant.cpp.
"""

from collections.abc import Mapping, MutableMapping
from pathlib import Path

LOOPBACK = "127.0.0.1"
"""Address of the interface, as in PROFILE."""
PROFILE = Path(__file__).with_name("loopback.xml")
PROFILE_VARIABLES = ("FASTRTPS_DEFAULT_PROFILES_FILE", "FASTDDS_DEFAULT_PROFILES_FILE")
"""Environment variables of a profile: up to Fast DDS 2, the version of ours, and from 3."""
RANGE, DEPRECATED = "ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_LOCALHOST_ONLY"
DOMAIN, LAST_DOMAIN = "ROS_DOMAIN_ID", 232
"""Environment variable of the domain, and the one that ROS allows and PROFILE has too many ports for."""
BEYOND = ("ROS_STATIC_PEERS", "ROS_DISCOVERY_SERVER")
"""Environment variables that name other machines."""


def chosen_domain(environment: Mapping[str, str]) -> int | None:
    """Return the domain that the user has set; None without one.

    Raises:
        ValueError: DDS has no such domain, or ROS would read another number (-1 as 0, 010 as 8).
    """
    given = environment.get(DOMAIN, "").strip()
    if not given:
        return None
    if given not in map(str, range(LAST_DOMAIN + 1)):
        raise ValueError(f"{DOMAIN} is {given!r}: give an integer in [0, {LAST_DOMAIN - 1}]")
    return int(given)


def stays_here(environment: Mapping[str, str]) -> bool:
    """Return whether ROS is asked for this machine only."""
    asked = environment.get(RANGE) == "LOCALHOST" or environment.get(DEPRECATED) == "1"
    return (asked or is_restricted(environment)) and not any(map(environment.get, BEYOND))


def is_restricted(environment: Mapping[str, str]) -> bool:
    """Return whether an environment is what `restrict` makes of one."""
    return restriction(PROFILE).items() <= environment.items()


def has_own_profile(environment: Mapping[str, str]) -> bool:
    """Return whether the user has chosen a profile of the middleware."""
    return any(environment.get(name, "") not in ("", str(PROFILE)) for name in PROFILE_VARIABLES)


def restriction(profile: Path) -> dict[str, str]:
    """Return the environment variables of a node whose transports are those of a profile."""
    return {PROFILE_VARIABLES[0]: str(profile), RANGE: "SYSTEM_DEFAULT"}


def restrict(environment: MutableMapping[str, str]) -> None:
    """Bind the ports of nodes started in an environment to loopback if they are to stay on this machine.

    Raises:
        ValueError: they are to, in LAST_DOMAIN; or nodes may find no other, there is no such domain, or a
            profile of the user cannot be read.
    """
    domain = chosen_domain(environment)
    if environment.get(RANGE) == "OFF" and environment.get(DEPRECATED) != "1":  # "1" overrides it
        raise ValueError(
            f"{RANGE} is OFF, with which no node finds another: unset it, or set LOCALHOST (this machine) or "
            "SUBNET"
        )
    if has_own_profile(environment):
        _check_profiles(environment)
        return
    if stays_here(environment):
        if domain == LAST_DOMAIN:
            raise ValueError(f"{DOMAIN} is {LAST_DOMAIN}, which has too few ports: choose one in [0, 231]")
        environment.update(restriction(PROFILE))
        environment.pop(DEPRECATED, None)
        return
    if is_restricted(environment):
        environment[RANGE] = "LOCALHOST"
    environment.pop(PROFILE_VARIABLES[0], None)


def _check_profiles(environment: Mapping[str, str]) -> None:
    """Raise ValueError for a profile that the middleware would leave out with no word of it."""
    from xml.etree import ElementTree as ET  # few have a profile, and it takes 7 ms of every start

    for name in PROFILE_VARIABLES:
        if file := environment.get(name):
            try:
                ET.parse(file)  # noqa: S314 - the user's own file
            except (OSError, ET.ParseError) as error:
                why = error.strerror if isinstance(error, OSError) else f"no XML: {error}"
                raise ValueError(
                    f"{name} is {file}, which cannot be read ({why}): correct or unset it"
                ) from error
