# SPDX-License-Identifier: GPL-3.0-or-later
"""The compiled C core: its enums and sizes, and the handles `ffi` and `lib`.

Numbers are read from C, never retyped; a test proves that no enumerator is missing here.
"""

from __future__ import annotations

from enum import IntEnum, IntFlag
from typing import Any, TypeAlias

from ground.errors import CoreMissing

try:
    from ground import _core
except ImportError as error:
    raise CoreMissing(f"the C core is not compiled ({error})", "`make setup`") from error

CData: TypeAlias = Any  # a C object; cffi has no types for it

ffi: Any = _core.ffi
lib: Any = _core.lib

GRID_SIDE_CELLS: int = lib.GRID_SIDE_CELLS
TILE_SIDE_CELLS: int = lib.GRID_TILE_SIDE_CELLS
TILES_PER_ROW: int = lib.GRID_TILES_PER_ROW
TILES: int = lib.GRID_TILES
MAP_EPOCHS: int = lib.WIRE_MAP_EPOCHS
MAP_BYTES: int = lib.WIRE_MAP_BYTES
NO_POINT: int = lib.WIRE_NO_POINT
PATH_POINTS: int = lib.WIRE_PATH_POINTS
WAYPOINTS_MAX: int = lib.NAV_WAYPOINTS
WAYPOINTS_A_PACKET: int = lib.WIRE_WAYPOINTS_A_PACKET
PACKET_BYTES: int = lib.WIRE_PACKET_BYTES
WIRE_VERSION: int = lib.WIRE_VERSION
TILES_A_PACKET: int = lib.WIRE_TILES_A_PACKET
EVENTS_KEPT: int = lib.NAV_EVENTS
RECORDS_KEPT: int = lib.HISTORY_RECORDS


class MissionCmd(IntEnum):
    """Commands to the drone."""

    NONE = lib.MISSION_CMD_NONE
    TAKE_OFF = lib.MISSION_CMD_TAKE_OFF
    GOTO = lib.MISSION_CMD_GOTO
    EXPLORE = lib.MISSION_CMD_EXPLORE
    HOME = lib.MISSION_CMD_HOME
    LAND = lib.MISSION_CMD_LAND
    HOLD = lib.MISSION_CMD_HOLD
    SCAN = lib.MISSION_CMD_SCAN
    FORGET = lib.MISSION_CMD_FORGET
    RELOCALISE = lib.MISSION_CMD_RELOCALISE
    SPIN = lib.MISSION_CMD_SPIN
    FLY = lib.MISSION_CMD_FLY
    PATROL = lib.MISSION_CMD_PATROL


class MissionState(IntEnum):
    """What the drone is doing."""

    IDLE = lib.MISSION_IDLE
    TAKEOFF = lib.MISSION_TAKEOFF
    SCAN = lib.MISSION_SCAN
    PLAN = lib.MISSION_PLAN
    FOLLOW = lib.MISSION_FOLLOW
    AVOID = lib.MISSION_AVOID
    HOVER = lib.MISSION_HOVER
    RETURN = lib.MISSION_RETURN
    LAND = lib.MISSION_LAND
    FAULT = lib.MISSION_FAULT
    RELOCALISE = lib.MISSION_RELOCALISE
    SPIN = lib.MISSION_SPIN

    @property
    def airborne(self) -> bool:
        """Whether motors may run in this state."""
        return bool(lib.mission_airborne(int(self)))


class MissionReason(IntEnum):
    """Why the drone refused a command or ended a flight."""

    OK = lib.MISSION_OK
    NO_FLOW_DECK = lib.MISSION_NO_FLOW_DECK
    NO_RANGER_DECK = lib.MISSION_NO_RANGER_DECK
    BATTERY_LOW = lib.MISSION_BATTERY_LOW
    BATTERY_EMPTY = lib.MISSION_BATTERY_EMPTY
    ESTIMATOR = lib.MISSION_ESTIMATOR
    CANNOT_FLY = lib.MISSION_CANNOT_FLY
    BAD_VALUE = lib.MISSION_BAD_VALUE
    OUTSIDE_GRID = lib.MISSION_OUTSIDE_GRID
    OUTSIDE_AREA = lib.MISSION_OUTSIDE_AREA
    GOAL_OCCUPIED = lib.MISSION_GOAL_OCCUPIED
    GOAL_UNREACHABLE = lib.MISSION_GOAL_UNREACHABLE
    NOT_FLYING = lib.MISSION_NOT_FLYING
    UNKNOWN_COMMAND = lib.MISSION_UNKNOWN_COMMAND
    BAD_AREA = lib.MISSION_BAD_AREA
    FLYING = lib.MISSION_FLYING
    LINK_LOST = lib.MISSION_LINK_LOST
    STUCK = lib.MISSION_STUCK
    RANGES_FROZEN = lib.MISSION_RANGES_FROZEN
    TUMBLED = lib.MISSION_TUMBLED
    SELF_TEST = lib.MISSION_SELF_TEST
    LOST = lib.MISSION_LOST
    NO_MAP = lib.MISSION_NO_MAP
    NO_WAYPOINTS = lib.MISSION_NO_WAYPOINTS
    FLOW_LOST = lib.MISSION_FLOW_LOST
    BLIND = lib.MISSION_BLIND
    BUSY = lib.MISSION_BUSY


