# SPDX-License-Identifier: GPL-3.0-or-later
"""The firmware's supervisor: when the motors may run and when they must stop.

After supervisor.c and supervisor_state_machine.c of crazyflie-firmware, with the transitions of its
tables. Not simulated: deck faults and the checks of motor speeds.
"""

from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum, IntFlag, auto

from ground.sim.model import Mode, Setpoint

PERIOD_MS = 40
_IS_FLYING_HYSTERESIS_MS = 2000
_LEVEL_OUT_AFTER_MS = 500
_CUT_AFTER_MS = 2000
_ESTOP_WATCHDOG_MS = 1000
_PREFLIGHT_TIMEOUT_MS = 30000
_LANDED_TIMEOUT_MS = 3000
_TILTED_G, _TILTED_MS = 0.5, 1000
_UPSIDE_DOWN_G, _UPSIDE_DOWN_MS = -0.2, 100


class State(IntEnum):
    """States, numbered as the firmware logs them."""

    PREFLIGHT_FAILED = 1
    PREFLIGHT_PASSED = 2
    READY = 4
    FLYING = 5
    LANDED = 6
    RESET = 7
    LEVEL_OUT = 8
    FREE_FALL = 9
    LOCKED = 10
    CRASHED = 11


class Condition(IntFlag):
    """Conditions on which the transitions depend."""

    ARMED = auto()
    FLYING = auto()
    TUMBLED = auto()
    LEVEL_OUT = auto()
    CUT = auto()
    STOP = auto()
    CRASHED = auto()
    PREFLIGHT_TIMEOUT = auto()
    LANDED_TIMEOUT = auto()


class Info(IntFlag):
    """Bits of supervisor.info."""

    CAN_BE_ARMED = 1
    ARMED = 2
    AUTO_ARM = 4
    CAN_FLY = 8
    FLYING = 16
    TUMBLED = 32
    LOCKED = 64
    CRASHED = 128
    HIGH_LEVEL_FLYING = 256
    HIGH_LEVEL_FINISHED = 512
    HIGH_LEVEL_DISABLED = 1024


_NONE = Condition(0)
_EITHER = Condition.ARMED  # used for both columns, it always holds: set or not set

# New state, if any of the first conditions is set or any of the second is not; first match wins.
_Rule = tuple[State, Condition, Condition]
_TRANSITIONS: dict[State, tuple[_Rule, ...]] = {
    State.PREFLIGHT_FAILED: (
        (State.FREE_FALL, Condition.STOP, _NONE),
        (State.PREFLIGHT_PASSED, _NONE, Condition.TUMBLED),
    ),
    State.PREFLIGHT_PASSED: (
        (State.FREE_FALL, Condition.STOP, _NONE),
        (State.PREFLIGHT_FAILED, Condition.TUMBLED, _NONE),
        (State.READY, Condition.ARMED, _NONE),
    ),
    State.READY: (
        (State.FREE_FALL, Condition.STOP, _NONE),
        (
            State.PREFLIGHT_FAILED,
            Condition.TUMBLED | Condition.PREFLIGHT_TIMEOUT,
            Condition.ARMED,
        ),
        (State.FLYING, Condition.FLYING, _NONE),
    ),
    State.FLYING: (
        (State.FREE_FALL, Condition.CUT | Condition.STOP, _NONE),
        (State.CRASHED, Condition.TUMBLED, _NONE),
        (State.RESET, _NONE, Condition.ARMED),
        (State.LEVEL_OUT, Condition.LEVEL_OUT, _NONE),
        (State.LANDED, _NONE, Condition.FLYING),
    ),
    State.LANDED: (
        (State.RESET, Condition.LANDED_TIMEOUT, Condition.ARMED),
        (State.FLYING, Condition.FLYING, _NONE),
    ),
    State.RESET: ((State.PREFLIGHT_FAILED, _EITHER, _EITHER),),
    State.LEVEL_OUT: (
        (State.FREE_FALL, Condition.CUT | Condition.TUMBLED | Condition.STOP, _NONE),
        (State.FLYING, _NONE, Condition.LEVEL_OUT),
    ),
    State.FREE_FALL: ((State.LOCKED, _EITHER, _EITHER),),
    State.LOCKED: (),
    State.CRASHED: (
        (State.LOCKED, Condition.STOP, _NONE),
        (State.PREFLIGHT_FAILED, _NONE, Condition.CRASHED),
    ),
}
_MOTORS_ALLOWED = frozenset((State.READY, State.FLYING, State.LANDED, State.LEVEL_OUT))


@dataclass(slots=True)
class Inputs:
    """What the supervisor reads from the rest of the firmware."""

    now_ms: int
    motors_run: bool
    acc_z_g: float
    setpoint_age_ms: int
    stop_parameter: bool
    high_level: Info


