"""Vehicles are read from crazyflies.yaml of Crazyswarm2, and errors name the entry."""

from pathlib import Path

import pytest
import yaml

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


URI = "radio://0/80/2M/E7E7E7E70"
TYPES = {"cf21": {}, "marker": {"connection": "none"}, "other": {"connection": "mavlink"}}
ROBOTS = {
    "cf1": {"enabled": True, "uri": f"{URI}1", "type": "cf21"},
    "wand": {"enabled": True, "type": "marker", "initial_position": [0.0, 0.0, 0.0]},
    "box": {"enabled": True, "type": "marker", "connection": "none"},
    "rover": {"enabled": True, "type": "other"},
    "spare": {"enabled": False, "type": "cf21", "connection": "none"},
}


def test_each_crazyflie_has_its_firmware_params_over_those_of_its_type_and_of_all() -> None:
    found = crazyflies_from_document(
        {
            "all": {
                "firmware_params": {"ctrlMel": {"kp_z": 2.5, "mass": 0.03}, "hlCommander": {"vtoff": 0.3}}
            },
            "robot_types": {"cf21": {"firmware_params": {"ctrlMel": {"mass": 0.045}}}},
            "robots": {
                "cf1": {"enabled": True, "uri": f"{URI}1"},
                "cf2": {"enabled": True, "uri": f"{URI}2", "type": "cf21"},
                "cf3": {
                    "enabled": True,
                    "uri": f"{URI}3",
                    "type": "cf21",
                    "firmware_params": {"ctrlMel": {"mass": 0.05}},
                },
            },
        }
    )
    assert [one.firmware_params for one in found] == [
        {"ctrlMel.kp_z": 2.5, "ctrlMel.mass": mass, "hlCommander.vtoff": 0.3} for mass in (0.03, 0.045, 0.05)
    ]


def test_a_firmware_parameter_that_is_no_number_is_named_with_its_type_or_all() -> None:
    wrong = {"firmware_params": {"ring": {"effect": "010"}}}
    document = {"robots": {"cf1": {"enabled": True, "uri": f"{URI}1", "type": "cf21"}}}
    for place, level in (("robot_types.cf21", {"robot_types": {"cf21": wrong}}), ("all", {"all": wrong})):
        with pytest.raises(
            ValueError, match=rf"{place}\.firmware_params\.ring\.effect = '010'; must be a number"
        ):
            crazyflies_from_document({**document, **level})


def test_only_robots_of_a_crazyflies_connection_are_flown() -> None:
    found = crazyflies_from_document({"robots": ROBOTS, "robot_types": TYPES})
    assert [one.name for one in found] == ["cf1"]


@pytest.mark.parametrize(
    ("own", "flown"), [({"type": "cf21", "connection": "none"}, []), ({"connection": "crazyflie"}, ["cf2"])]
)
def test_a_robots_own_connection_is_for_the_radio_only_as_crazyswarm2_does_not_read_it(
    tmp_path: Path, own: dict[str, str], flown: list[str]
) -> None:
    """A file for the node `radio` was refused with words about Crazyswarm2."""
    robot = {"enabled": True, "uri": f"{URI}2", "type": "marker"} | own
    document = {"robots": ROBOTS | {"cf2": robot}, "robot_types": TYPES}
    assert [one.name for one in crazyflies_from_document(document)] == ["cf1", *flown]
    file = tmp_path / "crazyflies.yaml"
    file.write_text(yaml.safe_dump(document))
    with pytest.raises(
        ValueError, match=r"robots\.cf2\.connection = .* Crazyswarm2 reads connection only from robot_types"
    ):
        vehicle_names(CrazyswarmParams(crazyflies=str(file)))


@pytest.mark.parametrize(
    ("robots", "message"),
    [
        (None, "robots = None; must be a mapping of names to values"),
        ({"cf1": {"enabled": False}}, "none is enabled"),
        ({"cf1": {"enabled": "yes"}}, "robots.cf1.enabled = 'yes'; must be true or false"),
        ({"cf1": {"enabled": True}}, "cf1: uri = ''; must be a URI like radio"),
        ({"cf1": {"enabled": True, "uri": "udp://x", "initial_position": [1, 2]}}, "three numbers"),
        (
            {"cf1": {"enabled": True, "uri": "udp://x"}, "cf2": {"enabled": True, "uri": "udp://x"}},
            "same uri",
        ),
        (
            {
                "cf1": {
                    "enabled": True,
                    "uri": "udp://x",
                    "firmware_params": {"ctrlMel": {"mass": "heavy"}},
                }
            },
            r"robots\.cf1\.firmware_params\.ctrlMel\.mass = 'heavy'; must be a number",
        ),
        ({"my cf": {"enabled": True, "uri": "udp://x"}}, "vehicle 'my cf': a name must be a letter"),
    ],
)
def test_wrong_crazyflies_are_refused_by_name(robots: object, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        crazyflies_from_document({"robots": robots})


@pytest.mark.parametrize(
    ("names", "uris", "message"),
    [
        ((), (), "no vehicles: set crazyflies:=FILE, or vehicles and uris"),
        (("cf1",), ("hello",), "cf1: uri = 'hello'; must be a URI like radio://"),
        (("cf1",), ("rdio://0/80",), "cf1: uri = 'rdio://0/80'; must be a URI like radio://"),
        (("cf1", "cf2"), ("udp://x", "udp://x"), "cf1 and cf2 have the same uri udp://x"),
        (("cf1", "cf2"), ("radio://0/80/2M/E7E7", "radio://0/80/2M/e7e7"), "cf1 and cf2 have the same uri"),
        (("cf1", "cf2"), ("radio://0/80/2M", "radio://1/80/2M/E7E7E7E7E7"), "cf1 and cf2 have the same uri"),
        (("cf1", "cf1"), ("udp://x", "udp://y"), "duplicate vehicle names in cf1, cf1"),
        (
            ("my-cf",),
            ("udp://x",),
            "vehicle 'my-cf': a name must be a letter followed by letters, digits and _",
        ),
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
