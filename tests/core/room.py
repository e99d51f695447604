# SPDX-License-Identifier: GPL-3.0-or-later
"""A room of walls and a body that follows nav: enough to fly whole missions without MuJoCo.

Odometry is exact here but for being carried, ranges nearly so: what is tested is the pipeline,
not its robustness.
"""

import cmath
import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ground.core import CData, ffi, lib

TICK_MS = 20
PUBLISH_MS = 100
LATENCY_MS = 80
NOISE_M = 0.003
ANSWER_S = 0.15
RANGE_MAX_M = 4.0
CONE_RAD = np.linspace(-0.15, 0.15, 7)
SENSITIVITY = np.exp(-0.5 * (CONE_RAD / 0.157) ** 2)
CLUSTER_M = 0.4  # returns this little apart merge into one
READY: int = (
    lib.NAV_HAS_FLOW
    | lib.NAV_HAS_RANGER
    | lib.NAV_ESTIMATOR_SETTLED
    | lib.NAV_CAN_FLY
    | lib.NAV_LINK_ALIVE
)
Segment = tuple[float, float, float, float]
Box = tuple[float, float, float, float]


def box_walls(x0: float, y0: float, x1: float, y1: float) -> list[Segment]:
    return [(x0, y0, x1, y0), (x1, y0, x1, y1), (x1, y1, x0, y1), (x0, y1, x0, y0)]


ROOM = box_walls(-2.0, -2.0, 2.9, 2.0)
# A wall across the room with a door of 0.9 m at its upper end.
TWO_ROOMS = [*ROOM, (0.8, -2.0, 0.8, 1.1)]


def cast(walls: list[Segment], x: float, y: float, bearing_rad: float) -> float:
    """The nearest return in the cone of a beam; negative if there is none."""
    angle = bearing_rad + CONE_RAD[:, None]
    dx, dy = np.cos(angle), np.sin(angle)
    w: NDArray[np.float64] = np.array(walls)
    ax, ay, ex, ey = w[:, 0] - x, w[:, 1] - y, w[:, 2] - w[:, 0], w[:, 3] - w[:, 1]
    cross = dx * ey - dy * ex
    cross[np.abs(cross) < 1e-9] = 1e-9
    along, on_wall = (ax * ey - ay * ex) / cross, (ax * dy - ay * dx) / cross
    echoes = np.where((along > 0) & (on_wall >= 0) & (on_wall <= 1), along, np.inf).min(axis=1)
    near = echoes <= echoes.min() + CLUSTER_M
    if echoes.min() > RANGE_MAX_M:
        return -1.0
    return float(np.average(echoes[near], weights=SENSITIVITY[near]))


def gap_m(walls: list[Segment], x: float, y: float) -> float:
    """Distance from a place to the nearest wall."""
    w: NDArray[np.float64] = np.array(walls)
    start, along = w[:, :2], w[:, 2:] - w[:, :2]
    share = ((np.array([x, y]) - start) * along).sum(axis=1) / (along**2).sum(axis=1)
    nearest = start + np.clip(share, 0.0, 1.0)[:, None] * along
    return float(np.hypot(*(nearest - (x, y)).T).min())


# Made once, so that two configurations do not even differ in what lies between their fields.
DEFAULTS = ffi.new("nav_config_t *")
lib.nav_config_default(DEFAULTS)


def new_config(**changes: float) -> CData:
    cfg = ffi.new("nav_config_t *", DEFAULTS[0])
    for name, value in changes.items():
        setattr(cfg, name, value)
    return cfg


