"""The report of a flight without states or commands: filtered here, or unknown, but not zero."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from q2q_model.bag import BagReader, BagWriter
from q2q_model.recordings.bag_vehicle import flown_vehicle
from q2q_sim.monitors.mocap_quality import mocap_quality
from q2q_sim.report.bag_tables import Reported, limit_rows
from q2q_sim.tools.report_bags import report_bag

BAG = Path(__file__).resolve().parents[4] / "bags" / "table2_1"
SECONDS = 6.0


def report_of(topics: list[str], path: Path) -> Reported:
    """Return the report on the first seconds of a recorded flight, of these topics alone."""
    reader = BagReader(BAG)
    with BagWriter(path) as part:
        for topic in topics:
            part.add_topic(topic, reader.topics[topic])
        for one in reader.raw(topics):
            if one.stamp_ns < 1e9 * SECONDS:
                part.write_raw(one.topic, one.stamp_ns, one.data)
    return report_bag(path, flown_vehicle(path, "crazyflie_2_0"))


@pytest.mark.skipif(not BAG.is_dir(), reason=f"no recorded flight {BAG}")
def test_states_that_were_not_recorded_are_filtered_from_motion_capture(tmp_path: Path) -> None:
    topics = ["/mocap", "/reference", "/command"]
    flown = report_of([*topics, "/state"], tmp_path / "with")
    bare = report_of(topics, tmp_path / "without")
    for name, vehicle in flown.metrics.vehicles.items():
        assert bare.metrics.vehicles[name].z_rmse_m == pytest.approx(vehicle.z_rmse_m, rel=1e-9)
        assert bare.quality[name] == flown.quality[name]
    assert str(bare.verdict) == str(flown.verdict)


@pytest.mark.skipif(not BAG.is_dir(), reason=f"no recorded flight {BAG}")
def test_numbers_of_what_was_not_recorded_are_unknown_not_zero(tmp_path: Path) -> None:
    uncommanded = report_of(["/mocap", "/state", "/reference"], tmp_path / "bag")
    assert all(saturated == fallback == "-" for _, _, saturated, fallback, *_ in limit_rows(uncommanded))
    stateless = replace(uncommanded.flight, pos=np.full_like(uncommanded.flight.pos, np.nan))
    assert all(np.isnan(one.rejected) for one in mocap_quality(stateless).values())
