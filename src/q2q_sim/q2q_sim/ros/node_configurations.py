"""Start configurations of q2q's nodes that differ in topics or parameters, and the files they name."""

from pathlib import Path

from q2q_model.bag import BagWriter
from q2q_model.node.warm_up import synthetic_signal
from q2q_model.signals.cdr.cdr_writer import encode
from q2q_model.signals.topic_names import TICK_TOPICS
from q2q_model.trajectory import plan_file
from q2q_model.tunable import ParameterValue
from q2q_sim.flight_bag.topics import TYPE_NAMES
from q2q_sim.loop import flight_blocks
from q2q_sim.scenarios import library

VEHICLE = "cf1"
"""Example vehicle in the names of topics."""
SCENARIO = "table6"
SENSING_EXAMPLE = "q2q_control.own_controller.sensing_example:SensingExample"

Configuration = dict[str, ParameterValue]

ANY_BUT: dict[str, str] = {"correct_vehicle": "none", "poses_out": "empty"}
"""Parameters of which any value has the same topics, but for the one that switches them off."""


def configurations(executable: str, folder: Path) -> list[Configuration]:
    """Return start configurations of a node that differ in topics or parameters, with files in `folder`."""
    played: Configuration = {"bag": str(folder / "bag")}
    unanswered: Configuration = played | {"topics": tuple(one for one in TICK_TOPICS if one != "command")}
    known: dict[str, list[Configuration]] = _flying_configurations() | {
        "interference": [{"correct_vehicle": "none"}, {"correct_vehicle": "crazyflie_2_0"}],
        "trajectory": [
            {"plan": str(folder / "plan.json"), "wait": True},
            {"plan": str(folder / "plan.json"), "wait": False},
        ],
        "replanner": [{"law": "paper"}, {"law": "safe"}],
        "simulator": [{"crtp": crtp, "crtp_port": 0} for crtp in (False, True)],
        "bag_record": [{"bag": str(folder / "made")}],
        "bag_play": [
            played | {"wait_for": "", "clock": False},
            unanswered | {"wait_for": "command", "clock": False},
            unanswered | {"wait_for": "", "clock": False},
            unanswered | {"wait_for": "", "clock": True},
        ],
    }
    return known.get(executable, [{}])


def _flying_configurations() -> dict[str, list[Configuration]]:
    """Return those of the controllers, and of the nodes that reach real vehicles."""
    link: Configuration = {"vehicles": (VEHICLE,), "uris": ("udp://127.0.0.1:19850",)}
    of_one: Configuration = {"vehicles": (VEHICLE,)}
    return {
        "pid": [
            {"aware": True, "live": True, "correct": False},
            {"aware": False, "live": True, "correct": False},
            {"aware": True, "live": True, "correct": True},
        ],
        "own_controller": [
            {"controller": SENSING_EXAMPLE, "aware": True},
            {"controller": SENSING_EXAMPLE, "aware": False},
        ],
        "mpc": [
            of_one | {"correct": False, "distributed": False},
            of_one | {"correct": True, "distributed": False},
            of_one | {"correct": False, "distributed": True},
        ],
        "radio": [
            link | {"mode": "command"},
            link | {"mode": "setpoint", "aware": True},
            link | {"mode": "setpoint", "aware": False},
        ],
        "crazyswarm": [
            of_one | {"mode": "setpoint", "poses_out": "/poses_filtered", "aware": True},
            of_one | {"mode": "setpoint", "poses_out": "", "aware": True},
            of_one | {"mode": "setpoint", "poses_out": "/poses_filtered", "aware": False},
            of_one | {"mode": "command", "poses_out": ""},
        ],
    }


def write_start_files(folder: Path) -> None:
    """Write the plan and the bag that configurations name."""
    plan_file.save(folder / "plan.json", flight_blocks.plan_of(library.load(SCENARIO)))
    writer = BagWriter(folder / "bag")
    for topic, kind in TYPE_NAMES.items():
        writer.add_topic(f"/{topic}", kind)
        writer.write_raw(f"/{topic}", 0, encode(synthetic_signal(TICK_TOPICS[topic], 0.0, (VEHICLE,)), 0))
    writer.close()
