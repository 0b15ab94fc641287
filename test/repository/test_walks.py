"""The two walks of docs/architecture.md name the files that run, in the order in which they run."""

import re
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from inspect import CO_OPTIMIZED
from pathlib import Path
from types import FrameType

import pytest
from fresh_checkout import ROOT

from q2q_model.commands import identify
from q2q_model.compiled import KERNELS
from q2q_model.model_files.find_model import find_model
from q2q_model.signals.layout import Signal
from q2q_model.tools import identify_flights
from q2q_sim.loop.closed_loop import FlightOptions, fly
from q2q_sim.scenarios import library

PAGE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
STEP = re.compile(r"^\d+\. `(q2q_\w+/[\w/]+\.py)`", re.MULTILINE)
SERVICES = {
    "q2q_model/commands/argument_paths.py",
    "q2q_model/commands/argument_types.py",
    "q2q_model/commands/command_line.py",
    "q2q_model/commands/clean_exit.py",
    "q2q_model/commands/recording_options.py",
    "q2q_model/commands/ros_arguments.py",
    "q2q_model/compilation/kernel_cache.py",
    "q2q_model/compilation/kernel_digest.py",
    "q2q_model/compiled.py",
    "q2q_model/counted.py",
    "q2q_model/estimation/frame_counts.py",
    "q2q_model/estimation/frame_rows.py",
    "q2q_model/node/lean_imports.py",
    "q2q_model/plain_console.py",
    "q2q_model/signals/repeated_stamp.py",
    "q2q_model/signals/stamps.py",
    "q2q_model/signals/values.py",
    "q2q_model/tunable.py",
    "q2q_model/writable_places.py",
}
"""Services that blocks and commands use: parsing, parameters, compilation, stamps, rows, counts and words."""
BESIDE_FLIGHT = {
    "q2q_model/estimation/frame_intervals.py",
    "q2q_planner/plan_playback/measured_poses.py",
}
"""Intervals of frames, which matter after a gap, and last measured poses, followed by a waiting reference."""
BESIDE_IDENTIFICATION = {
    "q2q_model/bag/flight_facts.py",
    "q2q_model/bag/storage/bag_path.py",
    "q2q_model/bag/storage/definitions.py",
    "q2q_model/bag/storage/errors.py",
    "q2q_model/bag/storage/latched.py",
    "q2q_model/bag/storage/open_source.py",
    "q2q_model/bag/storage/own_definition.py",
    "q2q_model/bag/storage/source.py",
    "q2q_model/documents/checksummed_json.py",
    "q2q_model/documents/json_file.py",
    "q2q_model/documents/numpy_values.py",
    "q2q_model/documents/plain_reader.py",
    "q2q_model/documents/plain_values.py",
    "q2q_model/documents/read_text.py",
    "q2q_model/documents/written_file.py",
    "q2q_model/documents/yaml_text.py",
    "q2q_model/downwash/interaction_model.py",
    "q2q_model/downwash/no_interaction.py",
    "q2q_model/estimation/association/outlier_thresholds.py",
    "q2q_model/flights/duplicates/height_records.py",
    "q2q_model/flights/duplicates/motion_windows.py",
    "q2q_model/flights/duplicates/same_flight.py",
    "q2q_model/flights/first_order_lag.py",
    "q2q_model/flights/flight.py",
    "q2q_model/flights/flight_ticks.py",
    "q2q_model/flights/interpolated_gaps.py",
    "q2q_model/flights/masks_over_time.py",
    "q2q_model/flights/output_ticks.py",
    "q2q_model/flights/reference_remarks.py",
    "q2q_model/flights/sampled_reference.py",
    "q2q_model/flights/units_and_frames/frame_notes.py",
    "q2q_model/flights/units_and_frames/tilt_direction.py",
    "q2q_model/flights/units_and_frames/unit_check.py",
    "q2q_model/flights/units_and_frames/up_axis.py",
    "q2q_model/flights/units_and_frames/upright_check.py",
    "q2q_model/forked.py",
    "q2q_model/geometry/pair_reach.py",
    "q2q_model/geometry/rotations.py",
    "q2q_model/identification/gain_notes.py",
    "q2q_model/identification/gains/altitude_record.py",
    "q2q_model/identification/gains/flown_pieces.py",
    "q2q_model/identification/gains/gain_agreement.py",
    "q2q_model/identification/gains/gain_equation.py",
    "q2q_model/identification/gains/huber_regression.py",
    "q2q_model/identification/gains/velocity_limit.py",
    "q2q_model/identification/jet/held_out_deviation.py",
    "q2q_model/identification/jet/jet_deviation.py",
    "q2q_model/identification/jet/jet_form.py",
    "q2q_model/identification/push/log_check.py",
    "q2q_model/identification/push/log_column_note.py",
    "q2q_model/identification/push/log_mass.py",
    "q2q_model/identification/push/rate_check.py",
    "q2q_model/identification/recorded_altitudes.py",
    "q2q_model/identification/recorded_gains.py",
    "q2q_model/identification/selection/candidate.py",
    "q2q_model/identification/selection/jet_candidates.py",
    "q2q_model/identification/selection/model_choice.py",
    "q2q_model/identification/selection/model_doubts.py",
    "q2q_model/identification/selection/network_candidates.py",
    "q2q_model/identification/selection/unused_pushes.py",
    "q2q_model/identification/statistics/intervals.py",
    "q2q_model/model_files/model_bounds.py",
    "q2q_model/recordings/bag_vehicle.py",
    "q2q_model/recordings/distinct_flights.py",
    "q2q_model/recordings/filtered_states.py",
    "q2q_model/recordings/impossible_values.py",
    "q2q_model/signals/cdr/cdr_format.py",
    "q2q_model/signals/cdr/cdr_head.py",
    "q2q_model/tools/identify_report.py",
    "q2q_model/vehicle/constants.py",
    "q2q_model/vehicle/thrust_map.py",
}
"""Vehicle and format of the bag, repairs, gaps, a lag, vectors, intervals, report, format and bounds of
files, what belongs to a step: no step."""


