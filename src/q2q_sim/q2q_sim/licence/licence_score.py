"""Score of licences: programs with a seeded bug must fail, and sound ones pass.

A folder has the programs in `sound` and `buggy`, and `programs.toml` says where their vehicles start and how
large their room is. A bug is found if a flight breaks a rule. The trials of a program with a bug end with the
flight without faults if that breaks one.
"""

import math
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from q2q_model.documents.json_file import Json
from q2q_model.documents.plain_values import from_plain
from q2q_model.nearest_name import name_hint
from q2q_sim.licence.flight_order import Program
from q2q_sim.licence.licence_flights import licence
from q2q_sim.licence.licence_options import LicenceOptions
from q2q_sim.licence.licence_reports import verdict_text
from q2q_sim.licence.program_process.link_host import scanned_uris
from q2q_sim.licence.rules.licence_limits import LicenceLimits

SOUND, BUGGY = "sound", "buggy"
KINDS = (SOUND, BUGGY)
"""Folders of the programs."""


@dataclass(frozen=True, slots=True)
class ProgramSettings:
    """Entry of `programs.toml`."""

    start: tuple[tuple[float, ...], ...] = ()
    """x, y [m] and yaw [deg] of every vehicle."""
    room: tuple[float, ...] = (6.0, 6.0, 2.5)
    """[m]"""
    arming: bool = False
    """The vehicles do not arm themselves."""


@dataclass(frozen=True, slots=True)
class ScoredProgram:
    """Program with what is known of it."""

    file: Path
    sound: bool
    settings: ProgramSettings = field(default_factory=ProgramSettings)

    @property
    def name(self) -> str:
        """Return the name of the program."""
        return self.file.stem


@dataclass(frozen=True, slots=True)
class LicenceScore:
    """Verdict on a program of which the right one is known."""

    program: ScoredProgram
    passed: bool
    verdict: str
    flights: int
    seconds: float
    judged: bool = True
    """False if no flight failed, but the simulator did in one."""

    @property
    def right(self) -> bool:
        """Return whether a sound program passed, or one with a bug did not."""
        return self.judged and self.passed == self.program.sound

    @property
    def failed(self) -> bool:
        """Return whether the program was judged, and did not pass."""
        return self.judged and not self.passed

    @property
    def word(self) -> str:
        """Return in one word whether the verdict is right."""
        if not self.judged:
            return "ERROR"
        return "right" if self.right else "WRONG"


def scored_programs(folder: Path, only: Sequence[str]) -> list[ScoredProgram]:
    """Return the programs of a folder, all or those named.

    Raises:
        ValueError: there is no program, or none of a name; or a setting is not allowed.
        OSError: `programs.toml` cannot be read.
    """
    files = [file for kind in KINDS for file in sorted((folder / kind).glob("*.py"))]
    _check_names(folder, [file.stem for file in files], only)
    text = (folder / "programs.toml").read_text(encoding="utf-8")
    entries = from_plain(Mapping[str, ProgramSettings], tomllib.loads(text), "")  # type: ignore[type-abstract]
    return [
        ScoredProgram(file.resolve(), file.parent.name == SOUND, entries.get(file.stem, ProgramSettings()))
        for file in files
        if not only or file.stem in only
    ]


def _check_names(folder: Path, known: Sequence[str], only: Sequence[str]) -> None:
    """Raise ValueError if there is no program, or none of a name in `only`."""
    if not known:
        raise ValueError(f"--score {folder}: no program in it; must have .py files in {' or '.join(KINDS)}")
    unknown = [f"{name} ({name_hint(name, known)})" for name in only if name not in known]
    if unknown:
        raise ValueError(f"--only: {folder} has no program {', '.join(unknown)}")


def score_program(program: ScoredProgram, jobs: int, seed: int) -> LicenceScore:
    """Return the verdict on a program."""
    one = program.settings
    starts = tuple((x, y, math.radians(yaw)) for x, y, yaw in ((*row, 0.0)[:3] for row in one.start))
    x, y, z = one.room
    options = LicenceOptions(
        starts=starts,
        limits=LicenceLimits(half_room=(0.5 * x, 0.5 * y), ceiling=z),
        arming=one.arming,
        scanned=scanned_uris(max(len(starts), 1)),
        jobs=jobs,
        seed=seed,
    )
    found = licence(Program(program.file, (), program.file.parent), options)
    return LicenceScore(
        program, found.passed, verdict_text(found), len(found.flights), found.seconds, found.judged
    )


def licence_score_json(found: Sequence[LicenceScore]) -> Json:
    """Return the totals of a score: the contract of `licence --score --json`."""
    sound = [one for one in found if one.program.sound]
    buggy = [one for one in found if not one.program.sound]
    return {
        "sound": len(sound),
        "alarms": sum(one.failed for one in sound),
        "seeded_bugs": len(buggy),
        "seeded_found": sum(one.failed for one in buggy),
        "not_judged": sum(not one.judged for one in found),
        "flights": sum(one.flights for one in found),
        "seconds": sum(one.seconds for one in found),
        "programs": [
            {
                "name": one.program.name,
                "sound": one.program.sound,
                "passed": one.passed,
                "verdict": one.verdict,
                "flights": one.flights,
                "seconds": one.seconds,
            }
            for one in found
        ],
    }
