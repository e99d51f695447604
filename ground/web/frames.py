# SPDX-License-Identifier: GPL-3.0-or-later
"""What a page is sent: the state as JSON, over ten times a second; the map, when it changed."""

from __future__ import annotations

import json
import math
import struct
import time
from collections.abc import Sequence
from typing import Any

from ground.core import MissionState, SelfTest
from ground.model import LinkState, Point
from ground.nextsteps import after, next_step
from ground.station.picture import Picture
from ground.station.trail import Trail
from ground.web.cockpit import Cockpit
from ground.web.fleet import COLOURS, Fleet
from ground.web.parameters import alone, area_of
from ground.web.status import status
from ground.words import REASON_WORDS, SELF_TEST_WORDS, SOURCE_WORDS, STATE_WORDS

MAP_HEADER = struct.Struct("<IHHfff")  # revision, side, reserved, cell, origin x and y [m]


TrailMark = tuple[int, int]
Sent = tuple[TrailMark, TrailMark]
"""So much a page has of the drone's trail, and of its odometry's."""
NOTHING: Sent = ((0, 0), (0, 0))
BY_HAND = "flown by hand"
STILL = (MissionState.HOVER, MissionState.LAND)  # its last goal is no goal any more


def state_frame(
    cockpit: Cockpit, sent: Sent, fleet: Sequence[dict[str, Any]] = ()
) -> tuple[str, Sent]:
    """JSON of the whole state, with what of the trails is new or has moved. @return what is sent"""
    station = cockpit.station
    picture = station.picture if station else Picture()
    trail, mark = _news(picture.trail, sent[0])
    odometry_trail, odometry_mark = _news(picture.odometry_trail, sent[1])
    frame = {
        "kind": "state",
        "fleet": fleet,
        "stop": {"latched": cockpit.stop_latched, "confirmed": _locked(picture)},
        "link": _link(cockpit),
        "mission": _mission(cockpit, picture),
        "drone": _drone(picture),
        "route": [_xy(point) for point in picture.route] if _under_way(picture) else [],
        "trail": trail,
        "odometry_trail": odometry_trail,
        "map": {
            "complete": round(picture.map.completeness, 3),
            "rate_hz": round(picture.map.rate_hz, 1),
            "ages_s": _ages(picture),
        },
        "alone": alone(picture.parameters),
        "area": area_of(picture.parameters),
        "odometry": _odometry(picture),
        "status": status(cockpit, picture),
        "can": _permitted(cockpit, picture),
        "replay": _replay(cockpit),
    }
    return json.dumps(frame, allow_nan=False), (mark, odometry_mark)


def fleet_rows(fleet: Fleet, chosen: int) -> list[dict[str, Any]]:
    """All drones in short, as the page of one of them shows them."""
    return [_member(fleet, chosen, number) for number in range(len(fleet.members))]


def _member(fleet: Fleet, chosen: int, number: int) -> dict[str, Any]:
    member = fleet.members[number]
    cockpit, pose = member.cockpit, fleet.seen_from(chosen, number)
    station = cockpit.station
    return {
        "name": member.name,
        "colour": COLOURS[number % len(COLOURS)],
        "chosen": number == chosen,
        "link": _link(cockpit)["state"],
        "words": _mission(cockpit, station.picture)["words"] if station else str(cockpit.trouble),
        "pose": pose and [_round(v) for v in (pose.x_m, pose.y_m, pose.z_m, pose.yaw_rad)],
    }


def map_frame(picture: Picture) -> bytes:
    """The map: a header and one byte a cell (GroundMap.codes), row 0 in the south."""
    grid = picture.map
    header = MAP_HEADER.pack(
        grid.revision & 0xFFFFFFFF,
        grid.states.shape[0],
        0,
        grid.cell_m,
        grid.origin.x_m,
        grid.origin.y_m,
    )
    return header + grid.codes().tobytes()


def _ages(picture: Picture) -> list[int]:
    """Of each tile, in whole seconds; -1 where none came."""
    ages_s = picture.map.tile_ages_s(time.monotonic())
    return [int(age_s) if math.isfinite(age_s) else -1 for age_s in ages_s]


