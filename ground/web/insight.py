# SPDX-License-Identifier: GPL-3.0-or-later
"""What the drone would decide by the map that the ground has: its own C code, run here.

Everything here works on a Known, which is a copy: any thread may call it while the map grows.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ground.core import CData, MissionCmd, MissionReason, MissionState, ffi, lib
from ground.coregrid import lay_out
from ground.model import Health, Point, Pose
from ground.station.picture import Picture
from ground.words import REASON_WORDS

STEPS_MAX = 20_000  # of the planner; a search ends long before
OUT_CELLS = 10  # how far the way out of a blocked place may be
FULL_V = 4.2
UNSEEN_M = 0.1  # of a way, below which nothing is said of it

_PARAMETERS = {
    "way.clearance": lambda cfg, value: setattr(cfg, "clearance_m", value),
    "way.planner": lambda cfg, value: setattr(cfg, "planner", int(value)),
    "way.lowBat": lambda cfg, value: setattr(cfg, "low_battery_v", value),
    "way.areaX0": lambda cfg, value: setattr(cfg.area_min_m, "x", value),
    "way.areaY0": lambda cfg, value: setattr(cfg.area_min_m, "y", value),
    "way.areaX1": lambda cfg, value: setattr(cfg.area_max_m, "x", value),
    "way.areaY1": lambda cfg, value: setattr(cfg.area_max_m, "y", value),
}

Edge = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class Known:
    """What the ground knows of a drone and its surroundings at one moment."""

    states: NDArray[np.uint8]
    """(side, side) of CellState, row 0 in the south."""
    origin: Point
    cell_m: float
    pose: Pose
    state: MissionState = MissionState.IDLE
    health: Health | None = None
    parameters: tuple[tuple[str, float], ...] = ()

    @classmethod
    def of(cls, picture: Picture) -> Known | None:
        """A copy of what matters; None while it is not known where the drone is."""
        if picture.telemetry is None:
            return None
        return cls(
            picture.map.states.copy(),
            picture.map.origin,
            picture.map.cell_m,
            picture.telemetry.pose,
            picture.state,
            picture.health,
            tuple((n, v) for n, v in picture.parameters.items() if n in _PARAMETERS),
        )

    def seen_from(self, start: Point) -> Known:
        """The same, but for where the drone is."""
        pose = Pose(start.x_m, start.y_m, self.pose.z_m, self.pose.yaw_rad)
        return replace(self, pose=pose)


@dataclass(frozen=True, slots=True)
class Preview:
    """What would come of a goal: the way to it, or why it would be refused."""

    reason: MissionReason
    path: tuple[Point, ...] = ()
    length_m: float = 0.0
    seen_m: float = 0.0
    """So much of the way, from its start on, leads through what was observed."""
    tree: tuple[Edge, ...] = ()
    """The planner's tree of random places: x and y of both ends of each edge."""

    @property
    def words(self) -> str:
        """For the user."""
        if self.reason is not MissionReason.OK:
            return REASON_WORDS[self.reason]
        unseen_m = self.length_m - self.seen_m
        if unseen_m < UNSEEN_M:
            return f"{self.length_m:.1f} m to fly"
        return f"{self.length_m:.1f} m to fly, {unseen_m:.1f} m of it not seen yet"


@dataclass(frozen=True, slots=True)
class Frontier:
    """A place at the edge of what was observed, and the cells that would be seen from there."""

    place: Point
    gain_cells: int
    first: bool
    """The one that exploring would fly to."""


def preview(known: Known, goal: Point) -> Preview:
    """What the drone would do if it were told to go there now."""
    nav = _nav_of(known)
    if not known.state.airborne:
        reason = _command(nav, goal)  # as it checks on the ground, battery and all
        if reason is not MissionReason.OK:
            return Preview(reason)
    nav.mission.state = lib.MISSION_HOVER
    reason = _command(nav, goal)
    if reason is not MissionReason.OK:
        return Preview(reason)
    tree = _search(nav)
    if nav.mission.state != lib.MISSION_FOLLOW:
        return Preview(MissionReason(nav.mission.fault or lib.MISSION_STUCK), tree=tree)
    route = ffi.addressof(nav, "route")
    length_m = lib.route_length_m(route)
    grid, width_m = ffi.addressof(nav, "grid"), nav.cfg.look_half_width_m
    seen_m = lib.route_known_m(route, grid, width_m, 0.0, length_m)
    points = tuple(Point(p.x, p.y) for p in route.points_m[0 : route.count])
    return Preview(MissionReason.OK, points, length_m, min(seen_m, length_m), tree)


