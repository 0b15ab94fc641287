"""Nodes of a flight are killed, and stopped, in turn: the flight ends safely, and goes on where it may."""

from pathlib import Path

import numpy as np
import pytest
from process_faults import ProcessFault, Waiting, fly_with_process_faults

from q2q_model.bag import BagReader
from q2q_model.signals.values import CommandStatus, SwarmCommand
from q2q_sim.flight_bag.recorded_trace import trace_in
from q2q_sim.monitors.policies import POLICIES, Circumstances, FlightTrace, judge
from q2q_sim.node_flights.flight_request import FlightRequest
from q2q_sim.scenarios import library

TABLE6 = "table6_room"
LOW = str(Path(__file__).parents[1] / "scenarios" / "low_hover.yaml")
ROAD = ("mocap_filter", "interference", "trajectory", "replanner", "pid")
WALL_TIME = "silence"
"""The policy that a busy machine may break."""


def violations(trace: FlightTrace, scenario: str, *but: str) -> list[str]:
    """Return what a flight broke of all policies but some."""
    asked = {name: policy for name, policy in POLICIES.items() if name not in (*but, WALL_TIME)}
    return [str(one) for one in judge(trace, Circumstances(library.load(scenario).vehicle), asked)]


def statuses(bag: Path, after: float, before: float = np.inf) -> list[list[int]]:
    """Return the statuses of a bag's commands between two times [s]; a fallback's stamp is no tick's."""
    found = (one.signal for one in BagReader(bag).signals(["/command"]))
    return [one.status.tolist() for one in found if isinstance(one, SwarmCommand) and after < one.t < before]


def end_of(bag: Path, topic: str) -> float:
    """Return the latest stamp of a topic [s]."""
    return max(one.signal.t for one in BagReader(bag).signals([topic]))


def test_nodes_that_are_killed_or_stopped_in_turn_take_their_places_in_flight(tmp_path: Path) -> None:
    killed = [ProcessFault(node, tick=400 * k) for k, node in enumerate(ROAD, start=1)]
    stopped = ProcessFault("replanner", tick=2400, how="stop")
    timing = fly_with_process_faults(FlightRequest(TABLE6, seed=3), [*killed, stopped], tmp_path)
    trace = trace_in(tmp_path / "bag")
    assert timing.missed_ticks == 0
    assert len(trace.t) == 5000
    assert violations(trace, TABLE6) == []
    assert np.isfinite(trace.thrust[-1]).all()
    assert (trace.command_status[-1] != CommandStatus.CUT).all()


def test_a_recorder_that_is_killed_leaves_a_bag_that_is_readable_up_to_its_end(tmp_path: Path) -> None:
    fault = ProcessFault("bag_record", tick=1000, comes_back=False)
    timing = fly_with_process_faults(FlightRequest(LOW, seed=3), [fault], tmp_path)
    assert timing.missed_ticks == 0
    trace = trace_in(tmp_path / "bag")
    # a chunk is a second of bag time: what was in the last one is lost
    assert 100 <= len(trace.t) < 1400
    assert np.isfinite(trace.true_pos).all()
    assert violations(trace, LOW) == []


def test_without_a_controller_the_firmware_levels_and_cuts(tmp_path: Path) -> None:
    fault = ProcessFault("pid", tick=1, comes_back=False)
    short = tmp_path / "short_hover.yaml"
    short.write_text(Path(LOW).read_text().replace("14.0", "7.0"))
    waiting = Waiting(0.01, 0.5)
    fly_with_process_faults(FlightRequest(str(short)), [fault], tmp_path / "flight", waiting)
    trace = trace_in(tmp_path / "flight" / "bag")
    assert len(trace.t) == 700
    assert violations(trace, str(short), "return", "floor") == []  # they come down
    # 2 s after its last packet the firmware cuts the motors; 0.6 m takes 0.35 s to fall, and rotors lag
    silent = int(np.flatnonzero(np.isfinite(trace.thrust).all(axis=1))[-1])
    np.testing.assert_allclose(trace.true_pos[silent + 260, :, 2], 0.0, atol=1e-9)
    np.testing.assert_allclose(trace.true_pos[-1, :, :2], trace.sent_pos[silent, :, :2], atol=0.05)


