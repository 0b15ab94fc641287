"""Runs of a replay page: what is taken from a flight, and what its packed form keeps."""

import zlib
from base64 import b64decode
from collections.abc import Mapping
from dataclasses import replace
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest

from q2q_model.flights.flight import Flight
from q2q_model.identification.push.along_flight import Motion
from q2q_model.identification.push.push_samples import PushRecord
from q2q_model.model_files.find_model import find_model
from q2q_model.recordings.flight_recording import Recording
from q2q_model.signals.values import Array
from q2q_model.vehicle.constants import CRAZYFLIE_2_0, TEXTBOOK_065
from q2q_sim.commands.replay_page import main
from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.monitors.flight_judgement import verdict_of
from q2q_sim.monitors.policies import Circumstances
from q2q_sim.replay_page import (
    ReplayRun,
    replay_element,
    replay_html,
    replay_run,
    with_measured_downwash,
)
from q2q_sim.replay_page.packed_run import MISSING, STEPS, packed_run
from q2q_sim.replay_page.script_archive import FOLDER
from q2q_sim.scenarios import library
from q2q_sim.tools.write_replay import measured_push

ROOT = Path(__file__).resolve().parents[4]


@pytest.fixture(scope="module")
def flight() -> Flight:
    scenario = library.load("table6_room")
    short = replace(scenario, duration=4.0)
    return fly(short, FlightOptions(model=find_model(scenario.model).interaction))


@pytest.fixture(scope="module")
def run(flight: Flight) -> ReplayRun:
    return replay_run(flight, TEXTBOOK_065)


