"""Flights through the real nodes, as processes over DDS, in lockstep."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import fields, replace
from functools import cache
from pathlib import Path
from threading import Event, Thread

import numpy as np
import pytest
from rclpy.node import Node

from q2q_control.mpc.neighbours.time_slots import RATE_HZ
from q2q_model.bag import BagReader, read_facts
from q2q_model.downwash.correction.residual_process import REAL_FLIGHTS
from q2q_model.flights.flight import Flight
from q2q_model.model_files.find_model import find_model
from q2q_model.model_files.model_names import ModelFileError
from q2q_model.ros.node.bounded_spin import make_executor
from q2q_model.ros.node.ready import offer_ready
from q2q_model.ros.topics.messages import MESSAGES
from q2q_model.ros.topics.qos import EVERY_TICK
from q2q_model.signals.cdr.cdr_reader import decode
from q2q_model.signals.values import SwarmState
from q2q_model.trajectory import plan_file
from q2q_sim.loop import flight_blocks
from q2q_sim.loop.closed_loop import FlightOptions, LoopSettings, fly_blocks
from q2q_sim.loop.closed_loop import fly as fly_pure
from q2q_sim.loop.distributed import DistributedMpc
from q2q_sim.node_flights import flight_nodes, scenario_flight
from q2q_sim.node_flights.flight_request import FlightRequest, facts_of, load_scenario
from q2q_sim.node_flights.flight_run import FlightRun
from q2q_sim.node_flights.running_nodes import running_nodes
from q2q_sim.node_flights.scenario_flight import fly_through_nodes
from q2q_sim.processes.flight_progress import STILL_S
from q2q_sim.processes.processes import NodeDiedError, NodeSpec
from q2q_sim.scenarios import library
from q2q_sim.simulator.simulator_params import SimulatorParams

SCENARIO = str(Path(__file__).parents[1] / "scenarios" / "short_room.yaml")


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> FlightRun:
    folder = tmp_path_factory.mktemp("with a space")
    return fly_through_nodes(
        FlightRequest(SCENARIO, seed=3), folder / "nodes", folder / "bag", lambda _: None
    )


def test_a_stalled_flight_fails_before_the_simulator_flies_on_without_a_command() -> None:
    assert SimulatorParams().command_timeout_s > STILL_S


@cache
def pure(seed: int) -> Flight:
    """Return the same flight without ROS."""
    scenario = library.load(SCENARIO)
    model = find_model(scenario.model).interaction
    return fly_pure(scenario, FlightOptions(mode="aware", seed=seed, model=model))


def test_a_plan_file_flies_through_the_nodes_as_without_ros(tmp_path: Path) -> None:
    points = "vehicles: {cf1: [{t: 0, pos: [0, 0, 1.5]}, {t: 2, pos: [0.1, 0, 1.5]}],"
    points += " cf2: [{t: 0, pos: [0, 0, 1]}, {t: 2, pos: [0, 0.1, 1]}]}"
    (tmp_path / "points.yaml").write_text(points)
    plan = tmp_path / "plan.json"
    plan_file.save(plan, flight_blocks.plan_of(library.load(str(tmp_path / "points.yaml"))))
    request = FlightRequest(str(plan), vehicle="crazyflie_2_1", wake="paper", model="paper_law", stack=True)
    through_nodes = fly_through_nodes(request, tmp_path / "nodes", tmp_path / "bag", lambda _: None)
    model = find_model("paper_law").interaction
    alone = fly_pure(load_scenario(request), FlightOptions(model=model))
    np.testing.assert_allclose(through_nodes.flight.true_pos, alone.true_pos, rtol=0.0, atol=1e-9)
    assert np.abs(alone.true_eta).max() > 0.1  # the air of the command line
    assert read_facts(tmp_path / "bag") == facts_of(load_scenario(request), request)
    assert read_facts(tmp_path / "bag").vehicle == "crazyflie_2_1"


def test_a_controller_of_a_users_class_flies_as_without_ros(tmp_path: Path) -> None:
    own = "q2q_control.own_controller.pd_example:PdExample"
    request = FlightRequest(SCENARIO, controller=own, seed=3, stack=True)
    through_nodes = fly_through_nodes(request, tmp_path / "nodes", tmp_path / "bag", lambda _: None)
    scenario = library.load(SCENARIO)
    options = FlightOptions(controller=own, seed=3, model=find_model(scenario.model).interaction)
    alone = fly_pure(scenario, options)
    np.testing.assert_allclose(through_nodes.flight.true_pos, alone.true_pos, rtol=0.0, atol=1e-9)
    assert np.abs(alone.thrust - pure(3).thrust).max() > 1e-3  # another law
    assert read_facts(tmp_path / "bag").controller == own


def arrays_of(flight: Flight) -> dict[str, np.ndarray]:
    return {
        entry.name: getattr(flight, entry.name)
        for entry in fields(flight)
        if entry.name not in ("name", "names")
    }


def test_lockstep_through_dds_flies_the_numbers_of_the_loop_without_ros_by_the_same_seed(
    run: FlightRun,
) -> None:
    through_nodes = arrays_of(run.flight)
    for name, values in arrays_of(pure(3)).items():
        np.testing.assert_allclose(through_nodes[name], values, rtol=0.0, atol=1e-9, err_msg=name)
    assert np.abs(pure(4).true_pos - run.flight.true_pos).max() > 1e-4  # a seed makes a flight


def test_corrected_flights_take_the_accelerometers_of_the_same_ticks_with_and_without_ros(
    tmp_path: Path,
) -> None:
    request = FlightRequest(SCENARIO, controller="mpc", stack=True, seed=3, correct=True)
    through_nodes = fly_through_nodes(request, tmp_path / "nodes", tmp_path / "bag", lambda _: None)
    scenario = library.load(SCENARIO)
    options = FlightOptions(
        controller="mpc", seed=3, model=find_model(scenario.model).interaction, residual_process=REAL_FLIGHTS
    )
    alone, plain = fly_pure(scenario, options), fly_pure(scenario, replace(options, residual_process=None))
    np.testing.assert_allclose(through_nodes.flight.true_pos, alone.true_pos, rtol=0.0, atol=1e-9)
    assert np.abs(alone.true_pos - plain.true_pos).max() > 1e-4


def test_one_mpc_node_a_vehicle_flies_the_numbers_of_the_distributed_loop_without_ros(tmp_path: Path) -> None:
    request = FlightRequest(SCENARIO, controller="mpc", distributed=True, stack=True, seed=3)
    through_nodes = fly_through_nodes(request, tmp_path / "nodes", tmp_path / "bag", lambda _: None)
    scenario, model = load_scenario(request), find_model(load_scenario(request).model).interaction
    blocks = flight_blocks.blocks_of(scenario, request.options, model)
    distributed = DistributedMpc(scenario, request.options, model, blocks.plan)
    alone = fly_blocks(scenario, replace(blocks, controller=distributed), LoopSettings(seed=3))
    np.testing.assert_allclose(through_nodes.flight.true_pos, alone.true_pos, rtol=0.0, atol=1e-9)
    assert through_nodes.timing.missed_ticks == 0
    sent = len(list(BagReader(tmp_path / "bag").raw(["/predictions"])))
    assert sent == pytest.approx(2 * RATE_HZ * scenario.duration, abs=2)  # tracks begin within a slot


def test_no_tick_is_missed_and_every_tick_is_in_the_bag(run: FlightRun) -> None:
    assert run.timing.missed_ticks == 0
    assert run.timing.ticks == 300
    assert len(run.flight.t) == 300
    assert np.isfinite(run.flight.thrust).all()


def test_flown_again_in_one_process_the_same_seed_gives_the_same_numbers_to_the_last_digit(
    run: FlightRun, tmp_path: Path
) -> None:
    request = FlightRequest(SCENARIO, seed=3, stack=True)
    stacked = fly_through_nodes(request, tmp_path / "nodes", tmp_path / "bag", lambda _: None)
    assert stacked.timing.missed_ticks == 0
    for name, values in arrays_of(run.flight).items():
        np.testing.assert_array_equal(arrays_of(stacked.flight)[name], values, err_msg=name)


@contextmanager
def hearing_states(ticks: int) -> Iterator[Callable[[], dict[float, np.ndarray]]]:
    """Subscribe to `state` in a thread; yield what returns the positions by time once so many ticks came."""
    heard: dict[float, np.ndarray] = {}
    whole, over = Event(), Event()

    def on_state(data: bytes) -> None:
        state = decode(data, SwarmState)
        heard[state.t] = state.pos
        if len(heard) == ticks:
            whole.set()

    def spin() -> None:
        while not over.is_set():
            executor.spin_once(timeout_sec=0.05)

    def result() -> dict[float, np.ndarray]:
        assert whole.wait(STILL_S), f"{len(heard)} of {ticks} ticks heard"
        return heard

    node, executor, thread = Node("listener"), make_executor(), Thread(target=spin)
    offer_ready(node)
    node.create_subscription(MESSAGES[SwarmState], "state", on_state, EVERY_TICK, raw=True)
    executor.add_node(node)
    thread.start()
    try:
        yield result
    finally:
        over.set()
        thread.join()
        executor.shutdown()
        node.destroy_node()


def test_a_process_beside_a_flight_in_one_process_hears_every_tick_of_its_topics(
    run: FlightRun, tmp_path: Path
) -> None:
    request = FlightRequest(SCENARIO, seed=3, stack=True)
    specs = flight_nodes.node_specs(load_scenario(request), request, tmp_path, tmp_path / "bag")
    with running_nodes(specs, tmp_path) as running, hearing_states(ticks=300) as heard:
        running.director.wait_connected(("mocap_filter", "listener"), STILL_S)
        running.director.start()
        running.director.wait_summary(lambda _: None)
        found = heard()
    for t, pos in zip(run.flight.t, run.flight.pos, strict=True):
        np.testing.assert_array_equal(found[t], pos)


def under_sim_time(spec: NodeSpec) -> NodeSpec:
    """Return a node, and those in its process, whose clock is /clock."""
    inside = tuple(under_sim_time(one) for one in spec.inside)
    return replace(spec, parameters={**spec.parameters, "use_sim_time": True}, inside=inside)


def test_a_lockstep_flight_under_sim_time_ends_with_the_same_numbers_to_the_last_digit(
    run: FlightRun, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The simulator makes /clock, by the ticks for which all wait: nobody may wait for it in turn."""
    specs = flight_nodes.node_specs
    monkeypatch.setattr(
        scenario_flight, "node_specs", lambda *given: [under_sim_time(one) for one in specs(*given)]
    )
    request = FlightRequest(SCENARIO, seed=3, stack=True)
    timed = fly_through_nodes(request, tmp_path / "nodes", tmp_path / "bag", lambda _: None)
    assert timed.timing.missed_ticks == 0
    for name, values in arrays_of(run.flight).items():
        np.testing.assert_array_equal(arrays_of(timed.flight)[name], values, err_msg=name)
    written = [path.read_text() for path in (tmp_path / "nodes").glob("*.yaml")]
    assert written
    assert all("use_sim_time: true" in one for one in written)


def test_a_bag_is_never_overwritten(run: FlightRun, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="exists: choose another folder"):
        fly_through_nodes(FlightRequest(SCENARIO), tmp_path / "nodes", run.bag, lambda _: None)


def test_a_node_that_cannot_start_ends_the_flight_with_its_own_words(tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("a file stands where the bag's folder should be")
    with pytest.raises(NodeDiedError, match=r"bag_record ended with status 2: .*taken"):
        fly_through_nodes(
            FlightRequest(SCENARIO), tmp_path / "nodes", tmp_path / "taken" / "bag", lambda _: None
        )


def test_a_model_there_is_not_is_refused_before_any_node_starts(tmp_path: Path) -> None:
    request = FlightRequest(SCENARIO, model=str(tmp_path / "no_such_model.q2q"))
    with pytest.raises(ModelFileError, match=r"no model .*no_such_model"):
        fly_through_nodes(request, tmp_path / "nodes", tmp_path / "bag", lambda _: None)
    assert not (tmp_path / "nodes" / "pid.log").exists()
