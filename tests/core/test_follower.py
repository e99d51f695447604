# SPDX-License-Identifier: GPL-3.0-or-later
"""The follower, flying a body that responds with a delay along routes of all shapes."""

import itertools
import math
from dataclasses import dataclass, field

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ground.core import CData, ffi, lib
from tests.core.maps import xy

TICK_S = 0.02
ANSWER_S = 0.15  # time constant of the body's velocity
Path = list[tuple[float, float]]
LINE: Path = [(0.0, 0.0), (2.0, 0.0)]
CORNER: Path = [(0.0, 0.0), (1.5, 0.0), (1.5, 1.5)]
BACK: Path = [(0.0, 0.0), (1.5, 0.0), (0.2, 0.3)]
SLALOM: Path = [(0.4 * i, 0.4 * (i % 2)) for i in range(7)]
NO_LIMIT_M = 100.0
yaws = st.floats(-3.125, 3.125, width=32)
# Legs long enough to be legs, turning by at most a right angle and a half.
legs = st.lists(st.tuples(st.floats(0.3, 1.5), st.floats(-2.3, 2.3)), min_size=1, max_size=8)


def route_of(path_m: Path) -> CData:
    points = [{"x": x, "y": y} for x, y in path_m]
    return ffi.new("route_t *", {"points_m": points, "count": len(path_m)})


def path_from(steps: list[tuple[float, float]]) -> Path:
    path, heading = [(0.0, 0.0)], 0.0
    for leg_m, turn_rad in steps:
        heading += turn_rad
        x, y = path[-1]
        path.append((x + leg_m * math.cos(heading), y + leg_m * math.sin(heading)))
    return path


