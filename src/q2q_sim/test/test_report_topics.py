"""The report of a bag whose topics have other names is, by a topic map, that of the same bag with ours."""

import json
from pathlib import Path

import pytest

from q2q_model.bag import BagReader, BagWriter
from q2q_sim.commands import report
from q2q_sim.topics import TICK_TOPICS

BAG = Path(__file__).resolve().parents[3] / "bags" / "table2_1"


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
    found = []
    for bag, more in ((BAG, []), (tmp_path / "table2_1", ["--topics", str(tmp_path / "map.yaml")])):
        out = tmp_path / f"report{len(found)}"
        words = [str(bag), "--vehicle", "crazyflie_2_0", "--out", str(out), "--json", str(out) + ".json"]
        assert report.main([*words, *more]) == 0
        found.append(json.loads(Path(f"{out}.json").read_text()))
    assert found[1] == found[0]
    assert set(found[0]) == {"table2_1"}
