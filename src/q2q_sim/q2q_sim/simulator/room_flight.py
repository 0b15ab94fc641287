"""Flight of a room through nodes: what to publish after the start, a command and each timer event.

In lockstep the command of a tick starts the next one; without it, the time-outs of `ResendTimer` apply. In
live flight, and with the vehicles' own firmware, ticks follow every 10 ms, and the newest command is flown:
one that comes after the next frame is late, its tick missed, and it is flown if none newer comes. A live
flight that starts after other nodes (`starts_after`) begins once any command has come after its first frame:
of a controller that is sending already, DDS may deliver nothing until the next heartbeat, 3 s later.
"""

from collections.abc import Callable
from dataclasses import replace

from q2q_model.counted import listed
from q2q_model.diagnostics.health import Health
from q2q_model.signals.cdr.cdr_format import header_stamp_ns
from q2q_model.signals.cdr.cdr_reader import SignalReader
from q2q_model.signals.stamps import TICK_S
from q2q_model.signals.values import Array, SwarmCommand
from q2q_sim.air.air_names import AirError
from q2q_sim.link.conflicting_commands import ConflictingCommands
from q2q_sim.loop.command_gate import CommandGate
from q2q_sim.loop.room import Room, Tick
from q2q_sim.scenarios.scenario import Scenario
from q2q_sim.simulator.command_stamps import CommandStamps
from q2q_sim.simulator.flight_clock import FlightClock
from q2q_sim.simulator.flight_output import NOTHING, Output, StampedSignal
from q2q_sim.simulator.locked_motors import LockedMotors
from q2q_sim.simulator.resend_timer import ResendTimer
from q2q_sim.simulator.simulator_params import SimulatorParams

FIRST_AGAIN_S, FIRST_TIMEOUT_S = 0.1, 10.0
"""Live, after other nodes: period of the first frame, and time after which the flight begins anyway [s]:
three heartbeats of DDS, of which one may be lost."""
STALL_CHECK_S = 0.05
"""Period of the check for stalled ticks in lockstep [s]."""


_NEVER_HEARD = (
    f"no command within {FIRST_TIMEOUT_S:g} s of the first frame: the flight begins without: check that "
    "`starts_after` names all nodes of the control loop"
)


