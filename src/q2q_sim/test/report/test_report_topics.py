"""The report of a bag whose topics have other names is, by a topic map, that of the same bag with ours."""

import json
from pathlib import Path

import pytest

from q2q_model.bag import BagReader, BagWriter
from q2q_model.documents.json_file import with_nulls
from q2q_model.recordings.bag_vehicle import flown_vehicle
from q2q_model.signals.topic_names import TICK_TOPICS
from q2q_sim.commands import report
from q2q_sim.report.bag_tables import as_json
from q2q_sim.tools.report_bags import report_bag

BAG = Path(__file__).resolve().parents[4] / "bags" / "table2_1"


@pytest.mark.skipif(not BAG.is_dir(), reason=f"no recorded flight {BAG}")
def test_report_reads_a_bag_of_others_by_a_topic_map(tmp_path: Path):
    reader = BagReader(BAG)
    ours = [topic for topic in reader.topics if topic.strip("/") in TICK_TOPICS]
    with BagWriter(tmp_path / "table2_1") as renamed:
        for topic in ours:
            renamed.add_topic(f"/room/{topic.strip('/')}_of_others", reader.topics[topic])
        for one in reader.raw(ours):
            renamed.write_raw(f"/room/{one.topic.strip('/')}_of_others", one.stamp_ns, one.data)
    names = (topic.strip("/") for topic in ours)
    entries = ", ".join(f"{name}: /room/{name}_of_others" for name in names)
    (tmp_path / "map.yaml").write_text(f"signals: {{{entries}}}")
    words = [str(tmp_path / "table2_1"), "--topics", str(tmp_path / "map.yaml")]
    words += ["--vehicle", "crazyflie_2_0", "--out", str(tmp_path / "report")]
    assert report.main([*words, "--json", str(tmp_path / "report.json")]) == 0
    plain = as_json([report_bag(BAG, flown_vehicle(BAG, "crazyflie_2_0"))])
    assert json.loads((tmp_path / "report.json").read_text()) == with_nulls(plain)
    assert set(plain) == {"table2_1"}
