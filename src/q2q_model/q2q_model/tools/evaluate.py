"""Score an interaction model against the pushes that recorded flights measured.

The rule is that of q2q_model.identification.draft_force. A flight from which no push can be read (neither a
log of forces nor accelerometer and thrust commands) is named, and its scores are null with n = 0.

R2 is not centred: exposed rows are pushed by about the same all the time, and on the recorded real flights a
constant alone has R2 0.60 (feed-forward off) and 0.48 (on). So compare with that constant, not with 0. With
a neighbour's log rolled by 7 to 23 s a law keeps R2 0.0 to 0.2 on the very same rows, which is less than
knowing only that somebody is above, and less than 0 over all usable rows: its gain has vanished.
"""

import json
import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from q2q_model.bag import BagError
from q2q_model.identification.draft_force import ForceSamples, ForceScore, force_samples, score
from q2q_model.identification.procedure import Recording, force_record
from q2q_model.identification.thrust_lag import thrust_lag
from q2q_model.tools.command_line import CommandLine, without_ros
from q2q_model.tools.models import find_model
from q2q_model.tools.recordings import read_recordings, topic_map
from q2q_model.vehicle import VEHICLES, Vehicle, vehicle_by_name

EXAMPLE = "  ros2 run q2q_model evaluate --model model.q2q flight1 flight2 --json scores.json"


def main(arguments: list[str] | None = None) -> int:
    """Evaluate as the command line says; return 0, or 1 after an error."""
    given = _command_line().parse_args(without_ros(arguments))
    try:
        law = find_model(given.model).interaction
        recordings, repairs = read_recordings(given.bags, topic_map(given.topics))
        samples = _samples(recordings, vehicle_by_name(given.vehicle))
        scores = {name: score(law, found) for name, found in samples.items()}
        pooled = score(law, [one for found in samples.values() for one in found])
        text = {"flights": {name: asdict(one) for name, one in scores.items()}, "pooled": asdict(pooled)}
        if given.json:
            given.json.write_text(json.dumps(text, indent=1) + "\n")
    except (BagError, ValueError, OSError) as wrong:
        print(f"evaluate: {wrong}", file=sys.stderr)
        return 1
    for repair in repairs:
        print(f"evaluate: mended: {repair}", file=sys.stderr)
    for name, one in scores.items():
        print(_line(name, one))
    print(_line("pooled", pooled))
    return 0


def _command_line() -> CommandLine:
    parser = CommandLine("evaluate", __doc__, EXAMPLE)
    parser.add_argument("bags", nargs="+", type=Path, metavar="BAG", help="recorded flights, at least one")
    parser.add_argument("--model", required=True, help="none, a shipped name, or a .q2q file")
    parser.add_argument("--json", type=Path, metavar="FILE", help="scores to write")
    parser.add_argument("--topics", type=Path, metavar="MAP.yaml", help="topics of bags that are not q2q's")
    parser.add_argument("--vehicle", default="crazyflie_2_0", choices=tuple(VEHICLES), help="whose mass")
    return parser


def _samples(recordings: Sequence[Recording], vehicle: Vehicle) -> dict[str, list[ForceSamples]]:
    lag = thrust_lag([one.flight for one in recordings], vehicle) or vehicle.thrust_lag
    found: dict[str, list[ForceSamples]] = {}
    for one in recordings:
        record = force_record(one, vehicle, lag)
        if record is None:
            print(f"evaluate: {one.flight.name} shows no pushes: not scored", file=sys.stderr)
        found[one.flight.name] = [] if record is None else force_samples(record)
    if not any(found.values()):
        raise ValueError(
            "no flight shows pushes: record imu and command, or a log with faz_est, gap and pwm1-4"
        )
    return found


def _line(name: str, one: ForceScore) -> str:
    if one.r2_exposed is None:
        return f"{name:32} no sample lies under another vehicle"
    upper = "" if one.mean_upper_mps2 is None else f", upper {one.mean_upper_mps2:+.3f} m/s^2"
    return f"{name:32} R2 {one.r2_exposed:6.3f}, rmse {one.rmse_exposed_mps2:.3f} m/s^2, n {one.n}{upper}"


if __name__ == "__main__":
    sys.exit(main())