def decoded(channel: Mapping[str, object], vehicles: int, count: int) -> Array:
    """Return (T, n, width) values of a packed channel, by another way than the page's."""
    planes = np.frombuffer(zlib.decompress(b64decode(str(channel["data"]))), np.uint8).astype(np.int64)
    low, high = planes.reshape(2, vehicles, int(str(channel["width"])), count)
    zigzag = low + 256 * high
    codes = np.cumsum(np.where(zigzag % 2, -(zigzag + 1) // 2, zigzag // 2), axis=-1) % 65536
    values = np.where(
        codes == MISSING, np.nan, float(str(channel["low"])) + codes * float(str(channel["step"]))
    )
    return np.moveaxis(values, -1, 0)


def test_packed_quantities_are_those_of_the_flight_to_their_rounding(run: ReplayRun):
    packed = packed_run(run, rate_hz=100.0)
    for name, values in (("pos", run.pos), ("ref", run.ref_pos), ("downwash", run.downwash)):
        found = decoded(packed["channels"][name], len(run.names), len(run.t))
        np.testing.assert_allclose(found, values, atol=0.501 * STEPS[name])


def test_a_missing_frame_stays_missing_and_is_not_interpolated(run: ReplayRun):
    packed = packed_run(run, rate_hz=100.0)
    found = decoded(packed["channels"]["mocap"], len(run.names), len(run.t))
    accepted = np.isfinite(run.mocap_pos[..., 0]) & ~run.rejected
    assert 0 < accepted.sum() < accepted.size
    np.testing.assert_array_equal(np.isfinite(found[..., 0]), accepted)


def test_outliers_are_those_that_the_filter_did_not_follow(flight: Flight):
    track = flight.mocap_pos.copy()
    track[200, 0] = flight.pos[200, 0] + [0.0, 0.0, 0.3]
    spoilt = replay_run(replace(flight, mocap_pos=track), TEXTBOOK_065)
    found = packed_run(spoilt)["outliers"]
    assert [pytest.approx(2.0), 0, *(pytest.approx(value, abs=1e-4) for value in track[200, 0])] in found


def test_a_run_names_what_its_flight_does_not_record(flight: Flight):
    unknown = np.full_like(flight.eta, np.nan)
    bare = replay_run(replace(flight, true_eta=unknown, eta=unknown), TEXTBOOK_065)
    assert bare.missing == ("downwash",)
    assert "downwash" not in packed_run(bare)["channels"]


def test_a_run_is_sampled_at_most_fifty_times_a_second_and_never_above_its_own_rate(run: ReplayRun):
    assert packed_run(run)["count"] == 200
    slow = replace(
        run,
        t=run.t[::10],
        **{name: getattr(run, name)[::10] for name in ("pos", "quat", "ref_pos", "mocap_pos", "rejected")},
        downwash=run.downwash[::10],
        thrust=run.thrust[::10],
    )
    assert packed_run(slow)["rate"] == pytest.approx(10.0)


@pytest.mark.parametrize("rate_hz", [60.0, 120.0, 240.0])
def test_a_run_of_any_rate_is_shown_where_and_as_fast_as_it_flew(rate_hz: float):
    t = np.arange(5.0 * rate_hz) / rate_hz
    pos = np.column_stack([1.8 * t, 0.0 * t, 1.0 + 0.0 * t])[:, None]
    unknown = np.full_like(pos, np.nan)
    never, still = np.zeros((len(t), 1), dtype=np.bool_), unknown[..., 0]
    quat = np.full((len(t), 1, 4), np.nan)
    straight = ReplayRun("made", ("cf1",), t, pos, quat, pos, unknown, never, unknown, still, 0.046)
    packed = packed_run(straight)
    assert packed["rate"] == pytest.approx(50.0)
    found = decoded(packed["channels"]["pos"], 1, int(str(packed["count"])))
    np.testing.assert_allclose(found[:, 0, 0], 0.036 * np.arange(len(found)), atol=0.501 * STEPS["pos"])


def test_one_wrong_stamp_is_refused_with_its_place_and_costs_no_memory(run: ReplayRun):
    t = np.concatenate([run.t[:1], 1.7e9 + run.t[1:]])
    with pytest.raises(ValueError, match=r"span 1\.7e\+09 s, with a gap of 1\.7e\+09 s after 0 s; .*20000 s"):
        packed_run(replace(run, t=t))


def test_twenty_noisy_vehicles_for_fifty_seconds_fit_a_page_at_the_full_rate():
    random = np.random.default_rng(1)
    t, shape = 0.01 * np.arange(5000), (5000, 20, 3)
    pos = 1.0 + np.cumsum(0.005 * random.standard_normal(shape), axis=0)
    quat = np.concatenate([0.05 * random.standard_normal(shape), np.ones((*shape[:2], 1))], axis=2)
    run = ReplayRun(
        name="noisy",
        names=tuple(f"cf{i}" for i in range(20)),
        t=t,
        pos=pos,
        quat=quat,
        ref_pos=pos + 0.001 * random.standard_normal(shape),
        mocap_pos=pos + 0.001 * random.standard_normal(shape),
        rejected=np.zeros(shape[:2], dtype=np.bool_),
        downwash=random.standard_normal(shape),
        thrust=1.0 + 0.1 * random.standard_normal(shape[:2]),
        arm=0.046,
    )
    page = replay_html([run], "Noisy")
    assert len(page) < 2_000_000
    assert '"rate":50.0' in page or '"rate":50' in page


def test_names_cannot_end_the_script_that_holds_them(run: ReplayRun):
    page = replay_html([replace(run, name="</script><b>")], "a < b")
    assert "</script><b>" not in page
    assert "<title>a &lt; b</title>" in page


def test_measured_downwash_is_shown_while_a_vehicle_is_under_another():
    t = 0.01 * np.arange(1000)
    pos = np.stack(
        [np.tile([0.0, 0.0, 1.0], (1000, 1)), np.column_stack([t - 5.0, 0.0 * t, 0.0 * t + 1.5])], 1
    )
    under = np.abs(pos[:, 1, 0]) < 0.15
    push = np.column_stack([np.where(under, -2.0, 0.1), np.full(1000, 0.3)])
    level = np.broadcast_to([0.0, 0.0, 1.0], pos.shape)
    motion = Motion(t, pos, np.zeros_like(pos), level)
    yes = np.ones((1000, 2), dtype=np.bool_)
    record = PushRecord("made", ("cf1", "cf2"), motion, push, yes, ~yes)
    unknown = np.full_like(pos, np.nan)
    bare = ReplayRun("made", ("cf1", "cf2"), t, pos, unknown, pos, unknown, ~yes, unknown, push, 0.046)
    seen = with_measured_downwash(bare, lambda: record)
    middle = np.argmin(np.abs(pos[:, 1, 0]))
    assert seen.downwash[middle, 0] == pytest.approx([0.0, 0.0, -2.1])  # without the offset of clear air
    assert np.abs(seen.downwash[:, 1]).max() == 0.0
    assert np.abs(seen.downwash[np.abs(pos[:, 1, 0]) > 0.25]).max() < 1e-12  # rounding of a running sum
    assert with_measured_downwash(seen, lambda: record) is seen, "what is recorded is not replaced"


def test_the_force_of_another_vehicle_is_not_shown_and_reported(
    flight: Flight, capsys: pytest.CaptureFixture[str]
):
    assert measured_push(Recording(flight), CRAZYFLIE_2_0) is None
    output = capsys.readouterr().err
    assert output.startswith("replay_page: no downwash is shown: flight ")
    assert "times the weight of crazyflie_2_0" in output


def test_a_page_says_what_was_not_judged_in_the_words_of_the_verdict(flight: Flight):
    unplanned = replace(flight, ref_pos=unknown_as(flight.pos), safe_pos=unknown_as(flight.pos))
    for one in (flight, unplanned):
        words = str(verdict_of(one, Circumstances(vehicle=TEXTBOOK_065)))
        assert replay_run(one, TEXTBOOK_065).verdict.endswith(f"; {words}")
    assert words.endswith("not judged: floor and setpoint_error (no reference recorded)")


def unknown_as(values: Array) -> Array:
    """Return NaN in the shape of some values."""
    return np.full_like(values, np.nan)


def test_a_part_of_a_bag_has_the_times_of_the_bag(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    output = []
    for part in ([], ["--start", "12.5"]):
        file = tmp_path / "page.html"
        assert main([str(ROOT / "bags" / "table2_1"), *part, "--out", str(file)]) == 0
        output.append(capsys.readouterr().out.splitlines()[0].split(";"))
        assert f'"since":{12.5 if part else 0.0}' in file.read_text(encoding="utf-8")
    assert output[0][0] == output[1][0] == "table2_1: cf1 pushed 17 cm down at 21.6 s"


def test_four_runs_are_refused(run: ReplayRun):
    with pytest.raises(ValueError, match="4 runs; must be 1 to 3"):
        replay_element([run] * 4)


def test_the_library_is_the_published_one_unchanged():
    sums = (FOLDER / "three" / "SHA256SUMS").read_text().splitlines()
    listed = {name: digest for digest, name in (line.split() for line in sums)}
    shipped = {path.name for path in (FOLDER / "three").iterdir()}
    assert shipped - listed.keys() == {"README.md", "SHA256SUMS"}
    for name, digest in listed.items():
        assert sha256((FOLDER / "three" / name).read_bytes()).hexdigest() == digest, name