class RoomFlight:
    """Room, the pace of its ticks, and the timing of the flight."""

    def __init__(
        self,
        room: Room,
        params: SimulatorParams,
        duration: float,
        wall_clock: Callable[[], float],
        firmware: Callable[[Array], None] | None = None,
    ) -> None:
        """Take a room before its first tick.

        Args:
            room: vehicles, air, cameras and radio.
            params: pace and time-outs.
            duration: simulated length of the flight [s].
            wall_clock: returns the wall time [s].
            firmware: moves the vehicles by one tick instead of commands (CRTP).
        """
        self._room = room
        self._duration = duration
        self._wall_clock = wall_clock
        self._firmware = firmware
        self._lockstep = params.pace == "lockstep" and firmware is None
        self._gate = CommandGate(room.names, exact=self._lockstep)
        self._stamps = CommandStamps(exact=self._lockstep)
        self._resend = ResendTimer(params.resend_period_s, params.command_timeout_s)
        self._give_up_warning = (
            f"no command in {params.command_timeout_s:g} s (`command_timeout_s`): the vehicles fly without "
            f"one, a tick every {params.resend_period_s:g} s"
        )
        self._is_heard = False
        """Whether a command has come since the first frame."""
        self._first: ResendTimer | None = None
        if params.pace == "live" and params.starts_after and firmware is None:
            self._first = ResendTimer(FIRST_AGAIN_S, FIRST_TIMEOUT_S)
        self._locks = LockedMotors()
        self._reader = SignalReader(SwarmCommand)
        self._command: SwarmCommand | None = None
        self._is_answered = False
        """Whether the command is that of the tick."""
        self._tick: Tick | None = None
        self._started = self._is_over = False
        self.clock = FlightClock()
        self.health = Health()
        self.conflicts = ConflictingCommands()

    @property
    def is_flying(self) -> bool:
        """Return whether the flight has started and is not over."""
        return self._started

    @property
    def refusal(self) -> str:
        """Return why the flight cannot start; empty if it can."""
        if self._is_over:
            return "the flight is over: restart the node for another one"
        return "already flying" if self.is_flying else ""

    @property
    def locked(self) -> str:
        """Return which vehicles keep their motors off, why, and what to do; empty if none does."""
        names = self._room.locked if self.is_flying and self._firmware is None and not self.misstamped else ()
        return self._locks.note(names)

    @property
    def misstamped(self) -> str:
        """Return that commands have stamps of no frame, and what to do; empty if no tick suffers from it."""
        suffers = self._is_stalled if self._lockstep else self._tick is not None
        return self._stamps.warning if suffers else ""

    @property
    def awaited(self) -> str:
        """Return what a stalled tick in lockstep waits for; empty if none does, or stamps are the cause."""
        if not self._is_stalled or self.misstamped:
            return ""
        return f"command of {listed(self._gate.missing())} not received: check that a controller runs"

    @property
    def _is_stalled(self) -> bool:
        waits = self._lockstep and self._tick is not None
        return waits and self._resend.is_stalled(self._wall_clock())

    @property
    def period_s(self) -> float:
        """Return the period of timer events [s]."""
        return STALL_CHECK_S if self._lockstep else TICK_S

    def start(self) -> Output:
        """Return the first tick in lockstep; live, the next timer event does, to give it a whole period.

        Nothing if already flying, or if the flight is over.
        """
        if self.refusal:
            return NOTHING
        self._started = True
        return self._first_tick() if self._lockstep else NOTHING

    def receive(self, data: bytes) -> Output:
        """Take a serialised command; return the next tick if it was complete and the pace is lockstep."""
        try:
            stamp_ns, command = header_stamp_ns(data), self._reader.received(data)
        except ValueError as refusal:
            return self._refused(refusal)
        return self.take(stamp_ns, command)

    def take(self, stamp_ns: int, offered: SwarmCommand) -> Output:
        """Take the command of a stamp [ns], as `receive` does."""
        self._locks.take(offered.names)
        try:
            command = self._gate.offer(stamp_ns, offered)
        except ValueError as refusal:
            return self._refused(refusal)
        self.conflicts.take(stamp_ns, offered)
        if self._tick is not None:
            self._is_heard = True
            self._stamps.take(stamp_ns, self._tick.frame_stamp_ns)
        if command is None or self._tick is None or (self._lockstep and self._command is not None):
            return NOTHING
        answered_ns = self._gate.stamp_of(command, stamp_ns)
        self.clock.command_in(answered_ns, self._wall_clock())
        self._resend.answered()
        self._command, self._is_answered = command, answered_ns == self._tick.frame_stamp_ns
        return self._advance() if self._lockstep else NOTHING

    def on_timer(self) -> Output:
        """Return the next tick; in lockstep, only once the tick is given up, else its frame if it is due."""
        if self._tick is None:
            return self._first_tick() if self._started else NOTHING
        if self._first is not None:
            return self._await_first_command(self._first, self._tick)
        if not self._lockstep:
            return self._advance()
        now, is_first = self._wall_clock(), not self._resend.has_given_up
        if self._resend.poll_expiry(now):
            return replace(self._advance(), gave_up=self._give_up_warning if is_first else "")
        return Output((_frame(self._tick),)) if self._resend.poll_resend(now) else NOTHING

    def _await_first_command(self, timer: ResendTimer, tick: Tick) -> Output:
        """Return the next tick once a command has come or the first is given up, else its frame if due."""
        now = self._wall_clock()
        if not self._is_heard and not timer.poll_expiry(now):
            return Output((_frame(tick),)) if timer.poll_resend(now) else NOTHING
        self._first = None
        return replace(self._advance(), gave_up="" if self._is_heard else _NEVER_HEARD)

    def _advance(self) -> Output:
        self.health.ticks += 1
        if self._firmware is not None:
            self._room.fly(self._firmware)
            return self._next_tick()
        if not self._is_answered:
            self.clock.missed()
            self.health.missed += 1
        if self._command is None:
            self._command = self._gate.arrived()  # some of several controllers have answered
        refused = self._fly_command()
        self._command, self._is_answered = None, False
        flown = self._room.tick * TICK_S
        if flown < self._duration:
            return self._next_tick(refused.refusal)
        self._tick, self._started, self._is_over = None, False, True
        return Output(timing=self.clock.timing(self._wall_clock(), flown), refusal=refused.refusal)

    def _fly_command(self) -> Output:
        """Advance the room; without the command if it is not finite: vehicles keep their last setpoint."""
        try:
            self._room.advance(self._command)
        except AirError:
            raise  # without air, no vehicle can fly on
        except ValueError as refusal:
            self._room.advance(None)
            return self._refused(refusal)
        return NOTHING

    def _refused(self, refusal: ValueError) -> Output:
        self.health.refuse(f"command: {refusal}")
        return Output(refusal=str(refusal))

    def _first_tick(self) -> Output:
        now = self._wall_clock()
        self.clock.start(now)
        if self._first is not None:
            self._first.begin(now)
        return self._next_tick()

    def _next_tick(self, refusal: str = "") -> Output:
        self._tick = tick = self._room.capture()
        self._gate.expect(tick.frame_stamp_ns)
        now = self._wall_clock()
        self._resend.begin(now)
        self.clock.frame_out(tick.frame_stamp_ns, now)
        truths = (
            StampedSignal("truth", tick.truth, tick.stamp_ns),
            StampedSignal("truth_interference", tick.truth_interference, tick.stamp_ns),
            StampedSignal("imu", self._room.imu(), tick.stamp_ns),
        )
        return Output((_frame(tick), *truths), clock_ns=tick.stamp_ns, refusal=refusal)


def _frame(tick: Tick) -> StampedSignal:
    return StampedSignal("mocap", tick.frame, tick.frame_stamp_ns)


def warm_up_room(scenario: Scenario, seed: int) -> Room:
    """Return a new room, after two ticks of a temporary one: the first real tick is not slow."""
    temporary = Room(scenario, seed=0)
    for _ in range(2):
        temporary.imu()
        temporary.advance(None)
    return Room(scenario, seed)