def _news(trail: Trail, mark: TrailMark) -> tuple[dict[str, Any], TrailMark]:
    """The points from that number on are these."""
    first, points, mark = trail.since(mark)
    return {"from": first, "points": [_xy(point) for point in points]}, mark


def _under_way(picture: Picture) -> bool:
    return picture.state.airborne and picture.state not in STILL


def _locked(picture: Picture) -> bool:
    return picture.health is not None and picture.health.locked


def _link(cockpit: Cockpit) -> dict[str, Any]:
    """How it is; what is wrong with it, and what comes next."""
    if cockpit.station is None:
        trouble = cockpit.trouble
        state, detail, step = LinkState.CLOSED, str(trouble), next_step(trouble)
    else:
        link = cockpit.station.picture.link
        state, detail, step = link.state, link.detail, ""
    return {"state": state.value, "detail": detail, "step": step}


def _mission(cockpit: Cockpit, picture: Picture) -> dict[str, Any]:
    telemetry, by_hand = picture.telemetry, cockpit.sticks.deflected
    if telemetry is None:
        return {"state": "", "words": "no data yet", "by_hand": False, "fault": "", "step": ""}
    hovers = telemetry.state is MissionState.HOVER
    return {
        "state": telemetry.state.name,
        "words": BY_HAND if by_hand and hovers else STATE_WORDS[telemetry.state],
        "by_hand": by_hand,
        "fault": REASON_WORDS[telemetry.fault] if telemetry.fault else "",
        "step": after(telemetry.fault),
    }


def _drone(picture: Picture) -> dict[str, Any]:
    drone: dict[str, Any] = {"time_s": picture.drone_ms / 1000}
    if (telemetry := picture.telemetry) is not None:
        pose = telemetry.pose
        drone["pose"] = [_round(v) for v in (pose.x_m, pose.y_m, pose.z_m, pose.yaw_rad)]
        drone["goal"] = _xy(telemetry.goal) if _under_way(picture) else None
    if (ranges := picture.ranges) is not None:
        drone["ranges"] = [ranges.front_m, ranges.left_m, ranges.back_m, ranges.right_m]
    if picture.source is not None:
        drone["source"] = SOURCE_WORDS[picture.source]
    if (health := picture.health) is not None:
        drone["battery_v"] = _round(health.battery_v)
        drone["path_m"] = _round(health.path_m) if _under_way(picture) else None
        drone["self_test"] = {
            "state": health.self_test.name,
            "words": SELF_TEST_WORDS[health.self_test],
        }
    return drone


def _odometry(picture: Picture) -> list[float] | None:
    """The firmware's own estimate, uncorrected: where it believes to be without SLAM."""
    if picture.odometry is None:
        return None
    pose = picture.odometry.pose
    return [_round(v) for v in (pose.x_m, pose.y_m, pose.yaw_rad)]


def _permitted(cockpit: Cockpit, picture: Picture) -> dict[str, bool]:
    """Which buttons make sense now; the drone has the last word."""
    alive = picture.link.state is LinkState.CONNECTED and picture.telemetry is not None
    ready = alive and not cockpit.stop_latched and cockpit.timeline is None
    flying = ready and picture.state.airborne
    return {
        "goto": ready,
        "explore": ready,
        "take_off": ready and not flying,
        "home": flying,
        "hold": flying,
        "scan": flying,
        "spin": ready,
        "fly": ready,
        "patrol": ready,
        "area": ready,
        "set": ready,
        "manual": flying,
        "relocalise": ready and picture.map.known_cells > 0,
        "land": flying,
        "self_test": ready and _testable(picture),
    }


def _replay(cockpit: Cockpit) -> dict[str, Any] | None:
    line = cockpit.timeline
    if line is None:
        return None
    times = {"at_s": _round(line.position_s), "of_s": _round(line.duration_s)}
    return times | {"playing": line.playing and line.position_s < line.duration_s}


def _testable(picture: Picture) -> bool:
    """The self-test borrows the memory of the map: only on the ground, and without one."""
    health = picture.health
    if health is None or picture.state is not MissionState.IDLE:
        return False
    return health.known_cells == 0 and health.self_test is not SelfTest.RUNNING


def _xy(point: Point) -> list[float]:
    return [_round(point.x_m), _round(point.y_m)]


def _round(value: float) -> float:
    return round(value, 3) if math.isfinite(value) else 0.0
