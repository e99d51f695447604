# SPDX-License-Identifier: GPL-3.0-or-later
"""Data between the plant (world, body, sensors) and the firmware side of the simulator.

Setpoint and Readings have the fields of sim_port_setpoint_t and sim_port_sensors_t in
firmware_app/host/sim_port.h, in the firmware's units. Truth is what only a simulator knows.
"""

from dataclasses import dataclass
from enum import IntEnum

RANGE_NONE_MM = 32767
"""What the Multi-ranger driver publishes if a sensor has no valid measurement."""


Ranges = tuple[int, int, int, int, int]
"""Front, back, left, right, up in millimetres."""


class Mode(IntEnum):
    """How an axis of a setpoint is to be read; stab_mode_t of stabilizer_types.h."""

    OFF = 0
    ABSOLUTE = 1
    VELOCITY = 2


@dataclass(slots=True)
class Setpoint:
    """A setpoint for the stabilizer; the default means motors off.

    Pitch is positive nose up; yaw and yaw rate are positive counter-clockwise.
    """

    mode_x: int = Mode.OFF
    mode_y: int = Mode.OFF
    mode_z: int = Mode.OFF
    mode_roll: int = Mode.OFF
    mode_pitch: int = Mode.OFF
    mode_yaw: int = Mode.OFF
    velocity_body: bool = False
    x_m: float = 0.0
    y_m: float = 0.0
    z_m: float = 0.0
    vx_mps: float = 0.0
    vy_mps: float = 0.0
    vz_mps: float = 0.0
    roll_deg: float = 0.0
    pitch_deg: float = 0.0
    yaw_deg: float = 0.0
    yaw_rate_dps: float = 0.0
    thrust: float = 0.0
    age_ms: int = 0
    priority: int = 0

    @classmethod
    def at(cls, x_m: float, y_m: float, z_m: float, yaw_deg: float) -> "Setpoint":
        """A setpoint to be at a position with a heading."""
        return cls(
            mode_x=Mode.ABSOLUTE,
            mode_y=Mode.ABSOLUTE,
            mode_z=Mode.ABSOLUTE,
            mode_yaw=Mode.ABSOLUTE,
            x_m=x_m,
            y_m=y_m,
            z_m=z_m,
            yaw_deg=yaw_deg,
        )


@dataclass(slots=True)
class Readings:
    """What the firmware's sensors and estimator report, in the estimator's frame.

    supervisor_info is not measured; the simulated supervisor writes it.
    """

    x_m: float = 0.0
    y_m: float = 0.0
    z_m: float = 0.0
    vx_mps: float = 0.0
    vy_mps: float = 0.0
    vz_mps: float = 0.0
    ax_g: float = 0.0
    ay_g: float = 0.0
    az_g: float = 0.0
    roll_deg: float = 0.0
    pitch_deg: float = 0.0
    yaw_deg: float = 0.0
    gyro_dps: tuple[float, float, float] = (0.0, 0.0, 0.0)
    var_velocity_m2ps2: tuple[float, float, float] = (0.0, 0.0, 0.0)
    range_mm: Ranges = (0, 0, 0, 0, 0)
    zrange_mm: int = 0
    battery_v: float = 4.2
    battery_percent: int = 90
    battery_state: int = 0
    supervisor_info: int = 0
    motion_quality: int = 0
    motion_dx: int = 0
    motion_dy: int = 0
    motor_thrust: float = 0.0
    motor_pwm: tuple[int, int, int, int] = (0, 0, 0, 0)
    var_position_m2: tuple[float, float, float] = (100.0, 100.0, 1.0)
    var_attitude_rad2: tuple[float, float, float] = (1e-4, 1e-4, 1e-4)
    lighthouse_status: int = 0
    lighthouse_active: int = 0
    loco_mode: int = 0
    ranging_state: int = 0
    external_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    external_q: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    external_tick: int = 0


@dataclass(frozen=True, slots=True)
class PositionMeasured:
    """A measured position for the estimator, in its frame; sd_m holds for each axis."""

    x_m: float
    y_m: float
    z_m: float
    sd_m: float


@dataclass(frozen=True, slots=True)
class YawMeasured:
    """A measured heading for the estimator, as the estimate's error."""

    error_rad: float
    sd_rad: float


Measured = PositionMeasured | YawMeasured


@dataclass(slots=True)
class Truth:
    """True pose and velocity of the body in the world frame; pitch is positive nose up."""

    time_s: float = 0.0
    position_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    velocity_mps: tuple[float, float, float] = (0.0, 0.0, 0.0)
    roll_rad: float = 0.0
    pitch_rad: float = 0.0
    yaw_rad: float = 0.0