@dataclass
class Trace:
    """Files of the packages that run while the trace is on, in the order of their first call."""

    files: list[str] = field(default_factory=list)

    def start(self) -> None:
        """Record every call."""
        sys.setprofile(self._watch)

    def stop(self) -> None:
        """Stop recording."""
        sys.setprofile(None)

    def _watch(self, frame: FrameType, event: str, _: object) -> None:
        found = re.search(r"/(q2q_\w+/(?!q2q_)[\w/]+\.py)$", frame.f_code.co_filename)
        is_function = frame.f_code.co_flags & CO_OPTIMIZED  # neither a module nor the body of a class
        if event == "call" and is_function and found and found[1] not in self.files:
            self.files.append(found[1])


def walk(heading: str) -> list[str]:
    """Return the numbered files of a section of the page."""
    section = PAGE.partition(f"## {heading}\n")[2].partition("\n## ")[0]
    return STEP.findall(section)


def check(steps: list[str], ran: list[str], aside: set[str]) -> None:
    """Compare a walk with the files that ran; calls of a kernel by another kernel leave no trace."""
    compiled = {kernel.name.rpartition(".")[0].replace(".", "/") + ".py" for kernel in KERNELS}
    assert sorted(set(ran) - set(steps) - aside) == [], "these run, and are no step"
    assert sorted(set(steps) - set(ran) - compiled) == [], "these are steps, and do not run"
    traced = set(ran) & set(steps) - compiled
    assert [one for one in steps if one in traced] == [one for one in ran if one in traced], "another order"


@pytest.mark.parametrize(
    ("heading", "most"), [("From a mocap frame to a command", 25), ("From a bag to a model", 30)]
)
def test_a_walk_is_short_and_names_files_that_exist(heading: str, most: int) -> None:
    steps = walk(heading)
    assert 10 < len(steps) <= most
    assert len(set(steps)) == len(steps)
    assert [one for one in steps if not (ROOT / "src" / one.partition("/")[0] / one).is_file()] == []


def test_a_frame_of_an_ordinary_tick_passes_the_documented_files_to_its_command(tmp_path: Path) -> None:
    shown = (ROOT / "test" / "scenarios" / "short_room.yaml").read_text()
    ideal = tmp_path / "ideal.yaml"
    ideal.write_text(shown.replace("room: real", "room: ideal"))
    scenario = library.load(str(ideal))
    trace, ticks = Trace(), 0

    def hear(topic: str, _: int, __: Signal) -> None:
        nonlocal ticks
        ticks += topic == "truth"
        if topic == "truth" and 130 < ticks <= 150:  # the passage
            trace.start()
        if topic == "mocap":  # the first signal of a tick after its command is computed
            trace.stop()

    known = find_model(scenario.model).interaction
    fly(scenario, FlightOptions(model=known, on_signal=hear))
    blocks = [one for one in trace.files if not one.startswith("q2q_sim/")]
    check(walk("From a mocap frame to a command"), blocks, SERVICES | BESIDE_FLIGHT)


def test_bags_pass_the_documented_files_to_a_model(tmp_path: Path) -> None:
    bags = [str(ROOT / "bags" / name) for name in ("table2_1", "table2_5")]
    assert identify_flights  # imported before: what modules call when they are imported is no step
    trace = Trace()
    run_traced(
        trace,
        lambda: identify.main([*bags, "--out", str(tmp_path / "m.q2q"), "--no-plots", "--model-type", "jet"]),
    )
    check(walk("From a bag to a model"), trace.files, SERVICES | BESIDE_IDENTIFICATION)


def run_traced(trace: Trace, act: Callable[[], int]) -> None:
    """Run a command under a trace; it must succeed."""
    trace.start()
    try:
        status = act()
    finally:
        trace.stop()
    assert status == 0
