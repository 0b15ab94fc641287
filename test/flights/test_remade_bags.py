"""bags/remake writes the topics that the bags of Table 2 hold, and replaces a bag only by a complete one.

Every flight is a copy of 0.2 s of a bag of Table 2 with one more topic, as `fly --record` adds what its
verdict needs.
"""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from fresh_checkout import ROOT

from q2q_model.bag import BagReader, BagWriter, RawMessage, read_facts

KEPT = ROOT / "bags" / "table2_1"
BAGS = [f"table2_{k}" for k in range(1, 7)]
COUNT = 20 * 6
"""Messages of 0.2 s."""
FLY = """#!/bin/sh
here=$(dirname "$0")
case " $(cat "$here/refused") " in *" $1 "*) exit 1 ;; esac
while [ "$1" != --bag ]; do shift; done
cp -r "$here/flown" "$2"
"""


def first_messages() -> list[RawMessage]:
    """Return the first messages of a bag of Table 2."""
    return list(BagReader(KEPT).raw())[:COUNT]


@pytest.fixture
def remake(tmp_path: Path) -> Path:
    """Return the script in a checkout whose `scripts/fly` copies a bag."""
    scripts, bags = tmp_path / "scripts", tmp_path / "bags"
    scripts.mkdir()
    bags.mkdir()
    with BagWriter(scripts / "flown", read_facts(KEPT)) as flown:
        for topic, kind in {**BagReader(KEPT).topics, "/truth": "q2q_msgs/msg/SwarmState"}.items():
            flown.add_topic(topic, kind)
        for one in first_messages():
            flown.write_raw(one.topic, one.stamp_ns, one.data)
            if one.topic == "/state":
                flown.write_raw("/truth", one.stamp_ns, one.data)
    (scripts / "env.sh").write_text(f'export PATH="{Path(sys.executable).parent}:$PATH"\n')
    (scripts / "refused").write_text("")
    (scripts / "fly").write_text(FLY)
    (scripts / "fly").chmod(0o755)
    for name in ("remake", "keep_topics.py"):
        shutil.copy(ROOT / "bags" / name, bags / name)
    return bags / "remake"


def run(script: Path, *words: str | Path) -> subprocess.CompletedProcess[str]:
    """Return the finished script."""
    return subprocess.run([script, *words], capture_output=True, text=True, check=False)


def by_topic(messages: list[RawMessage]) -> dict[str, list[tuple[int, bytes]]]:
    """Return time [ns] and bytes of the messages of each topic."""
    topics = sorted({one.topic for one in messages})
    return {
        topic: [(one.stamp_ns, bytes(one.data)) for one in messages if one.topic == topic] for topic in topics
    }


def test_the_bags_hold_the_topics_of_the_kept_ones_message_by_message(remake: Path, tmp_path: Path) -> None:
    out = tmp_path / "a b"
    done = run(remake, out)
    assert (done.returncode, done.stderr) == (0, "")
    assert sorted(each.name for each in out.iterdir()) == BAGS
    for name in BAGS:
        assert by_topic(list(BagReader(out / name).raw())) == by_topic(first_messages())
        assert read_facts(out / name) == read_facts(KEPT)
        assert sorted(each.name for each in (out / name).iterdir()) == ["metadata.yaml", f"{name}_0.mcap"]


def test_a_flight_that_fails_leaves_its_old_bag_and_nothing_else(remake: Path, tmp_path: Path) -> None:
    (tmp_path / "scripts" / "refused").write_text("table2_2")
    out = tmp_path / "out"
    for name in BAGS[:2]:
        (out / name).mkdir(parents=True)
        (out / name / "old").touch()
    assert run(remake, out).returncode == 1
    assert sorted(each.name for each in out.iterdir()) == BAGS[:2]
    assert not (out / "table2_1" / "old").exists()
    assert (out / "table2_2" / "old").exists()


@pytest.mark.parametrize("words", [["--ehlp"], ["out", "--json"], ["out", "other"], [""]])
def test_unknown_arguments_are_refused_before_anything_is_touched(remake: Path, words: list[str]) -> None:
    before = sorted(remake.parent.iterdir())
    done = run(remake, *words)
    assert done.returncode == 2
    assert f"unknown arguments '{' '.join(words)}'" in done.stderr
    assert sorted(remake.parent.iterdir()) == before


def test_help_says_what_is_made_and_where(remake: Path) -> None:
    done = run(remake, "--help")
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("usage: bags/remake [FOLDER]")
