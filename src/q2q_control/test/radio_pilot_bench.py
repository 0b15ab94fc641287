"""A radio pilot with links that keep what they are told, for tests."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from resting_signals import resting_state

from q2q_control.flight_procedure.steps import Act, Order
from q2q_control.radio.link.setpoints import (
    FullState,
    RpytSetpoint,
)
from q2q_control.radio.link.vehicle_link import LinkHealth
from q2q_control.radio.pilot.pilot_params import RadioPilotParams
from q2q_control.radio.pilot.radio_pilot import RadioPilot
from q2q_control.radio.pilot.vehicle_record import Phase
from q2q_model.node.reply import Reply
from q2q_model.signals.values import (
    SwarmState,
    TrackStatus,
)

NAMES = ("cf1", "cf2")
WELL = LinkHealth(connected=True, volt=4.0, armed=True)
PARAMS = RadioPilotParams()
LANDING_S = 3.0 / 0.4, 6.0 / 0.4
"""From 3 m and 6 m at 0.4 m/s."""
HOVER = RpytSetpoint(0.0, 0.0, 0.0, 30000)


@dataclass
class FakeLink:
    """Write down what is sent."""

    now: LinkHealth = WELL
    sent: list[object] = field(default_factory=list)

    def health(self) -> LinkHealth:
        """Return the health that is set."""
        return self.now

    def send_rpyt(self, setpoint: RpytSetpoint) -> None:
        """Keep a setpoint."""
        self.sent.append(setpoint)

    def send_full_state(self, demanded: FullState) -> None:
        """Keep a setpoint."""
        self.sent.append(demanded)

    def send_external_pose(self, pos: Sequence[float], quat: Sequence[float] | None) -> None:
        """Keep a place."""
        self.sent.append(("place", tuple(pos), None if quat is None else tuple(quat)))

    def arm(self) -> None:
        """Keep the word."""
        self.sent.append("arm")

    def disarm(self) -> None:
        """Keep the word."""
        self.sent.append("disarm")

    def take_off(self, height: float, duration: float) -> None:
        """Keep the word."""
        self.sent.append(("take off", height, duration))

    def land(self, height: float, duration: float) -> None:
        """Keep the word."""
        self.sent.append(("land", height, duration))

    def cut(self) -> None:
        """Keep the word."""
        self.sent.append("cut")

    def close(self) -> None:
        """Keep the word."""
        self.sent.append("close")


@dataclass
class Bench:
    """Links of two vehicles and the pilot, at a time set by tests."""

    links: dict[str, FakeLink] = field(default_factory=lambda: {name: FakeLink() for name in NAMES})
    t: float = 100.0
    hover: RpytSetpoint | None = HOVER
    ground_height: float = 0.0

    def __post_init__(self) -> None:
        """Start the pilot and let it watch once."""
        self.pilot = RadioPilot(self.links, PARAMS, self.hover, ground_height=self.ground_height)
        self.pilot.watch(self.t)

    def see(self, status: TrackStatus = TrackStatus.TRACKED) -> None:
        """Show the pilot where the vehicles are."""
        self.pilot.update_state(state(self.t, status), self.t)

    def fly(self) -> None:
        """Arm, and let commands through."""
        self.see()
        for act in (Act.ARM, Act.STREAM):
            assert self.done(act).granted
        assert set(self.pilot.phases.values()) == {Phase.FLYING}

    def done(self, act: Act) -> Reply:
        """Give an order and return what became of it."""
        self.pilot.begin(Order(act, 0.5, 2.0), self.t)
        self.pilot.watch(self.t)
        reply = self.pilot.outcome(self.t)
        assert reply is not None
        return reply

    def rpyt_setpoints(self) -> None:
        """Send both vehicles a setpoint."""
        self.pilot.fly_rpyt(NAMES, [RpytSetpoint(1.0, 2.0, 3.0, 30000)] * 2, self.t)

    def look(self, later: float) -> None:
        """Look once, so much later [s]."""
        self.t += later
        self.pilot.watch(self.t)

    def silent_until(self, age: float, *, seen: bool) -> list[object]:
        """Look every 20 ms until the last command is `age` old; return what cf1 was sent."""
        began = self.t
        before = len(self.links["cf1"].sent)
        while self.t < began + age - 1e-9:
            self.t += 0.02
            if seen:
                self.see()
            self.pilot.watch(self.t)
        sent = self.links["cf1"].sent[before:]
        return [one for one in sent if not (isinstance(one, tuple) and one[0] == "place")]


def state(t: float, status: TrackStatus = TrackStatus.TRACKED) -> SwarmState:
    pos = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])
    return resting_state(t, NAMES, pos, status=np.full(2, status, dtype=np.uint8))
