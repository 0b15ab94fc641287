"""Scenarios load, mean what the paper says, and refuse what is wrong by name."""

from dataclasses import replace
from datetime import date
from pathlib import Path

import numpy as np
import pytest

from q2q_model.trajectory import plan_file
from q2q_model.tunable import tunable_of
from q2q_model.vehicle.constants import (
    CRAZYFLIE_2_0,
    CRAZYFLIE_2_1,
    CRAZYFLIE_BRUSHLESS,
    on_firmware,
    vehicle_by_name,
)
from q2q_planner.offline.minimum_snap.minimum_snap import minimum_snap_plan
from q2q_planner.offline.minimum_snap.waypoints import VehicleWaypoints, Waypoint
from q2q_sim.air.lookup.find_air import FlownAir
from q2q_sim.air.wake_laws import wake_by_name
from q2q_sim.loop import flight_blocks
from q2q_sim.loop.scenario_air import air_of
from q2q_sim.node_flights.scenario_node_parameters import (
    controller_node_parameters,
    filter_node_parameters,
    replanner_node_parameters,
)
from q2q_sim.scenarios import library
from q2q_sim.scenarios.block_overrides import BLOCKS
from q2q_sim.scenarios.scenario_document import scenario_from_document
from q2q_sim.scenarios.scenario_variants import with_air, with_choices, with_firmware
from q2q_sim.simulator.simulator_params import SimulatorParams, chosen_scenario

GOOD = {
    "description": "two vehicles",
    "duration": 5,
    "vehicle": "crazyflie_2_0",
    "vehicles": {"cf1": [{"t": 0, "pos": [0, 0, 1]}, {"t": 5, "pos": [0, 0, 1]}]},
}


@pytest.mark.parametrize("name", library.names())
def test_every_scenario_loads_plans_and_says_what_it_is(name: str) -> None:
    scenario = library.load(name)
    assert scenario.name == name
    assert 10 < len(library.describe(name)) < 110
    assert flight_blocks.plan_of(scenario).names == scenario.names
    assert wake_by_name(scenario.wake)
    for parameters in (
        filter_node_parameters(scenario),
        replanner_node_parameters(scenario, flight_blocks.BlockChoices()),
        controller_node_parameters(scenario, flight_blocks.BlockChoices()),
    ):
        assert all(isinstance(value, bool | int | float | str | tuple) for value in parameters.values())


def test_controller_nodes_fly_the_vehicle_of_the_scenario() -> None:
    loaded = [library.load(name) for name in library.names()]
    upgraded = with_firmware(library.load("stack3"), "thrust_upgrade")
    for one in filter(None, (*loaded, *(scenario.in_air for scenario in loaded), upgraded)):
        parameters = controller_node_parameters(one, flight_blocks.BlockChoices())
        assert vehicle_by_name(str(parameters["vehicle"]), str(parameters["firmware"])) == one.vehicle


@pytest.mark.parametrize(
    ("flight", "distance", "speed", "overlap"),
    [
        (1, 0.5, 0.5, 0.4),
        (2, 1.0, 0.5, 0.4),
        (3, 0.5, 1.5, 0.13),
        (4, 1.0, 1.5, 0.13),
        (5, 0.5, 0.5, 1.0),
        (6, 1.0, 0.5, 1.0),
    ],
)
def test_the_flights_of_table_2_have_its_distance_speed_and_overlap(
    flight: int, distance: float, speed: float, overlap: float
) -> None:
    scenario = library.load(f"table2_{flight}")
    plan = minimum_snap_plan(scenario.waypoints, scenario.reading)
    t = np.arange(0.0, scenario.duration, 0.001)
    lower, upper = (trajectory.at(t) for trajectory in plan.trajectories)
    rel = (upper - lower)[:, :3]
    flyover = np.linalg.norm(plan.trajectories[1].at(t, 1)[:, :3], axis=1).max()
    close = np.hypot(rel[:, 0], rel[:, 1]) <= 0.1
    assert np.unique(rel[:, 2]) == pytest.approx(distance)
    assert flyover == pytest.approx(speed, rel=0.01)
    # waypoints are given to three digits, the overlap of a moving pass to two
    assert close.sum() * 0.001 == pytest.approx(overlap, rel=0.05)
    assert t[close][0] > 15.0


