"""A prediction passes through its message, and a message that does not fit is refused."""

from array import array

import numpy as np
import pytest

from q2q_control.mpc.neighbours.exchanged_paths import PredictedPaths
from q2q_control.ros.prediction_message import decode_prediction, encode_prediction


def test_a_prediction_is_the_same_after_its_message() -> None:
    pos = np.arange(24, dtype=np.float32).reshape(2, 4, 3)
    sent = PredictedPaths(1.23, ("cf1", "cf2"), 1.256, 0.05, pos)
    found = decode_prediction(encode_prediction(sent))
    assert (found.t, found.names, found.step) == (sent.t, sent.names, sent.step)
    assert found.start == pytest.approx(sent.start, abs=1e-12)
    assert (found.pos == pos).all()


def test_a_message_whose_positions_do_not_fit_its_names_is_refused() -> None:
    message = encode_prediction(PredictedPaths(0.0, ("cf1",), 0.0, 0.05, np.zeros((1, 4, 3), np.float32)))
    message.position = array("f", [0.0] * 11)
    with pytest.raises(ValueError, match="11 coordinates of 1 vehicles"):
        decode_prediction(message)
    message.position = array("f", [0.0] * 3)
    with pytest.raises(ValueError, match="2 to 401"):
        decode_prediction(message)
