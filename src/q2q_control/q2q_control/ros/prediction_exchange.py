"""Exchange of predictions between `mpc` nodes over the topic `predictions`.

In lockstep a tick begins once the predictions that neighbours have sent by the tick before are here, or its
inputs come a second time, because the simulator has waited too long. Live, it begins with what is here.
"""

from collections.abc import Mapping

from q2q_msgs.msg import Prediction as PredictionMessage
from rclpy.node import Node

from q2q_control.mpc.prediction.awaited import AwaitedPredictions
from q2q_control.mpc.prediction.neighbours import SILENT
from q2q_control.mpc.prediction.slots import BroadcastSchedule
from q2q_control.mpc.receding import Mpc
from q2q_control.ros.prediction_message import decode_prediction, encode_prediction
from q2q_model.ros.node.tick import TickWiring
from q2q_model.ros.topics.qos import MANY_WRITERS, TICK_WRITER
from q2q_model.signals.layout import Signal
from q2q_model.signals.values import Names, SwarmCommand, SwarmState

TOPIC = "predictions"


class PredictionExchange:
    """Publisher and subscription of the predictions of one node."""

    def __init__(self, node: Node, mpc: Mpc, vehicles: Names, period: float) -> None:
        if not vehicles:
            raise ValueError("distributed = true: name the vehicles of this node in `vehicles`")
        self._mpc, self._vehicles = mpc, vehicles
        self._awaited = AwaitedPredictions(vehicles, period, mpc.has_heard)
        self._schedule = BroadcastSchedule(vehicles, period)
        self._state: SwarmState | None = None
        self._waits = True
        self._silent: Names = ()
        self._publisher = node.create_publisher(PredictionMessage, TOPIC, TICK_WRITER)
        self._node = node

    def wire(self, wiring: TickWiring[SwarmCommand], *, live: bool) -> None:
        """Publish in turn after a command, hear the neighbours and, in lockstep, wait for them."""
        self._wiring, self._waits = wiring, not live
        self._awaited.reset()  # of the rehearsal
        self._schedule.reset()
        wiring.after_publish(self._publish)
        if self._waits:
            wiring.hold_until(self._may_begin)
        wiring.add_facts(self._facts)
        self._node.create_subscription(PredictionMessage, TOPIC, self._hear, MANY_WRITERS)

    def begin(self, state: SwarmState) -> None:
        """Take the state of a tick that begins."""
        self._state = state
        if self._waits:
            self._awaited.begin(state)

    def _may_begin(self) -> bool:
        return self._awaited.complete()

    def _publish(self, _: int, __: Signal) -> None:
        prediction = self._mpc.prediction
        if prediction is not None and self._state is not None and self._schedule.take_turn(self._state):
            self._publisher.publish(encode_prediction(prediction))

    def _hear(self, message: PredictionMessage) -> None:
        if not set(message.names).isdisjoint(self._vehicles):
            return
        try:
            self._mpc.hear(decode_prediction(message))
        except ValueError as refusal:
            self._wiring.health.refuse(f"{TOPIC}: {refusal}")
        self._wiring.resume()

    def _facts(self) -> Mapping[str, str]:
        """Return which neighbours are silent; log it when it changes."""
        silent = self._mpc.silent_neighbours(self._state.t) if self._state is not None else ()
        names = ", ".join(silent)
        told = f"{TOPIC}: none of {names} for {SILENT} periods: followed without, is its MPC running?"
        if silent and silent != self._silent:
            self._node.get_logger().warning(told)
        self._silent = silent
        self._wiring.health.doubts[TOPIC] = told if silent else ""
        return {"silent_neighbours": names}
