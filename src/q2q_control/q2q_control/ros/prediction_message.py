"""Conversion of a prediction to its message and back, for the topic `predictions`."""

from array import array

import numpy as np
from q2q_msgs.msg import Prediction as PredictionMessage

from q2q_control.mpc.neighbours.exchanged_paths import PredictedPaths
from q2q_model.ros.topics.messages import header_at, stamp_of
from q2q_model.signals.stamps import stamp_from_time, time_from_stamp


def encode_prediction(prediction: PredictedPaths) -> PredictionMessage:
    """Return the message of a prediction."""
    return PredictionMessage(
        header=header_at(stamp_from_time(prediction.t)),
        names=list(prediction.names),
        start=prediction.start - prediction.t,
        step=prediction.step,
        position=array("f", prediction.pos.tobytes()),
    )


def decode_prediction(message: PredictionMessage) -> PredictedPaths:
    """Return the prediction in a message; raise ValueError if it is not valid."""
    names = tuple(message.names)
    if not names or len(message.position) % (3 * len(names)):
        raise ValueError(f"{len(message.position)} coordinates of {len(names)} vehicles; must be 3NK")
    t = time_from_stamp(stamp_of(message.header))
    pos = np.array(message.position, np.float32).reshape(len(names), -1, 3)
    return PredictedPaths(t, names, t + message.start, message.step, pos)