def distance_to(path: Path, x: float, y: float) -> float:
    best = math.inf
    for (ax, ay), (bx, by) in itertools.pairwise(path):
        dx, dy = bx - ax, by - ay
        along = max(0.0, min(1.0, ((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy)))
        best = min(best, math.dist((x, y), (ax + along * dx, ay + along * dy)))
    return best


@dataclass
class Flight:
    """One flight along a route, recorded."""

    path: Path
    yaw_mode: int = lib.FOLLOWER_YAW_KEEP
    limit_m: float = NO_LIMIT_M
    room_m: float = 1.0
    yaw_rad: float = 0.0
    x_m: float = 0.0
    y_m: float = 0.0
    vx_mps: float = 0.0
    vy_mps: float = 0.0
    status: int = lib.FOLLOWER_MOVING
    time_s: float = 0.0
    farthest_m: float = 0.0
    speeds_mps: list[float] = field(default_factory=list)
    yaws_rad: list[float] = field(default_factory=list)
    headings: list[tuple[float, float]] = field(default_factory=list)

    def fly(self, most_s: float = 120.0) -> "Flight":
        route = route_of(self.path)
        cfg = ffi.new("follower_config_t *", lib.follower_config_default())
        cfg.yaw_mode = self.yaw_mode
        follower = ffi.new("follower_t *")
        command = ffi.new("follower_command_t *")
        pose, velocity = ffi.new("pose2_t *"), ffi.new("vec2_t *")
        lib.follower_start(follower, self.yaw_rad)
        while self.time_s < most_s and self.status == lib.FOLLOWER_MOVING:
            pose.x_m, pose.y_m, pose.yaw_rad = self.x_m, self.y_m, self.yaw_rad
            velocity.x, velocity.y = self.vx_mps, self.vy_mps
            self.status = lib.follower_step(
                follower, cfg, route, pose[0], velocity[0], (self.limit_m, self.room_m), command
            )
            self.obey(command)
        return self

    def obey(self, command: CData) -> None:
        vx, vy = xy(command.velocity_mps)
        self.speeds_mps.append(math.hypot(vx, vy))
        self.vx_mps += (vx - self.vx_mps) * TICK_S / ANSWER_S
        self.vy_mps += (vy - self.vy_mps) * TICK_S / ANSWER_S
        self.x_m += self.vx_mps * TICK_S
        self.y_m += self.vy_mps * TICK_S
        self.yaw_rad = math.remainder(self.yaw_rad + command.yaw_rate_rps * TICK_S, math.tau)
        self.yaws_rad.append(self.yaw_rad)
        self.headings.append((vx, vy))
        self.farthest_m = max(self.farthest_m, distance_to(self.path, self.x_m, self.y_m))
        self.time_s += TICK_S

    @property
    def place(self) -> tuple[float, float]:
        return self.x_m, self.y_m


MODES = [lib.FOLLOWER_YAW_FORWARD, lib.FOLLOWER_YAW_KEEP, lib.FOLLOWER_YAW_TURN]
CONFIG = lib.follower_config_default()


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("path", [LINE, CORNER, BACK, SLALOM])
def test_it_arrives_and_stays_near_the_route(path: Path, mode: int) -> None:
    flight = Flight(path, mode).fly()
    assert flight.status == lib.FOLLOWER_ARRIVED
    assert math.dist(flight.place, path[-1]) <= CONFIG.arrive_m
    assert flight.farthest_m < 0.15
    assert max(flight.speeds_mps) <= CONFIG.speed_mps * (1 + 1e-5)


@given(legs, st.sampled_from(MODES), yaws)
def test_it_arrives_on_any_route(
    steps: list[tuple[float, float]], mode: int, yaw_rad: float
) -> None:
    path = path_from(steps)
    flight = Flight(path, mode, yaw_rad=yaw_rad).fly()
    assert flight.status == lib.FOLLOWER_ARRIVED
    assert math.dist(flight.place, path[-1]) <= CONFIG.arrive_m
    assert flight.farthest_m < 0.25
    assert max(flight.speeds_mps) <= CONFIG.speed_mps * (1 + 1e-5)


@given(st.floats(0.0, 2.8))
def test_it_stops_where_the_allowed_part_ends(limit_m: float) -> None:
    flight = Flight(CORNER, limit_m=limit_m).fly()
    assert flight.status == lib.FOLLOWER_AT_LIMIT
    stop = (min(limit_m, 1.5), max(0.0, limit_m - 1.5))
    assert math.dist(flight.place, stop) <= CONFIG.arrive_m + 0.01
    flight.status = lib.FOLLOWER_MOVING
    beyond = [flight.x_m - stop[0], flight.y_m - stop[1]]
    assert max(beyond) <= 0.02


def test_nothing_allowed_means_standing_still() -> None:
    flight = Flight(LINE, limit_m=0.0).fly(most_s=1.0)
    assert flight.status == lib.FOLLOWER_AT_LIMIT
    assert math.dist(flight.place, (0.0, 0.0)) < 0.02


def test_keeping_the_heading_keeps_it() -> None:
    flight = Flight(SLALOM, lib.FOLLOWER_YAW_KEEP, yaw_rad=0.7).fly()
    assert flight.yaws_rad == pytest.approx([0.7] * len(flight.yaws_rad), abs=1e-4)


def test_facing_forward_looks_where_it_flies() -> None:
    flight = Flight(CORNER, lib.FOLLOWER_YAW_FORWARD, yaw_rad=2.5).fly()
    fast = [
        abs(math.remainder(yaw - math.atan2(vy, vx), math.tau))
        for yaw, (vx, vy) in zip(flight.yaws_rad, flight.headings, strict=True)
        if math.hypot(vx, vy) > 0.9 * CONFIG.speed_mps
    ]
    assert fast
    assert max(fast) < 0.6


def test_turning_steadily_turns_steadily() -> None:
    flight = Flight(LINE, lib.FOLLOWER_YAW_TURN).fly()
    turned = math.remainder(flight.time_s * CONFIG.turn_rate_rps, math.tau)
    assert math.remainder(flight.yaw_rad - turned, math.tau) == pytest.approx(0.0, abs=0.02)


def test_it_brakes_before_the_end() -> None:
    flight = Flight(LINE).fly()
    assert max(flight.speeds_mps) == pytest.approx(CONFIG.speed_mps, rel=1e-3)
    assert math.hypot(flight.vx_mps, flight.vy_mps) < 0.5 * CONFIG.speed_mps


@given(legs)
def test_the_less_room_the_slower(steps: list[tuple[float, float]]) -> None:
    flight = Flight(path_from(steps), room_m=0.05).fly()
    assert flight.status == lib.FOLLOWER_ARRIVED
    assert max(flight.speeds_mps) <= 0.05 / CONFIG.stray_s * 1.02


def test_a_bend_is_flown_slower_than_a_line_and_a_sharp_one_slowest() -> None:
    def slowest(turn_rad: float) -> float:
        flight = Flight(path_from([(2.0, 0.0), (2.0, turn_rad)])).fly()
        third = len(flight.speeds_mps) // 3
        return min(flight.speeds_mps[third:-third])

    speeds = [slowest(turn_rad) for turn_rad in (0.0, 1.0, 2.0)]
    assert speeds[0] == pytest.approx(CONFIG.speed_mps, rel=1e-3)
    assert speeds[2] < 0.8 * speeds[1] < 0.8 * speeds[0]


@given(yaws)
def test_where_the_known_part_ends_it_looks_along_the_route(yaw_rad: float) -> None:
    flight = Flight(LINE, lib.FOLLOWER_YAW_FORWARD, limit_m=0.0, yaw_rad=yaw_rad).fly()
    assert flight.status == lib.FOLLOWER_AT_LIMIT
    assert abs(flight.yaw_rad) < 0.25
    assert flight.farthest_m < 0.02


def test_a_push_off_the_route_is_flown_back() -> None:
    flight = Flight(LINE, x_m=0.5, y_m=0.4).fly()
    assert flight.status == lib.FOLLOWER_ARRIVED
    assert math.dist(flight.place, LINE[-1]) <= CONFIG.arrive_m


def test_where_a_route_passes_near_itself_no_part_is_left_out() -> None:
    hairpin: Path = [(0.0, 0.0), (2.0, 0.0), (2.0, 0.25), (0.0, 0.25)]
    flight = Flight(hairpin).fly()
    assert flight.status == lib.FOLLOWER_ARRIVED
    assert flight.time_s > 3.8 / CONFIG.speed_mps


@given(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0), yaws, yaws)
def test_holding_a_post_leads_back_to_it_slowly(
    x_m: float, y_m: float, yaw_rad: float, wanted_rad: float
) -> None:
    cfg = ffi.new("follower_config_t *", CONFIG)
    pose = ffi.new("pose2_t *", (x_m, y_m, yaw_rad))[0]
    post = ffi.new("pose2_t *", (0.0, 0.0, wanted_rad))[0]
    command = lib.follower_hold(cfg, pose, post)
    vx, vy = xy(command.velocity_mps)
    assert vx * x_m + vy * y_m <= 0.0
    assert math.hypot(vx, vy) <= CONFIG.speed_mps
    assert abs(command.yaw_rate_rps) <= CONFIG.yaw_rate_max_rps * (1 + 1e-6)
    error = math.remainder(wanted_rad - yaw_rad, math.tau)
    if abs(error) < 3.1:
        assert command.yaw_rate_rps * error >= 0.0
