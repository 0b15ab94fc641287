"""Vehicles are read from crazyflies.yaml of Crazyswarm2, and errors name the entry."""

import pytest

from q2q_control.crazyswarm.configured_vehicles import vehicle_names
from q2q_control.crazyswarm.crazyswarm_params import CrazyswarmParams
from q2q_control.radio.crazyflies_file import crazyflies_at, crazyflies_from_document


def test_crazyflies_are_read_as_crazyswarm2_writes_them() -> None:
    robots = {
        "cf1": {
            "enabled": True,
            "uri": "radio://0/80/2M/E7E7E7E701",
            "initial_position": [0, 1.5, 0],
            "type": "cf21",
        },
        "cf2": {"enabled": False, "uri": "radio://0/80/2M/E7E7E7E702"},
        "cf3": {"enabled": True, "uri": "udp://127.0.0.1:19850"},
    }
    read = crazyflies_from_document({"fileversion": 3, "robots": robots, "robot_types": {}, "all": {}})
    assert [(one.name, one.uri, one.start) for one in read] == [
        ("cf1", "radio://0/80/2M/E7E7E7E701", (0.0, 1.5, 0.0)),
        ("cf3", "udp://127.0.0.1:19850", (0.0, 0.0, 0.0)),
    ]


@pytest.mark.parametrize(
    ("robots", "message"),
    [
        (None, "robots = None: a mapping of names to values is expected"),
        ({"cf1": {"enabled": False}}, "none is enabled"),
        ({"cf1": {"enabled": "yes"}}, "robots.cf1.enabled = 'yes': true or false is expected"),
        ({"cf1": {"enabled": True}}, "cf1: uri = '': something like radio"),
        ({"cf1": {"enabled": True, "uri": "udp://x", "initial_position": [1, 2]}}, "three numbers"),
        (
            {"cf1": {"enabled": True, "uri": "udp://x"}, "cf2": {"enabled": True, "uri": "udp://x"}},
            "same uri",
        ),
        ({"my cf": {"enabled": True, "uri": "udp://x"}}, "vehicle 'my cf': a name is a letter"),
    ],
)
def test_wrong_crazyflies_are_refused_by_name(robots: object, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        crazyflies_from_document({"robots": robots})


@pytest.mark.parametrize(
    ("names", "uris", "message"),
    [
        ((), (), "no vehicles: set crazyflies:=FILE, or vehicles and uris"),
        (("cf1",), ("hello",), "cf1: uri = 'hello': something like radio://"),
        (("cf1",), ("rdio://0/80",), "cf1: uri = 'rdio://0/80': something like radio://"),
        (("cf1", "cf2"), ("udp://x", "udp://x"), "cf1 and cf2 have the same uri udp://x"),
        (("cf1", "cf2"), ("radio://0/80/2M/E7E7", "radio://0/80/2M/e7e7"), "cf1 and cf2 have the same uri"),
        (("cf1", "cf2"), ("radio://0/80/2M", "radio://1/80/2M/E7E7E7E7E7"), "cf1 and cf2 have the same uri"),
        (("cf1", "cf1"), ("udp://x", "udp://y"), "duplicate vehicle names in cf1, cf1"),
        (("my-cf",), ("udp://x",), "vehicle 'my-cf': a name is a letter, then letters, digits and _"),
    ],
)
def test_wrong_vehicles_of_parameters_are_refused(
    names: tuple[str, ...], uris: tuple[str, ...], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        crazyflies_at(names, uris)


def test_a_name_given_twice_to_the_node_of_crazyswarm2_is_refused() -> None:
    with pytest.raises(ValueError, match="duplicate vehicle names in cf1, cf2, cf1"):
        vehicle_names(CrazyswarmParams(vehicles=("cf1", "cf2", "cf1")))