def test_table6_is_section_5_2() -> None:
    scenario = library.load("table6")
    hover, passing = scenario.waypoints
    assert {point.pos for point in hover.waypoints} == {(0.0, 0.0, 1.5)}
    assert [(point.t, point.pos) for point in passing.waypoints] == [
        (0.0, (0.0, 2.0, 2.0)),
        (25.0, (0.0, 0.0, 2.0)),
        (50.0, (0.0, -2.0, 2.0)),
    ]
    assert scenario.vehicle.mass == 0.65
    assert flight_blocks.pid_params(scenario, limited=True).thrust_max == 6.6


def test_terms_that_are_off_in_the_scenarios_own_air_are_on_in_another() -> None:
    own = with_air(library.load("stack3"), "room", ("residual",))
    for same in ("", "room"):
        assert with_air(own, same, ()).air_without == ("residual",)
    assert with_air(own, "room", ("wind",)).air_without == ("wind",)
    for other in ("none", "paper", "ring"):
        moved = with_air(own, other, ())
        assert (moved.air, moved.air_without) == (other, ())
        assert isinstance(air_of(moved), FlownAir)  # they have no residual to switch off


def test_table6_room_is_flown_by_crazyflies_in_an_air_that_is_not_its_own() -> None:
    scenario = library.load("table6_room")
    assert with_air(scenario, "paper", ()).vehicle.mass == with_air(scenario, "none", ()).vehicle.mass == 0.65
    flown = with_air(scenario, "room", ("wind",))
    assert (flown.air, flown.air_without, flown.model) == ("room", ("wind",), "measured_law")
    assert flown.vehicle == on_firmware(CRAZYFLIE_2_0, "stock_2025_02")  # of the recorded flights
    assert flown.waypoints == scenario.waypoints
    assert flown.radio == scenario.radio
    assert flight_blocks.pid_params(flown, limited=True).k_p_z == 10.0
    chosen = with_air(with_choices(scenario, "crazyflie_2_1", ""), "room", ())  # it comes before the file
    assert chosen.vehicle == on_firmware(CRAZYFLIE_2_1, "stock_2025_02")
    other = with_air(with_choices(scenario, "crazyflie_brushless", ""), "room", ())
    assert other.vehicle == CRAZYFLIE_BRUSHLESS  # it has no such firmware


@pytest.mark.parametrize("count", [1, 2, 7, 50])
def test_swarms_of_any_size_start_apart_and_stay_apart(count: int) -> None:
    scenario = library.load(f"swarm{count}")
    plan = flight_blocks.plan_of(scenario)
    assert len(scenario.names) == count
    t = np.linspace(0.0, scenario.duration, 61)
    pos = np.stack([trajectory.at(t)[:, :3] for trajectory in plan.trajectories], axis=1)  # (61, n, 3)
    apart = np.linalg.norm(pos[:, :, None] - pos[:, None], axis=-1) + 10.0 * np.eye(count)
    assert apart.min() > 0.45


@pytest.mark.parametrize(
    ("name", "word"),
    [
        ("", "the scenario is empty: give its name, e.g. table6, or its file"),
        ("tabel6", "unknown scenario 'tabel6'; did you mean table6?"),
        ("swarm0", "must have 1 to 1000 vehicles"),
        ("../secret", "unknown scenario"),
        ("none.yaml", "cannot be read"),
    ],
)
def test_unknown_names_are_refused_with_the_nearest_right_one(name: str, word: str) -> None:
    with pytest.raises(ValueError, match=word.replace("?", r"\?")):
        library.load(name)


