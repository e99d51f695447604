# SPDX-License-Identifier: GPL-3.0-or-later
"""What a page is sent: the state, changes of the trail, the map."""

import json
import struct
from dataclasses import replace

from ground.core import GRID_SIDE_CELLS, CellState, MissionReason, MissionState
from ground.model import LinkChange, LinkState, MapPiece, Point, Pose, RoutePiece, Telemetry
from ground.station.station import Station
from ground.web.cockpit import Cockpit
from ground.web.frames import MAP_HEADER, NOTHING, map_frame, state_frame
from tests.ground.fakelink import FakeLink
from tests.ground.stations import packet_of

FREE_TILE = packet_of(MapPiece(0, 0, bytes([CellState.FREE] * 64), ()))


def flying(drone_ms: int = 1000) -> Telemetry:
    pose = Pose(1.0, 2.0, 0.4, 0.5)
    return Telemetry(drone_ms, pose, Point(3.0, 1.0), MissionState.FOLLOW, MissionReason.OK, 100)


def test_state_frame_is_plain_json_with_and_without_a_drone() -> None:
    cockpit = Cockpit()
    text, _ = state_frame(cockpit, NOTHING)
    assert json.loads(text)["link"]["state"] == "closed"
    cockpit.station = Station(FakeLink())
    cockpit.station.picture.take(flying(), 0.0)
    frame = json.loads(state_frame(cockpit, NOTHING)[0])
    assert frame["drone"]["pose"] == [1.0, 2.0, 0.4, 0.5]
    assert frame["mission"]["words"] == "flying"


def test_to_find_itself_it_needs_a_map() -> None:
    station = Station(FakeLink())
    seen = [LinkChange(LinkState.CONNECTED, ""), flying()]
    for message, permitted in [*((m, False) for m in seen), (FREE_TILE, True)]:
        station.picture.take(message, 0.0)
        frame = json.loads(state_frame(Cockpit(station), NOTHING)[0])
        assert frame["can"]["relocalise"] is permitted


def test_where_it_holds_its_place_no_old_goal_or_route_is_told() -> None:
    cockpit = Cockpit(Station(FakeLink()))
    assert cockpit.station is not None
    route = RoutePiece(1, 0, 2, (Point(1.0, 2.0), Point(3.0, 1.0)))
    holding = replace(flying(), state=MissionState.HOVER)
    for telemetry, goal in ((flying(), [3.0, 1.0]), (holding, None)):
        for message in (route, telemetry):
            cockpit.station.picture.take(message, 0.0)
        frame = json.loads(state_frame(cockpit, NOTHING)[0])
        assert frame["drone"]["goal"] == goal
        assert bool(frame["route"]) == bool(goal)


def test_trail_is_sent_once() -> None:
    cockpit = Cockpit(Station(FakeLink()))
    assert cockpit.station is not None
    picture = cockpit.station.picture
    for i in range(5):
        moved = flying(i)
        pose = Pose(float(i), 0.0, 0.4, 0.0)
        telemetry = Telemetry(i, pose, moved.goal, moved.state, moved.fault, 100)
        picture.take(telemetry, 0.0)
    text, sent = state_frame(cockpit, NOTHING)
    assert json.loads(text)["trail"]["points"] == [[float(i), 0.0] for i in range(5)]
    text, again = state_frame(cockpit, sent)
    assert json.loads(text)["trail"] == {"from": 5, "points": []}
    assert again == sent


def test_map_frame_carries_cells_and_points() -> None:
    station = Station(FakeLink())
    states = bytearray([CellState.FREE] * 64)
    states[1] = CellState.OCCUPIED
    station.picture.take(packet_of(MapPiece(0, 0, bytes(states), ((1, 0o52),))), 0.0)
    frame = map_frame(station.picture)
    revision, side, _, cell_m, _, _ = MAP_HEADER.unpack_from(frame)
    assert (revision, side) == (1, GRID_SIDE_CELLS)
    assert struct.pack("<f", cell_m) == struct.pack("<f", 0.05)
    assert len(frame) == MAP_HEADER.size + side * side
    assert list(frame[MAP_HEADER.size :][:3]) == [CellState.FREE, 3 + 4 * 0o52, CellState.FREE]
