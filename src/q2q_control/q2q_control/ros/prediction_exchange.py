"""Exchange of predictions between `mpc` nodes over the topic `predictions`.

In lockstep a tick begins once the predictions that neighbours have sent by the tick before are here, or its
inputs come a second time, because the simulator has waited too long. Live, it begins with what is here.
"""

from q2q_msgs.msg import Prediction as PredictionMessage
from rclpy.node import Node

from q2q_control.mpc.mpc import Mpc
from q2q_control.mpc.neighbours.awaited_predictions import AwaitedPredictions
from q2q_control.mpc.neighbours.exchanged_paths import SILENT
from q2q_control.mpc.neighbours.own_predictions import OwnPredictions
from q2q_control.mpc.neighbours.time_slots import BroadcastSchedule
from q2q_control.ros.prediction_message import decode_prediction, encode_prediction
from q2q_model.counted import listed
from q2q_model.ros.node.publisher_conflicts import publishers_of
from q2q_model.ros.node.tick_wiring import TickWiring
from q2q_model.ros.topics.messages import stamp_of
from q2q_model.ros.topics.qos import MANY_WRITERS, TICK_WRITER
from q2q_model.signals.layout import Signal
from q2q_model.signals.topic_names import PREDICTIONS
from q2q_model.signals.values import Names, SwarmCommand, SwarmState


class PredictionExchange:
    """Publisher and subscription of the predictions of one node."""

    def __init__(self, node: Node, mpc: Mpc, vehicles: Names, period: float) -> None:
        if not vehicles:
            raise ValueError("distributed = true: name the vehicles of this node in `vehicles`")
        self._mpc, self._vehicles = mpc, vehicles
        self._awaited = AwaitedPredictions(vehicles, period, mpc.has_received)
        self._schedule = BroadcastSchedule(vehicles, period)
        self._state: SwarmState | None = None
        self._waits = True
        self._silent: Names = ()
        self._own = OwnPredictions()
        self._warned: set[Names] = set()
        self._publisher = node.create_publisher(PredictionMessage, PREDICTIONS, TICK_WRITER)
        self._node = node

    def wire(self, wiring: TickWiring[SwarmCommand], *, live: bool) -> None:
        """Publish in turn after a command, receive from the neighbours and, in lockstep, wait for them."""
        self._wiring, self._waits = wiring, not live
        self._awaited.reset()  # of the warm-up
        self._schedule.reset()
        wiring.after_publish(self._publish)
        if self._waits:
            wiring.hold_until(self._may_begin)
        wiring.check_each_second(self._look_for_neighbours)
        wiring.add_diagnostic_values(lambda: {"silent_neighbours": listed(self._silent)})
        self._node.create_subscription(PredictionMessage, PREDICTIONS, self._receive, MANY_WRITERS)

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
            message = encode_prediction(prediction)
            self._own.send(stamp_of(message.header))
            self._publisher.publish(message)

    def _receive(self, message: PredictionMessage) -> None:
        try:
            if own := set(message.names).intersection(self._vehicles):
                self._own.receive(stamp_of(message.header), own)
                return
            self._mpc.receive(decode_prediction(message))
            self._wiring.resume()
        except ValueError as refusal:
            self._wiring.health.refuse(f"{PREDICTIONS}: {refusal}")

    def _look_for_neighbours(self) -> None:
        """Report which neighbours are silent, and that others fly own vehicles."""
        self._wiring.health.doubts[f"{PREDICTIONS} conflicts"] = self._conflicts()
        silent = self._mpc.silent_neighbours(self._state) if self._state is not None else ()
        names = listed(silent)
        report = (
            f"{PREDICTIONS}: none of {names} for {SILENT} periods: their references are used "
            "instead; check that their MPC runs"
        )
        if silent and silent != self._silent:
            self._node.get_logger().warning(report)
        self._silent = silent
        self._wiring.health.doubts[PREDICTIONS] = report if silent else ""

    def _conflicts(self) -> str:
        """Return which own vehicles another node predicts, empty for none; warn of it the first time."""
        conflicts = self._own.take_conflicts()
        if not conflicts:
            return ""
        writers = listed(publishers_of(self._node, PREDICTIONS))
        report = f"{PREDICTIONS}: another node also flies {listed(conflicts)}: stop one ({writers} write it)"
        if conflicts not in self._warned:
            self._warned.add(conflicts)
            self._node.get_logger().warning(report)
        return report
