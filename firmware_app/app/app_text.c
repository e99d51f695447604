// SPDX-License-Identifier: GPL-3.0-or-later
#include "app_text.h"

static const char *const reasons[] = {
    [MISSION_OK] = "ok",
    [MISSION_NO_FLOW_DECK] = "no Flow deck v2",
    [MISSION_NO_RANGER_DECK] = "no Multi-ranger deck",
    [MISSION_BATTERY_LOW] = "battery low",
    [MISSION_BATTERY_EMPTY] = "battery empty",
    [MISSION_ESTIMATOR] = "position estimate not settled",
    [MISSION_CANNOT_FLY] = "not armed, locked or crashed",
    [MISSION_BAD_VALUE] = "value out of range",
    [MISSION_OUTSIDE_GRID] = "goal outside the map",
    [MISSION_OUTSIDE_AREA] = "goal outside the area",
    [MISSION_GOAL_OCCUPIED] = "goal too near to an obstacle",
    [MISSION_GOAL_UNREACHABLE] = "no way to the goal",
    [MISSION_NOT_FLYING] = "only while flying",
    [MISSION_UNKNOWN_COMMAND] = "unknown command",
    [MISSION_BAD_AREA] = "area empty or larger than the map",
    [MISSION_FLYING] = "only on the ground",
    [MISSION_LINK_LOST] = "link lost",
    [MISSION_STUCK] = "stuck",
    [MISSION_RANGES_FROZEN] = "ranges frozen",
    [MISSION_TUMBLED] = "tumbled",
    [MISSION_SELF_TEST] = "self-test is running",
    [MISSION_LOST] = "it does not know where it is in its map",
    [MISSION_NO_MAP] = "there is no map to find itself in",
    [MISSION_NO_WAYPOINTS] = "no waypoints",
    [MISSION_FLOW_LOST] = "the floor is not seen",
    [MISSION_BLIND] = "a side is not seen",
    [MISSION_BUSY] = "busy, let it hold first",
};

_Static_assert(sizeof reasons / sizeof *reasons == MISSION_REASONS, "a reason without words");

const char *app_reason_text(mission_reason_t reason) {
  return (unsigned)reason < MISSION_REASONS ? reasons[reason] : "?";
}
