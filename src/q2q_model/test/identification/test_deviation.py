"""Deviation of a pair above each other, and its decay with the gap."""

from dataclasses import replace

import numpy as np
import pytest
from made_flights import PASSES, Pass, made_flight, record_of

from q2q_model.identification.deviation import DeviationParams, fit_decay, overlap_of, overlaps_of
from q2q_model.identification.gains.altitude_record import AltitudeRecord
from q2q_model.identification.identification import ProcedureParams, identify
from q2q_model.recordings.flight_recording import Recording
from q2q_model.tools.identify_report import report


def test_dev_is_the_mean_of_both_deviations_while_above_each_other() -> None:
    record = record_of(replace(PASSES[0], noise=0.0))
    overlap = overlap_of(record, DeviationParams(steady=0.0))
    assert overlap is not None
    over = np.hypot(*(record.pos[:, 1] - record.pos[:, 0])[:, :2].T) <= 0.1
    away = np.abs(record.pos[over, :, 2] - [1.0, 1.4]).sum(axis=1)
    assert overlap.dev == pytest.approx(away.mean(), rel=0.02)  # less the clear-air bias, a few of a percent
    assert overlap.gap == pytest.approx(np.abs(np.diff(record.pos[over, :, 2], axis=1)).mean())


def test_a_constant_deviation_in_clear_air_is_no_disturbance() -> None:
    record = record_of(PASSES[0])
    ref = record.ref.copy()
    ref[..., 0] += 0.03
    shifted = replace(record, ref=ref)
    before, after = (overlap_of(one, DeviationParams(steady=0.0)) for one in (record, shifted))
    assert before is not None
    assert after is not None
    assert after.dev == pytest.approx(before.dev, rel=1e-6)


def test_a_short_excursion_in_clear_air_does_not_move_the_bias() -> None:
    record = record_of(PASSES[0])
    alone = np.hypot(*(record.pos[:, 1] - record.pos[:, 0])[:, :2].T) > 0.5
    pos = record.pos.copy()
    pos[np.flatnonzero(alone)[: alone.sum() // 10], :, 2] += 0.5
    before, after = (
        overlap_of(one, DeviationParams(steady=0.0)) for one in (record, replace(record, pos=pos))
    )
    assert before is not None
    assert after is not None
    assert after.dev == pytest.approx(before.dev, abs=1e-3)  # a mean would move by 50 mm a vehicle


def test_the_decay_fit_finds_the_law_it_was_drawn_from_and_says_when_d_was_not_flown() -> None:
    decay = fit_decay([record_of(one) for one in PASSES], DeviationParams(steady=0.0, allowed=0.005))
    gaps = np.array([overlap.gap for overlap in decay.overlaps])
    devs = np.array([overlap.dev for overlap in decay.overlaps])
    curve = decay.alpha.value * np.exp(-decay.beta.value * gaps)
    np.testing.assert_allclose(curve, devs, rtol=0.05)  # the paper's law is no exponential
    assert decay.alpha.value * np.exp(-decay.beta.value * decay.d.value) == pytest.approx(0.005, rel=1e-6)
    assert decay.extrapolated
    assert decay.d.low <= decay.d.value <= decay.d.high


def test_two_flights_determine_no_interval_of_the_decay() -> None:
    flights = [record_of(one) for one in PASSES[:2]]
    decay = fit_decay(flights, DeviationParams(steady=0.0, allowed=0.005))
    assert decay.d.low == 0.0
    assert decay.d.high == 10.0  # the bound of d: above the height of any flight room
    assert decay.alpha.high > 1e6  # two flights, two parameters: no residual says how well they are known
    assert decay.beta.high - decay.beta.low > 10.0


@pytest.mark.parametrize("devs", [(0.01, 0.03, 0.09), (0.03, 0.05, 0.09), (0.05, 0.05, 0.05)])
def test_a_deviation_that_does_not_decay_shows_no_d(devs: tuple[float, ...]) -> None:
    """By the curve through the first, alpha is 6 mm: within 2 cm at a gap of 0, where nobody flew."""
    with pytest.raises(ValueError, match=r"does not fall with the gap to 0.02 m within 10 m \(0.0\d0 m at"):
        fit_decay([shifted(gap, dev) for gap, dev in zip((0.3, 0.6, 0.9), devs, strict=True)])


def test_flights_at_nearly_one_gap_are_said_to_be_so_and_keep_their_deviations() -> None:
    flights = [shifted(gap, dev) for gap, dev in ((0.31, 0.05), (0.32, 0.1))]
    with pytest.raises(ValueError, match=r"gaps flown are too alike .* \(0.050 m at 0.31 m, 0.100 m at 0.32"):
        fit_decay(flights)
    assert [one.dev for one in overlaps_of(flights)] == pytest.approx([0.05, 0.1])


def test_a_report_has_the_deviation_of_each_flight_also_without_a_decay() -> None:
    flight = made_flight(Pass(gap=0.4, speed=0.3, seconds=24.0, noise=1e-4))
    twice = [Recording(replace(flight, name=name)) for name in ("first", "second")]
    found = identify(twice, ProcedureParams(model_type="jet"), lambda _: None)
    zone = report(found, {})["zone"]
    assert isinstance(zone, dict)
    assert (found.decay, zone["d_m"]) == (None, None)
    assert [one["flight"] for one in zone["dev"]] == ["first", "second"]


def test_a_deviation_that_grows_but_is_allowed_at_every_gap_flown_needs_no_zone() -> None:
    decay = fit_decay([shifted(gap, dev) for gap, dev in ((0.3, 0.001), (0.6, 0.002), (0.9, 0.004))])
    assert decay.beta.value < 0.0
    assert decay.d.value == 0.0


def shifted(gap: float, dev: float) -> AltitudeRecord:
    """Return the record of two still vehicles, a gap [m] apart, the lower dev [m] off its reference."""
    made = record_of(PASSES[0])
    pos, ref = np.zeros_like(made.pos), np.zeros_like(made.ref)
    pos[:, :, 2], ref[:, :, 0] = [1.0, 1.0 + gap], [1.0 - dev, 1.0 + gap]
    return replace(made, name=f"gap {gap}", pos=pos, ref=ref)


def test_one_flight_with_overlap_gives_no_decay() -> None:
    near = record_of(PASSES[0])
    with pytest.raises(ValueError, match="1 of 2 flights have vehicles within"):
        fit_decay(
            [near, replace(near, name="far", pos=near.pos + np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]]))]
        )


def test_pieces_of_one_flight_count_as_one_in_the_decay() -> None:
    one, other = (record_of(each) for each in PASSES[:2])
    with pytest.raises(ValueError, match="1 of 1 flights have vehicles within"):
        fit_decay([one, replace(other, name=one.name)])
    params = DeviationParams(steady=0.0, allowed=0.005)
    decay = fit_decay([one, replace(one, name="again"), replace(other, name="again")], params)
    first, joined = decay.overlaps
    alone = fit_decay([one, other], params).overlaps[1]
    assert joined.seconds == pytest.approx(first.seconds + alone.seconds)
    expected = (first.gap * first.seconds + alone.gap * alone.seconds) / joined.seconds
    assert joined.gap == pytest.approx(expected)
