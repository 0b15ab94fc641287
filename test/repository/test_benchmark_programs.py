"""Programs of benchmarks/ beside bench: where nobody could read what they measure, they do not measure."""

import sys
from collections.abc import Callable, Sequence

import pytest

import encounters
import risk
import tick_profile


@pytest.mark.parametrize(
    ("program", "words"),
    [
        (encounters.main, ["--count", "1"]),
        (risk.main, ["tube", "--tube", "0.08", "0.06"]),
        (tick_profile.main, ["pure", "--out", "tick.svg"]),
    ],
)
def test_a_closed_standard_output_is_refused_before_the_work(
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
    program: Callable[[Sequence[str]], int],
    words: list[str],
) -> None:
    monkeypatch.setattr(sys, "stdout", None)
    with pytest.raises(SystemExit, match="2"):
        program(words)
    assert ": standard output is closed: redirect it" in capfd.readouterr().err