class Supervisor:
    """The supervisor's state machine; call update() every PERIOD_MS of firmware time."""

    def __init__(self, auto_arm: bool, print_line: Callable[[str], None]) -> None:
        self.info = Info(0)
        self.can_fly = False
        self._auto_arm = auto_arm
        self._print_line = print_line
        self._state = State.PREFLIGHT_FAILED
        self._armed = False
        self._crashed = False
        self._tumbled = False
        self._stop = False
        self._watchdog_ms: int | None = None
        self._thrust_ms: int | None = None
        self._tumble_ms: int | None = None
        self._ready_ms = 0
        self._landed_ms: int | None = None

    @property
    def armed(self) -> bool:
        """Whether the drone is armed, by request or automatically."""
        return self._armed

    @property
    def crashed(self) -> bool:
        """Whether it has crashed and needs a recovery request."""
        return self._crashed

    def request_arming(self, arm: bool) -> bool:
        """Arm or disarm; false if that is not possible in this state."""
        if arm and not self._armed and self._state is not State.PREFLIGHT_PASSED:
            return False
        self._armed = arm
        return True

    def request_recovery(self) -> bool:
        """Clear a crash; false while the drone is still tumbled."""
        if self._crashed and self._tumbled:
            return False
        self._crashed = False
        return True

    def emergency_stop(self) -> None:
        """Cut the motors until the next restart."""
        self._stop = True

    def feed_watchdog(self, now_ms: int) -> None:
        """Start the emergency stop watchdog, or feed it for another second."""
        self._watchdog_ms = now_ms

    def update(self, inputs: Inputs) -> None:
        """Run one step of the state machine."""
        conditions = self._conditions(inputs)
        for state, if_any, unless_all in _TRANSITIONS[self._state]:
            if conditions & if_any or ~conditions & unless_all:
                self._enter(state, inputs.now_ms)
                break
        self._publish(conditions, inputs.high_level)

    def override(self, setpoint: Setpoint) -> Setpoint:
        """Replace the setpoint as this state demands: levelled out, or motors off."""
        if self._state is State.LEVEL_OUT:
            return Setpoint(
                mode_z=setpoint.mode_z,
                mode_roll=Mode.ABSOLUTE,
                mode_pitch=Mode.ABSOLUTE,
                mode_yaw=Mode.VELOCITY,
                z_m=setpoint.z_m,
                vz_mps=setpoint.vz_mps,
                thrust=setpoint.thrust,
                age_ms=setpoint.age_ms,
                priority=setpoint.priority,
            )
        return setpoint if self._state in _MOTORS_ALLOWED else Setpoint()

    def _conditions(self, inputs: Inputs) -> Condition:
        now_ms = inputs.now_ms
        self._tumbled = self._is_tumbled(inputs.acc_z_g, now_ms)
        stop = (
            self._stop
            or inputs.stop_parameter
            or _older(self._watchdog_ms, now_ms, _ESTOP_WATCHDOG_MS)
        )
        if inputs.motors_run:
            self._thrust_ms = now_ms
        flying = self._thrust_ms is not None and not _older(
            self._thrust_ms, now_ms, _IS_FLYING_HYSTERESIS_MS
        )
        waited_ms = now_ms - self._ready_ms if self._state is State.READY else 0
        holds = {
            Condition.ARMED: self._armed,
            Condition.FLYING: flying,
            Condition.TUMBLED: self._tumbled,
            Condition.LEVEL_OUT: inputs.setpoint_age_ms > _LEVEL_OUT_AFTER_MS,
            Condition.CUT: inputs.setpoint_age_ms > _CUT_AFTER_MS,
            Condition.STOP: stop,
            Condition.CRASHED: self._crashed,
            Condition.PREFLIGHT_TIMEOUT: waited_ms > _PREFLIGHT_TIMEOUT_MS,
            Condition.LANDED_TIMEOUT: _older(self._landed_ms, now_ms, _LANDED_TIMEOUT_MS),
        }
        return Condition(sum(condition for condition, true in holds.items() if true))

    def _is_tumbled(self, acc_z_g: float, now_ms: int) -> bool:
        if acc_z_g >= _TILTED_G:
            self._tumble_ms = None
            return False
        if self._tumble_ms is None:
            self._tumble_ms = now_ms
        since_ms = now_ms - self._tumble_ms
        limit_ms = _UPSIDE_DOWN_MS if acc_z_g < _UPSIDE_DOWN_G else _TILTED_MS
        return since_ms > limit_ms

    def _enter(self, state: State, now_ms: int) -> None:
        self._state = state
        if state is State.READY:
            self._ready_ms = now_ms
        elif state is State.LANDED:
            self._landed_ms = now_ms
        elif state is State.LOCKED:
            self._print_line("SUP: Locked, reboot required")
        elif state is State.CRASHED:
            self._print_line("SUP: Crashed, recovery required")
            self._crashed = True
        if state not in _MOTORS_ALLOWED:
            self._armed = self._auto_arm and state is State.PREFLIGHT_PASSED

    def _publish(self, conditions: Condition, high_level: Info) -> None:
        self.can_fly = self._state in _MOTORS_ALLOWED
        holds = {
            Info.CAN_BE_ARMED: self._state is State.PREFLIGHT_PASSED,
            Info.ARMED: self._armed,
            Info.AUTO_ARM: self._auto_arm,
            Info.CAN_FLY: self.can_fly,
            Info.FLYING: self._state in (State.FLYING, State.LEVEL_OUT),
            Info.TUMBLED: bool(conditions & Condition.TUMBLED),
            Info.LOCKED: self._state is State.LOCKED,
            Info.CRASHED: self._crashed,
        }
        self.info = Info(sum(bit for bit, true in holds.items() if true)) | high_level


def _older(since_ms: int | None, now_ms: int, limit_ms: int) -> bool:
    return since_ms is not None and now_ms - since_ms >= limit_ms