class WireType(IntEnum):
    """Kinds of app channel packets."""

    HELLO = lib.WIRE_HELLO
    COMMAND = lib.WIRE_COMMAND
    ACK = lib.WIRE_ACK
    PATH = lib.WIRE_PATH
    EVENT = lib.WIRE_EVENT
    HEARTBEAT = lib.WIRE_HEARTBEAT
    SNAPSHOT = lib.WIRE_SNAPSHOT
    MAP = lib.WIRE_MAP
    WAYPOINTS = lib.WIRE_WAYPOINTS
    HISTORY = lib.WIRE_HISTORY
    ASK = lib.WIRE_ASK
    TILES = lib.WIRE_TILES
    STEER = lib.WIRE_STEER


class RecordKind(IntEnum):
    """What a record of the history describes."""

    POSE = lib.WIRE_RECORD_POSE
    MATCHED = lib.WIRE_RECORD_MATCHED
    LOST = lib.WIRE_RECORD_LOST
    FOUND = lib.WIRE_RECORD_FOUND


class WireStatus(IntEnum):
    """Whether a packet could be decoded, or why not."""

    OK = lib.WIRE_OK
    SHORT = lib.WIRE_SHORT
    LONG = lib.WIRE_LONG
    BAD_VERSION = lib.WIRE_BAD_VERSION
    BAD_TYPE = lib.WIRE_BAD_TYPE


class EventCode(IntEnum):
    """Kinds of events that the drone reports."""

    STATE = lib.WIRE_EVENT_STATE
    REFUSED = lib.WIRE_EVENT_REFUSED
    FAULT = lib.WIRE_EVENT_FAULT
    ARRIVED = lib.WIRE_EVENT_ARRIVED
    EXPLORED = lib.WIRE_EVENT_EXPLORED
    FOUND = lib.WIRE_EVENT_FOUND
    WAYPOINT = lib.WIRE_EVENT_WAYPOINT
    SKIPPED = lib.WIRE_EVENT_SKIPPED


class Capability(IntFlag):
    """What this build of the app can do."""

    RRTSTAR = lib.WIRE_CAP_RRTSTAR
    GRID_SEARCH = lib.WIRE_CAP_GRID_SEARCH
    SLAM = lib.WIRE_CAP_SLAM
    EXPLORE = lib.WIRE_CAP_EXPLORE


class SelfTest(IntEnum):
    """Result of the drone's self-test: whether it computes the same as a PC."""

    NOT_RUN = lib.SELFTEST_NOT_RUN
    RUNNING = lib.SELFTEST_RUNNING
    AGREES = lib.SELFTEST_AGREES
    DIFFERS = lib.SELFTEST_DIFFERS


class Source(IntEnum):
    """Where the pose in the map comes from."""

    ODOMETRY = lib.NAV_SOURCE_ODOMETRY
    SLAM = lib.NAV_SOURCE_SLAM
    SLAM_ESTIMATOR = lib.NAV_SOURCE_SLAM_ESTIMATOR
    LIGHTHOUSE = lib.NAV_SOURCE_LIGHTHOUSE
    LOCO = lib.NAV_SOURCE_LOCO
    EXTERNAL = lib.NAV_SOURCE_EXTERNAL


class CellState(IntEnum):
    """What the map says about a cell."""

    UNKNOWN = lib.GRID_CELL_UNKNOWN
    FREE = lib.GRID_CELL_FREE
    OCCUPIED = lib.GRID_CELL_OCCUPIED