def frontiers(known: Known) -> tuple[Frontier, ...]:
    """Where exploring could go on: of each part of the map one place, where there is one."""
    nav = _nav_of(known)
    grid, clearance = ffi.addressof(nav, "grid"), ffi.addressof(nav, "clearance")
    start = _free_start(nav)
    if start is None:
        return ()
    planner = ffi.addressof(nav, "planner")
    lib.pathfinder_start_frontier(
        planner,
        ffi.addressof(nav.cfg, "search"),
        clearance,
        start,
        lib.FRONTIER_GAIN,
        ffi.new("frontier_vain_t *"),
        start,
    )
    wave = ffi.addressof(planner.search, "wave")
    frontier = ffi.addressof(planner.search, "frontier")
    cells: list[tuple[int, int, int]] = []
    while wave.status == lib.WAVEFRONT_RUNNING:
        while lib.frontier_look(frontier, wave, grid, clearance):
            ix, iy = wave.met_ix[frontier.looked - 1], wave.met_iy[frontier.looked - 1]
            tile = lib.grid_tile(ix, iy)
            if frontier.rated[tile // 32] >> (tile % 32) & 1:
                cell = ffi.new("grid_cell_t *", (ix, iy))[0]
                cells.append((ix, iy, lib.frontier_gain(grid, clearance, cell)))
        lib.wavefront_extend(wave, clearance, grid, 1)
    best = (frontier.best.ix, frontier.best.iy)
    return tuple(_frontier(known, cell, cell[:2] == best) for cell in cells)


def _frontier(known: Known, cell: tuple[int, int, int], first: bool) -> Frontier:
    ix, iy, gain_cells = cell
    x_m = known.origin.x_m + (ix + 0.5) * known.cell_m
    y_m = known.origin.y_m + (iy + 0.5) * known.cell_m
    return Frontier(Point(x_m, y_m), gain_cells, first)


def _nav_of(known: Known) -> CData:
    """The drone's pipeline, with what is known in it, ready to be asked."""
    nav, cfg = ffi.new("nav_t *"), ffi.new("nav_config_t *")
    lib.nav_config_default(cfg)
    for name, value in known.parameters:
        _PARAMETERS[name](cfg, value)
    cfg.cell_m = known.cell_m
    if lib.nav_config_check(cfg) != lib.MISSION_OK:
        lib.nav_config_default(cfg)
    lib.nav_init(nav, cfg)
    grid, clearance = ffi.addressof(nav, "grid"), ffi.addressof(nav, "clearance")
    lay_out(grid, known.states, known.origin, known.cell_m)
    fence = cfg.area_min_m, cfg.area_max_m
    lib.clearance_init(clearance, grid, lib.nav_clearance_m(nav), *fence)
    lib.clearance_refresh(clearance, grid, lib.GRID_SIDE_CELLS)
    nav.mapped = True
    pose = known.pose
    nav.pose = nav.home = (pose.x_m, pose.y_m, pose.yaw_rad)
    nav.input.odometry.pose = nav.pose
    _set_input(nav, known.health)
    return nav


def _set_input(nav: CData, health: Health | None) -> None:
    """What the ground is not told is taken to be well."""
    flags = lib.NAV_HAS_FLOW | lib.NAV_HAS_RANGER | lib.NAV_ESTIMATOR_SETTLED | lib.NAV_LINK_ALIVE
    if health is None or (health.can_fly and not health.locked):
        flags |= lib.NAV_CAN_FLY
    if health is not None and health.tumbled:
        flags |= lib.NAV_TUMBLED
    nav.input.flags = flags
    nav.input.battery_v = health.battery_v if health else FULL_V


def _command(nav: CData, goal: Point) -> MissionReason:
    if not (math.isfinite(goal.x_m) and math.isfinite(goal.y_m)):
        return MissionReason.BAD_VALUE
    command = ffi.new("nav_command_t *", (int(MissionCmd.GOTO), (goal.x_m, goal.y_m)))
    return MissionReason(lib.nav_command(nav, command))


def _free_start(nav: CData) -> CData | None:
    """Where the drone is, in cells, or the nearest place where it may be."""
    clearance = ffi.addressof(nav, "clearance")
    start = ffi.new("vec2_t *")
    start[0] = lib.grid_to_cells(ffi.addressof(nav, "grid"), lib.pose2_position(nav.pose))
    if lib.clearance_blocked_at(clearance, start[0]) and not lib.clearance_nearest_free(
        clearance, start[0], OUT_CELLS, start
    ):
        return None
    return start[0]


def _search(nav: CData) -> tuple[Edge, ...]:
    """Let it plan to the end. @return the tree of the search when it was largest"""
    widest = ffi.new("tree_t *")
    for _ in range(STEPS_MAX):
        lib.nav_plan_step(nav)
        if nav.planner.grown and nav.planner.search.rrt.tree.count > widest.count:
            widest[0] = nav.planner.search.rrt.tree
        if nav.mission.state != lib.MISSION_PLAN:
            break
    return _edges(widest, nav.grid)


def _edges(tree: CData, grid: CData) -> tuple[Edge, ...]:
    step_m = grid.cell_m / lib.LATTICE_PER_CELL

    def place(node: CData) -> tuple[float, float]:
        return grid.origin_m.x + node.at.x * step_m, grid.origin_m.y + node.at.y * step_m

    nodes = tree.nodes[0 : tree.count]
    return tuple(
        (*place(node), *place(nodes[node.parent]))
        for node in nodes
        if node.cost_cells >= 0.0 and node.parent != lib.TREE_NONE
    )