@dataclass
class Flight:
    """One nav_t in one room."""

    walls: list[Segment] = field(default_factory=lambda: list(ROOM))
    cfg: CData = field(default_factory=new_config)
    x_m: float = 0.0
    y_m: float = 0.0
    yaw_rad: float = 0.0
    flags: int = READY
    battery_v: float = 4.0

    def __post_init__(self) -> None:
        self.nav = ffi.new("nav_t *")
        lib.nav_init(self.nav, self.cfg)
        self.input = ffi.new("nav_input_t *")
        self.shift, self.turned_rad = 0j, 0.0
        self.time_ms = 0
        self.z_m = 0.0
        self.velocity = (0.0, 0.0)
        self.ranges_m = [-1.0] * lib.SCAN_RANGES
        self.measured_m = self.ranges_m
        self.noise = np.random.default_rng(7)
        self.states: list[int] = []
        self.events: list[tuple[int, int]] = []
        self.nearest_m = math.inf
        self.setpoint: CData = None
        self.step()

    def sense(self) -> None:
        if self.time_ms % PUBLISH_MS == 0:
            self.ranges_m = self.measured_m
        if (self.time_ms + LATENCY_MS) % PUBLISH_MS == 0:
            beams = (lib.scan_bearing_rad(beam) for beam in range(lib.SCAN_BEAMS))
            level = [cast(self.walls, self.x_m, self.y_m, self.yaw_rad + b) for b in beams]
            noise = self.noise.normal(0.0, NOISE_M, len(level))
            self.measured_m = [r + n if r > 0 else r for r, n in zip(level, noise, strict=True)]
            self.measured_m.append(-1.0)
            self.nearest_m = min(self.nearest_m, gap_m(self.walls, self.x_m, self.y_m))
        odometry = self.input.odometry
        odometry.time_ms, odometry.height_m = self.time_ms, self.z_m
        odometry.pose.x_m, odometry.pose.y_m, odometry.pose.yaw_rad = self.odometry()
        velocity = cmath.rect(1.0, self.turned_rad) * complex(*self.velocity)
        self.input.velocity_mps.x, self.input.velocity_mps.y = velocity.real, velocity.imag
        self.input.yaw_rate_rps = self.setpoint.yaw_rate_rps if self.setpoint else 0.0
        self.input.range_m = self.ranges_m
        self.input.battery_v, self.input.flags = self.battery_v, self.flags

    def odometry(self) -> tuple[float, float, float]:
        """The odometry's pose: exact, except that it does not notice being carried."""
        place = self.shift + cmath.rect(1.0, self.turned_rad) * complex(self.x_m, self.y_m)
        return place.real, place.imag, math.remainder(self.yaw_rad + self.turned_rad, math.tau)

    def carry(self, x_m: float, y_m: float, yaw_rad: float) -> None:
        """Move the drone by hand; the odometry does not notice."""
        x, y, yaw = self.odometry()
        self.turned_rad = yaw - yaw_rad
        self.shift = complex(x, y) - cmath.rect(1.0, self.turned_rad) * complex(x_m, y_m)
        self.x_m, self.y_m, self.yaw_rad = x_m, y_m, yaw_rad

    def step(self) -> CData:
        """One tick of 20 ms."""
        self.sense()
        self.setpoint = lib.nav_step(self.nav, self.input)
        self.move()
        self.listen()
        self.time_ms += TICK_MS
        return self.setpoint

    def move(self) -> None:
        dt, wanted = TICK_MS / 1000, self.setpoint
        if not wanted.motors:
            self.z_m, self.velocity = 0.0, (0.0, 0.0)
            return
        c, s = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        forward, left = wanted.velocity_body_mps.x, wanted.velocity_body_mps.y
        vx, vy = self.velocity
        vx += (c * forward - s * left - vx) * dt / ANSWER_S
        vy += (s * forward + c * left - vy) * dt / ANSWER_S
        self.velocity = vx, vy
        self.x_m += vx * dt
        self.y_m += vy * dt
        self.z_m = max(0.0, self.z_m + (wanted.height_m - self.z_m) * dt / ANSWER_S)
        self.yaw_rad = math.remainder(self.yaw_rad + wanted.yaw_rate_rps * dt, math.tau)

    def listen(self) -> None:
        if not self.states or self.states[-1] != self.state:
            self.states.append(self.state)
        event = ffi.new("wire_event_t *")
        while lib.nav_take_event(self.nav, event):
            self.events.append((event.code, event.argument))

    def command(self, cmd: int, x_m: float = 0.0, y_m: float = 0.0) -> int:
        return int(lib.nav_command(self.nav, ffi.new("nav_command_t *", (cmd, (x_m, y_m)))))

    def run_until(self, *states: int, most_s: float = 120.0) -> int:
        """Fly until one of these states is reached, and return it."""
        end_ms = self.time_ms + most_s * 1000
        while self.time_ms < end_ms:
            self.step()
            if self.state in states:
                break
        return self.state

    def run_for(self, time_s: float) -> None:
        for _ in range(round(time_s * 1000 / TICK_MS)):
            self.step()

    @property
    def state(self) -> int:
        return int(self.nav.status.state)

    @property
    def fault(self) -> int:
        return int(self.nav.status.fault)

    def distance_m(self, x_m: float, y_m: float) -> float:
        return math.hypot(self.x_m - x_m, self.y_m - y_m)


def hovering(walls: list[Segment] = ROOM) -> Flight:
    """A flight that has taken off and looked around."""
    flight = Flight(list(walls))
    assert flight.command(lib.MISSION_CMD_TAKE_OFF) == lib.MISSION_OK
    assert flight.run_until(lib.MISSION_HOVER, lib.MISSION_FAULT) == lib.MISSION_HOVER
    return flight