def test_live_a_controller_that_loses_its_reference_and_then_its_states_acts_by_itself(
    tmp_path: Path,
) -> None:
    reference, states = (
        ProcessFault(node, tick, comes_back=False)
        for node, tick in (("trajectory", 200), ("mocap_filter", 700))
    )
    long = tmp_path / "long_hover.yaml"  # faults may begin seconds late on a busy machine
    long.write_text(Path(LOW).read_text().replace("14.0", "24.0"))
    fly_with_process_faults(FlightRequest(str(long), live=True), [reference, states], tmp_path)
    trace = trace_in(tmp_path / "bag")
    no_reference, no_state = (end_of(tmp_path / "bag", topic) for topic in ("/reference_safe", "/state"))
    assert violations(trace, LOW, "return", "floor") == []  # they come down
    # states come: it hovers where it was last sent; the fallback answers where a busy machine gave no state
    alone = {one for both in statuses(tmp_path / "bag", no_reference, no_state) for one in both}
    assert CommandStatus.DEGRADED in alone
    assert alone <= {
        CommandStatus.DEGRADED,
        CommandStatus.HOLD,
        CommandStatus.LEVEL,
        CommandStatus.LAND,
    }
    before = int(np.searchsorted(trace.t, no_state))
    fallbacks = {CommandStatus.LEVEL, CommandStatus.LAND}
    by_vehicle = np.array(statuses(tmp_path / "bag", after=0.0, before=no_state)).T
    never_level = np.array([fallbacks.isdisjoint(given) for given in by_vehicle.tolist()])
    hover = np.array(
        [[0.0, 0.0, 0.6], [0.0, 1.0, 0.6]]
    )  # level for lack of states, a vehicle may rise or sink
    np.testing.assert_allclose(trace.true_pos[before, never_level], hover[never_level], atol=0.05)
    status = statuses(tmp_path / "bag", after=0.0)
    last_seen = max(k for k, both in enumerate(status) if CommandStatus.DEGRADED in both)
    order = list(dict.fromkeys(one for one, _ in status[last_seen:]))
    falling = (CommandStatus.LEVEL, CommandStatus.LAND, CommandStatus.CUT)  # busy, it may be level before
    assert [one for one in order if one in falling] == [one for one in falling if one in order]
    assert {CommandStatus.LAND, CommandStatus.CUT} <= set(order)
    assert status[-1] == [CommandStatus.CUT] * 2
    np.testing.assert_allclose(trace.true_pos[-1, :, 2], 0.0, atol=1e-9)  # on the ground, in its place
    np.testing.assert_allclose(trace.true_pos[-1, :, :2], [[0.0, 0.0], [0.0, 1.0]], atol=0.2)


@pytest.mark.parametrize("comes_back", [True, False])
def test_live_a_controller_whose_middleware_hangs_leaves_its_vehicles_safe(
    tmp_path: Path, comes_back: bool
) -> None:
    fault = ProcessFault("pid", tick=200, how="hang", comes_back=comes_back)
    fly_with_process_faults(FlightRequest(LOW, live=True), [fault], tmp_path)
    trace = trace_in(tmp_path / "bag")
    assert violations(trace, LOW, "return", "floor") == []  # without states they come down
    seen = {one for both in statuses(tmp_path / "bag", after=0.0) for one in both}
    silent = np.isnan(trace.thrust).all(axis=1)
    # it acts by its own timer, or a lock of the frozen thread keeps it silent and the firmware acts
    assert CommandStatus.LEVEL in seen or silent[201:].sum() >= 50
    if not comes_back:
        np.testing.assert_allclose(trace.true_pos[-1, :, 2], 0.0, atol=1e-9)


def test_a_fault_of_no_node_of_the_flight_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="no node 'filter' in this flight; there are bag_record, mocap_fil"):
        fly_with_process_faults(FlightRequest(LOW), [ProcessFault("filter", 1)], tmp_path)
