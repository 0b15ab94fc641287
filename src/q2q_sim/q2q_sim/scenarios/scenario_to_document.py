"""Document of a scenario that is built or read: the inverse of q2q_sim.scenarios.scenario_document.

Every parameter of the room is written out, over the room EXPLICIT, whose blocks have their defaults.
"""

from dataclasses import replace

from q2q_model.documents.plain_values import Plain, to_plain
from q2q_model.vehicle.constants import firmware_of
from q2q_model.vehicle.thrust_map import STOCK
from q2q_sim.scenarios.scenario import Scenario
from q2q_sim.scenarios.scenario_document import scenario_from_document

EXPLICIT = "real"
"""Room without overrides of blocks."""
SHARED = ("description", "duration", "wake", "air", "air_without", "attitude", "model", "reading")
PARTS = ("vicon", "radio", "imu", "disturbance", "faults", "overrides")
"""Keys that are fields of a scenario."""


def document_of(scenario: Scenario) -> dict[str, Plain] | None:
    """Return the document of a scenario without its `in_air`.

    None where no document gives this scenario: it has a plan, or a vehicle that has no name.
    """
    document: dict[str, Plain] = {
        "vehicle": scenario.vehicle.name,
        "firmware": firmware_of(scenario.vehicle) or STOCK,
        "room": EXPLICIT,
        "vehicles": {one.name: to_plain(one.waypoints) for one in scenario.waypoints},
    }
    try:
        document |= {key: to_plain(getattr(scenario, key), key) for key in (*SHARED, *PARTS)}
        made = scenario_from_document(scenario.name, document)
    except ValueError:
        return None
    return document if made == replace(scenario, in_air=None) else None
