# SPDX-License-Identifier: GPL-3.0-or-later
"""One simulated drone: plant, firmware and radio, stepped together."""

from collections.abc import Iterable
from dataclasses import asdict, dataclass, field
from pathlib import Path

from ground.sim.battery import HOVER_ENDURANCE_S
from ground.sim.crazyflie import Crazyflie
from ground.sim.eeprom import Eeprom
from ground.sim.faults import Faults, FaultSpec
from ground.sim.faulttable import Bench
from ground.sim.firmware import Firmware
from ground.sim.flightstack import FlightStack
from ground.sim.localization import Localization
from ground.sim.model import Truth
from ground.sim.params import Params
from ground.sim.plant import PLANT_STEP_S, Plant
from ground.sim.positioning import SYSTEMS, Shadow
from ground.sim.radio import SILENCE_S, Address, Radio
from ground.sim.ranger import FALSE_SHORT
from ground.sim.report import Logbook, traffic
from ground.sim.trouble import TroubleSpec
from ground.sim.world import World

_STEP_MS = round(PLANT_STEP_S * 1000)
START_S = 1.0
_INITIAL_POSE = ("initialX", "initialY", "initialZ", "initialYaw")


@dataclass(frozen=True, slots=True)
class Options:
    """Settings of a simulation."""

    seed: int = 1
    profile: str = "real"
    endurance_s: float = HOVER_ENDURANCE_S
    false_short: float = FALSE_SHORT
    positioning: str = "flow"
    shadows: tuple[Shadow, ...] = ()
    speed: float = 1.0
    needs_arming: bool = False
    silence_s: float = SILENCE_S
    trouble: TroubleSpec = field(default_factory=TroubleSpec)
    eeprom_file: Path | None = None
    keep_trail: bool = False
    faults: tuple[FaultSpec, ...] = ()


class Simulator:
    """One Crazyflie in one world.

    Deterministic: the same packets at the same simulated times give the same flight and the same
    answers. Sockets and the wall clock belong to Swarm.
    """

    def __init__(self, world: World, options: Options, firmware: Firmware | None = None) -> None:
        self._options = options
        self._firmware = firmware or Firmware()
        self._plant = Plant(
            world,
            options.seed,
            options.profile,
            options.endurance_s,
            options.false_short,
            options.positioning,
            options.shadows,
        )
        self._params = Params(self._firmware, Eeprom(world.spec.eeprom, options.eeprom_file))
        auto_arm = not options.needs_arming
        self._stack = FlightStack(self._firmware, auto_arm)
        readings = self._plant.readings
        localization = Localization(
            self._params, readings, self._firmware.now_ms, self._plant.tell_estimator
        )
        self._crazyflie = Crazyflie(
            self._firmware, self._stack, self._params, localization, readings, auto_arm
        )
        self.radio = Radio(self._crazyflie, options.trouble, options.seed, options.silence_s)
        bench = Bench(world, self._plant, self._firmware, self._stack, self._params, self.radio)
        self.faults = Faults(bench, options.faults)
        self._logbook = Logbook(self._plant, options.keep_trail)
        self._stop_id = self._params.find("stabilizer.stop")
        self._reset_id = self._params.find("kalman.resetEstimation")
        self._firmware.set_sensors(self._plant.readings)
        self._attach_deck()
        self.unknown_eeprom_names = self._params.restore()
        self._firmware.boot()

    @property
    def time_s(self) -> float:
        """Simulated time since the start."""
        return self._plant.time_s

    def warm_up(self) -> None:
        """Run the first second, in which the firmware starts and refuses to fly."""
        while self.time_s < START_S:
            self.step()

    def deliver(self, address: Address, datagram: bytes) -> None:
        """Deliver a client's datagram at the present simulated time."""
        self.radio.receive(address, datagram, self.time_s)

    def outgoing(self) -> Iterable[tuple[Address, bytes]]:
        """Take what the drone has sent since the last call."""
        return self.radio.outgoing()

    def step(self) -> None:
        """Advance simulated time by PLANT_STEP_S."""
        self.faults.step()
        setpoint, may_run = self._stack.step(self._plant.readings, self._is_set(self._stop_id))
        self._plant.step(setpoint, may_run)
        self._plant.readings.supervisor_info = self._stack.info
        self._reset_estimator_if_asked()
        self._firmware.set_sensors(self._plant.readings)
        self._firmware.set_connected(self.radio.connected())
        self._firmware.run(_STEP_MS)
        for measured in self._firmware.take_measurements():
            self._plant.tell_estimator(measured)
        self.radio.tick(self._firmware.now_ms())
        self._logbook.note()

    @property
    def truth(self) -> Truth:
        """The true pose and motion; always the same object, updated in place."""
        return self._plant.truth

    def status(self) -> dict[str, object]:
        """Figures about the flight and the radio traffic, and the faults so far."""
        return {
            **self._logbook.summary(),
            **traffic(self.radio.counters, self._crazyflie.app_packets_lost),
            "app_alive": self._firmware.alive(),
            "supervisor_info": self._stack.info,
            "faults": [asdict(happened) for happened in self.faults.log],
        }

    def _attach_deck(self) -> None:
        system = SYSTEMS.get(self._options.positioning)
        identity = self._params.find(f"deck.{system.deck}") if system else None
        if identity is not None:
            self._firmware.param_force(identity, b"\1")

    def _is_set(self, identity: int | None) -> bool:
        return identity is not None and any(self._firmware.param_read(identity))

    def _reset_estimator_if_asked(self) -> None:
        if self._reset_id is None or not self._is_set(self._reset_id):
            return
        self._params.set_value(self._reset_id, 0)
        x_m, y_m, z_m, yaw_rad = (self._value(f"kalman.{name}") for name in _INITIAL_POSE)
        self._plant.reset_estimator(x_m, y_m, z_m, yaw_rad)

    def _value(self, name: str) -> float:
        identity = self._params.find(name)
        return 0.0 if identity is None else self._params.value(identity)