@pytest.mark.parametrize(
    ("change", "word"),
    [
        (
            {"vehicles": {"cf1": [{"t": 0, "pos": [0, float("nan"), 1]}, {"t": 5, "pos": [0, 0, 1]}]}},
            r"cf1, waypoint 0: pos\[1\] = nan",
        ),
        (
            {"vehicles": {"cf1": [{"t": 0, "pos": [0, 0, -1]}, {"t": 5, "pos": [0, 0, 1]}]}},
            r"must be at least 0 \(z is up, the ground at 0\)",
        ),
        (
            {"vehicles": {"cf1": [{"t": 0, "pos": [0, 0, 1]}, {"t": 5, "pos": [0, 0, -1]}]}},
            r"cf1, waypoint 1: z = -1.0 m; must be at least 0 \(z is up, the ground at 0\)",
        ),
        (
            {"vehicles": {"cf1": [{"t": 0, "pos": [0, 0, 1]}, {"t": 5, "pos": [200, -1500, 1000]}]}},
            r"cf1, waypoint 1: y = -1500 m; must be within 50 m for mocap_filter: give metres, or set",
        ),
        (
            {
                "vehicles": {"cf1": [{"t": 0, "pos": [0, 0, 1]}, {"t": 5, "pos": [9, 0, 1]}]},
                "overrides": {"mocap_filter": {"pos_max": 8.0}},
            },
            "cf1, waypoint 1: x = 9 m; must be within 8 m for mocap_filter",
        ),
        (
            {"faults": [{"kind": "radio_loss", "start": 1, "duration": 1}]},
            "radio_loss: size = 0 has no effect",
        ),
        (
            {"radio": {"latency": 0.3}, "vicon": {"latency": 0.25}},
            r"vicon.latency 0.25 s and radio.latency 0.3 s together: .* must be in \[0.0, 0.5\]",
        ),
        ({"vehicles": {}}, "no vehicle given"),
        ({"duration": 0.004}, r"duration = 0.004; must be in \[0.01, 3600.0\] s"),
        ({"duration": -1}, r"duration = -1.0; must be in \[0.01, 3600.0\] s"),
        ({"duration": float("nan")}, "duration = nan"),
        ({"duration": "long"}, "duration = 'long'; must be a number"),
        ({"durration": 5}, "unknown key 'durration'; did you mean duration"),
        ({"wake": "storm"}, "unknown wake 'storm'"),
        ({"in_air": {"vehicle": "boeing"}}, "unknown vehicle 'boeing'; choose one of"),
        ({"vehicle": "boeing"}, "unknown vehicle 'boeing'; choose one of"),
        ({"room": "attic"}, "unknown room 'attic'; choose one of ideal, capture, real, rough"),
        ({"reading": "fast"}, "reading = 'fast'; must be one of stop_and_go, free"),
        ({"radio": {"loss": 2.0}}, r"RadioParams.loss = 2.0; must be in \[0.0, 1.0\]"),
        ({"vicon": {"pos_nois": 0.1}}, "has no parameter 'pos_nois'; did you mean pos_noise"),
        ({"radio": {"loss": "much"}}, "radio.loss = 'much'; must be a number"),
        ({"radio": {"quantised": 1}}, "radio.quantised = 1; must be a bool"),
        ({"overrides": {"pidd": {}}}, "unknown block 'pidd'; did you mean pid"),
        ({"overrides": {"pid": {"k_p_z": -1}}}, "PidParams.k_p_z = -1.0"),
        ({"overrides": {"pid": {"k_p_z": [1, 2]}}}, r"overrides.pid.k_p_z = \[1, 2\]; must be a number"),
        (
            {"overrides": {"replanner": {"k_s": [1, "x", 2]}}},
            "overrides.replanner.k_s = 'x'; must be a number",
        ),
    ],
)
def test_wrong_values_are_refused_by_name(change: dict[str, object], word: str) -> None:
    with pytest.raises(ValueError, match=word):
        scenario_from_document("mine", GOOD | change)


def test_a_file_of_the_users_own_is_read_and_a_broken_one_refused(tmp_path: Path) -> None:
    own = tmp_path / "mine.yaml"
    own.write_text("duration: 3\nvehicles: {cf1: [{t: 0, pos: [0, 0, 1]}, {t: 3, pos: [1, 0, 1]}]}\n")
    assert library.load(str(own)).duration == 3.0
    own.write_text("duration: [3\n")
    with pytest.raises(ValueError, match="is not valid YAML"):
        library.load(str(own))
    own.write_text("just words\n")
    with pytest.raises(ValueError, match="got 'just words', expected a mapping with description, duration"):
        library.load(str(own))
    own.write_text("# nothing yet\n")
    with pytest.raises(ValueError, match="is empty: write description, duration and vehicles"):
        library.load(str(own))
    own.write_text("duration: -3\nvehicles: {cf1: [{t: 0, pos: [0, 0, 1]}, {t: 3, pos: [1, 0, 1]}]}\n")
    with pytest.raises(ValueError, match=r"^scenario mine: duration = -3"):
        library.load(str(own))


