"""Replay of a bag's mocap through the nodes mocap_filter and interference, tick by tick, without losses."""

from collections.abc import Sequence
from pathlib import Path

from q2q_model.bag import BagError, read_flight
from q2q_model.flights.flight import Flight
from q2q_sim.node_flights.running_nodes import RECORDER, running_nodes
from q2q_sim.node_flights.unfinished_bag import REMEDY, why_unfinished
from q2q_sim.processes.processes import NodeSpec

PLAYER = "bag_play"


def replay(bag: Path, model: str, folder: Path) -> Flight:
    """Return the filtered states and the predicted downwash of the nodes for a bag's mocap.

    Args:
        bag: the recorded flight.
        model: interaction model: none, a shipped name, or a .q2q file.
        folder: output folder for parameters, logs and the new bag.

    Raises:
        ValueError: the bag cannot be read, or the replay not be recorded to its end.
        NodeDiedError, TimeoutError: a node did not start or ended early.
    """
    made = folder / "replayed"
    specs = replay_node_specs(bag, model, made, read_flight(bag).names)
    with running_nodes(specs, folder) as running:
        running.processes.expect_exit(PLAYER)  # it exits after the bag
        running.director.start(PLAYER)
        running.director.wait_playback()
    if unfinished := why_unfinished(made, folder):
        raise BagError(f"the replay of {bag} was not recorded to its end ({unfinished}): {REMEDY}")
    return read_flight(made)


def replay_node_specs(bag: Path, model: str, made: Path, names: Sequence[str]) -> list[NodeSpec]:
    """Return the nodes of a replay with their parameters."""
    return [
        NodeSpec("q2q_sim", RECORDER, {"bag": str(made), "stamps": "header"}),
        NodeSpec("q2q_model", "mocap_filter", {"vehicles": tuple(names)}),
        NodeSpec("q2q_model", "interference", {"model": model}),
        NodeSpec(
            "q2q_sim",
            PLAYER,
            {"bag": str(bag), "topics": ("mocap",), "wait_for": "interference", "autostart": False},
        ),
    ]