def test_in_another_air_vehicles_replace_a_plan_and_a_plan_vehicles(tmp_path: Path) -> None:
    ways = Waypoint(0.0, (0.0, 0.0, 2.0)), Waypoint(7.0, (3.0, 0.0, 2.0))
    plan_file.save(tmp_path / "plan.json", minimum_snap_plan([VehicleWaypoints("cf9", ways)]))
    cf1 = "vehicles: {cf1: [{t: 0, pos: [0, 0, 1]}, {t: 3, pos: [1, 0, 1]}]}"
    own = tmp_path / "mine.yaml"
    for text, names, durations in (
        (f"{cf1}\nin_air: {{plan: plan.json}}\n", ("cf1", "cf9"), (3.0, 7.0)),
        (f"plan: plan.json\nin_air: {{{cf1}}}\n", ("cf9", "cf1"), (7.0, 3.0)),
        ("plan: plan.json\nin_air: {wake: paper}\n", ("cf9", "cf9"), (7.0, 7.0)),
    ):
        own.write_text(text)
        flown = library.load(str(own))
        assert flown.in_air is not None
        assert (*flown.names, *flown.in_air.names) == names
        assert (flown.duration, flown.in_air.duration) == durations
        assert [one.plan is None for one in (flown, flown.in_air)] == [name == "cf1" for name in names]
    own.write_text(f"{cf1}\nplan: plan.json\n")
    with pytest.raises(ValueError, match="vehicles and plan are both given"):
        library.load(str(own))


def test_a_wake_and_an_air_in_its_place_are_refused_together() -> None:
    with pytest.raises(ValueError, match=r"^wake = 'measured' and air = 'room': give one of them"):
        chosen_scenario(SimulatorParams(wake="measured", air="room"))


def test_overrides_of_an_unknown_block_are_refused_in_a_scenario_as_in_its_document() -> None:
    with pytest.raises(ValueError, match=r"^overrides: unknown block 'pidd'; did you mean pid\?"):
        replace(library.load("table6"), overrides={"pidd": {"k_p_z": 1.0}})


def test_an_override_too_large_for_a_float_is_refused() -> None:
    with pytest.raises(ValueError, match=r"pid\.k_p_z = 1000+\.\.\.0+; must be a finite number"):
        scenario_from_document("mine", GOOD | {"overrides": {"pid": {"k_p_z": 10**400}}})


def test_a_wrong_override_is_shown_in_a_few_characters() -> None:
    for wrong in ("x" * 10**6, ["a"] * 10**6, {"k": ["v" * 10**6]}):
        for key in ("k_p_z", "thrust_max"):
            with pytest.raises(ValueError, match=rf"^overrides\.pid\.{key} = .{{0,40}}; must be a number$"):
                scenario_from_document("mine", GOOD | {"overrides": {"pid": {key: wrong}}})


def test_a_description_that_is_a_list_or_a_mapping_is_refused() -> None:
    for wrong in (["one"] * 10**6, {"one": "line"}):
        with pytest.raises(ValueError, match=r"^description = .{0,40}; must be text$"):
            scenario_from_document("mine", GOOD | {"description": wrong})


@pytest.mark.parametrize(
    ("given", "read"),
    [(None, ""), ("", ""), ("one line", "one line"), (12, "12"), (date(2026, 1, 2), "2026-01-02")],
)
def test_a_description_that_is_left_empty_is_empty(given: object, read: str) -> None:
    assert scenario_from_document("mine", GOOD | {"description": given}).description == read


def test_a_document_without_a_file_names_no_plan() -> None:
    with pytest.raises(ValueError, match=r"plan = 'mine.json': only a scenario file can name a plan"):
        scenario_from_document("mine", {"plan": "mine.json"})


def test_every_override_of_a_shipped_scenario_is_a_field_of_its_block() -> None:
    for name in library.names():
        for block, values in library.load(name).overrides.items():
            fields = BLOCKS[block].__dataclass_fields__
            for key in values:
                assert tunable_of(fields[key]).description
