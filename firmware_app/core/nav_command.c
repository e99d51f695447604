// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
/* Configuration and commands: what is accepted, and why the rest is refused. */
#include <math.h>
#include <string.h>

#include "nav.h"
#include "nav_parts.h"

enum { KNOWN_MIN_CELLS = 200 /* known cells of a map in which relocalisation may succeed */ };

static const float DEG = 0.0174532925f;
static const float TURN = 6.2831853f; ///< one turn [rad]
static const float TURNS_MAX = 20.0f;
static const float AREA_MAX_M = 30.0f;       ///< largest coordinate of the area
static const float SAME_PLACE_M = 1.0e-3f;   ///< grid centres nearer than this are equal
static const float TAKE_OFF_MARGIN_V = 0.2f; ///< above low_battery_v, for the sag under load

void nav_config_default(nav_config_t *cfg) {
  cfg->scan = scan_config_default();
  cfg->grid = grid_config_default();
  cfg->search = pathfinder_config_default();
  cfg->follower = follower_config_default();
  cfg->guard = guard_config_default();
  cfg->slam_filter = slam_config_default();
  cfg->height_m = 0.4f;
  cfg->clearance_m = 0.17f;
  cfg->cell_m = 0.05f;
  cfg->area_min_m = (vec2_t){-3.2f, -3.2f};
  cfg->area_max_m = (vec2_t){3.2f, 3.2f};
  cfg->low_battery_v = 3.3f;
  cfg->lost_time_s = 5.0f;
  cfg->climb_mps = 0.4f;
  cfg->descend_mps = 0.25f;
  cfg->scan_turn_rad = 100.0f * DEG;
  cfg->scan_rate_rps = 60.0f * DEG;
  cfg->watch_rad = 35.0f * DEG;
  cfg->look_half_width_m = 0.10f;
  cfg->look_age_s = 30.0f;
  cfg->turns = 1.0f;
  cfg->seed = 1u;
  cfg->planner = NAV_PLANNER_RRTSTAR;
  cfg->slam = NAV_SLAM_MAP;
  cfg->lost = NAV_LOST_HOME;
  cfg->frontier = FRONTIER_GAIN;
}

static bool within(float value, float low, float high) {
  return value >= low && value <= high;
}

mission_reason_t nav_config_check(const nav_config_t *cfg) {
  bool good = within(cfg->height_m, 0.2f, 2.0f) && within(cfg->follower.speed_mps, 0.05f, 1.0f) &&
              within(cfg->clearance_m, 0.08f, 0.5f) && within(cfg->cell_m, 0.02f, 0.5f) &&
              within(cfg->follower.turn_rate_rps, -120.0f * DEG, 120.0f * DEG) &&
              within(cfg->area_min_m.x, -AREA_MAX_M, AREA_MAX_M) &&
              within(cfg->area_min_m.y, -AREA_MAX_M, AREA_MAX_M) &&
              within(cfg->area_max_m.x, -AREA_MAX_M, AREA_MAX_M) &&
              within(cfg->area_max_m.y, -AREA_MAX_M, AREA_MAX_M) &&
              within(cfg->low_battery_v, 2.8f, 4.2f) && within(cfg->lost_time_s, 0.5f, 600.0f) &&
              within(cfg->look_half_width_m, 0.0f, 0.5f) &&
              within(cfg->guard.yield_m, 0.0f, 1.5f) && within(cfg->watch_rad, 0.0f, 60.0f * DEG) &&
              within(cfg->turns, -TURNS_MAX, TURNS_MAX) && within(cfg->look_age_s, 1.0f, 3600.0f) &&
              (unsigned)cfg->planner < NAV_PLANNERS && (unsigned)cfg->slam < NAV_SLAM_MODES &&
              (unsigned)cfg->lost < NAV_LOST_POLICIES && (unsigned)cfg->frontier < FRONTIER_MODES &&
              (unsigned)cfg->follower.yaw_mode < FOLLOWER_YAW_MODES;
  return good ? MISSION_OK : MISSION_BAD_VALUE;
}

/** Do centre and cell size of the grid match the configuration? */
static bool map_fits(const nav_t *nav) {
  const float middle_cells = 0.5f * (float)GRID_SIDE_CELLS;
  vec2_t middle_m = grid_to_metres(&nav->grid, (vec2_t){middle_cells, middle_cells});
  vec2_t wanted_m = vec2_scale(vec2_add(nav->cfg.area_min_m, nav->cfg.area_max_m), 0.5f);
  return nav->grid.cell_m == nav->cfg.cell_m && vec2_distance(middle_m, wanted_m) < SAME_PLACE_M;
}

mission_reason_t nav_configure(nav_t *nav, const nav_config_t *cfg) {
  if (nav_config_check(cfg) != MISSION_OK) {
    return MISSION_BAD_VALUE;
  }
  if (cfg != &nav->cfg) {
    nav->cfg = *cfg;
  }
  if (!nav->mapped && !map_fits(nav)) {
    nav_make_map(nav);
  } else {
    clearance_configure(&nav->clearance, &nav->grid, nav_clearance_m(nav), cfg->area_min_m,
                        cfg->area_max_m);
  }
  return MISSION_OK;
}

static bool area_usable(const nav_t *nav) {
  float width_m = nav->cfg.area_max_m.x - nav->cfg.area_min_m.x;
  float depth_m = nav->cfg.area_max_m.y - nav->cfg.area_min_m.y;
  float side_m = (float)GRID_SIDE_CELLS * nav->grid.cell_m + 1.0e-3f;
  return width_m > 0.5f && depth_m > 0.5f &&
         (nav->mapped || (width_m <= side_m && depth_m <= side_m));
}

/** May the drone take off? */
static mission_reason_t preflight(const nav_t *nav) {
  uint8_t flags = nav->input.flags;
  if ((flags & NAV_HAS_FLOW) == 0) {
    return MISSION_NO_FLOW_DECK;
  }
  if ((flags & NAV_HAS_RANGER) == 0) {
    return MISSION_NO_RANGER_DECK;
  }
  if (!(nav->input.battery_v >= nav->cfg.low_battery_v + TAKE_OFF_MARGIN_V)) {
    return MISSION_BATTERY_LOW;
  }
  if ((flags & NAV_TUMBLED) != 0) {
    return MISSION_TUMBLED;
  }
  if ((flags & NAV_CAN_FLY) == 0) {
    return MISSION_CANNOT_FLY;
  }
  if ((flags & NAV_ESTIMATOR_SETTLED) == 0) {
    return MISSION_ESTIMATOR;
  }
  if (nav_half_blind(nav)) {
    return MISSION_BLIND;
  }
  return area_usable(nav) ? MISSION_OK : MISSION_BAD_AREA;
}

mission_reason_t nav_check_place(const nav_t *nav, vec2_t goal_m) {
  grid_cell_t cell;
  if (!(fabsf(goal_m.x) < AREA_MAX_M && fabsf(goal_m.y) < AREA_MAX_M)) {
    return geometry_is_finite(goal_m.x) && geometry_is_finite(goal_m.y) ? MISSION_OUTSIDE_GRID
                                                                        : MISSION_BAD_VALUE;
  }
  if (!grid_locate(&nav->grid, goal_m, &cell)) {
    return MISSION_OUTSIDE_GRID;
  }
  if (!within(goal_m.x, nav->cfg.area_min_m.x, nav->cfg.area_max_m.x) ||
      !within(goal_m.y, nav->cfg.area_min_m.y, nav->cfg.area_max_m.y)) {
    return MISSION_OUTSIDE_AREA;
  }
  return MISSION_OK;
}

static mission_reason_t command_goto(nav_t *nav, vec2_t goal_m) {
  mission_reason_t reason = nav_check_place(nav, goal_m);
  if (reason == MISSION_OK &&
      clearance_blocked_at(&nav->clearance, grid_to_cells(&nav->grid, goal_m))) {
    reason = MISSION_GOAL_OCCUPIED;
  }
  if (reason == MISSION_OK) {
    nav->goal_m = goal_m;
    nav_set_task(nav, MISSION_TASK_GOTO);
  }
  return reason;
}

static mission_reason_t command_waypoints(nav_t *nav, mission_cmd_t cmd) {
  return nav_start_waypoints(nav, cmd == MISSION_CMD_FLY ? MISSION_TASK_FLY : MISSION_TASK_PATROL);
}

/** Drop the believed pose and relocalise. */
static mission_reason_t command_relocalise(nav_t *nav) {
  if (nav->grid.known < KNOWN_MIN_CELLS) {
    return MISSION_NO_MAP;
  }
  nav_lose(nav);
  nav_apply(nav, MISSION_EV_RELOCALISE);
  return MISSION_OK;
}

static mission_reason_t command_grounded(nav_t *nav, const nav_command_t *command) {
  switch (command->cmd) {
  case MISSION_CMD_HOME:
  case MISSION_CMD_LAND:
  case MISSION_CMD_HOLD:
  case MISSION_CMD_SCAN:
    return MISSION_NOT_FLYING;
  default:
    break;
  }
  mission_reason_t reason = preflight(nav);
  if (reason != MISSION_OK) {
    return reason;
  }
  if (command->cmd == MISSION_CMD_GOTO) {
    return command_goto(nav, command->goal_m);
  }
  if (command->cmd == MISSION_CMD_RELOCALISE) {
    return command_relocalise(nav);
  }
  if (command->cmd == MISSION_CMD_FLY || command->cmd == MISSION_CMD_PATROL) {
    return command_waypoints(nav, command->cmd);
  }
  bool explore = command->cmd == MISSION_CMD_EXPLORE;
  bool spin = command->cmd == MISSION_CMD_SPIN;
  nav->to_spin_rad = TURN * nav->cfg.turns;
  nav->mission.task = explore ? MISSION_TASK_EXPLORE : spin ? MISSION_TASK_SPIN : MISSION_TASK_NONE;
  nav_apply(nav, MISSION_EV_TAKE_OFF);
  return MISSION_OK;
}

static mission_reason_t command_airborne(nav_t *nav, const nav_command_t *command) {
  switch (command->cmd) {
  case MISSION_CMD_GOTO:
    return command_goto(nav, command->goal_m);
  case MISSION_CMD_EXPLORE:
    nav_set_task(nav, MISSION_TASK_EXPLORE);
    return MISSION_OK;
  case MISSION_CMD_HOME:
    nav_set_task(nav, MISSION_TASK_HOME);
    return MISSION_OK;
  case MISSION_CMD_LAND:
    nav_apply(nav, MISSION_EV_LAND);
    return MISSION_OK;
  case MISSION_CMD_HOLD:
    nav_apply(nav, MISSION_EV_HOLD);
    return MISSION_OK;
  case MISSION_CMD_SCAN:
    nav_apply(nav, MISSION_EV_SCAN);
    return MISSION_OK;
  case MISSION_CMD_RELOCALISE:
    return command_relocalise(nav);
  case MISSION_CMD_SPIN:
    nav->to_spin_rad = TURN * nav->cfg.turns;
    nav_set_task(nav, MISSION_TASK_SPIN);
    return MISSION_OK;
  case MISSION_CMD_FLY:
  case MISSION_CMD_PATROL:
    return command_waypoints(nav, command->cmd);
  default:
    return MISSION_FLYING;
  }
}

mission_reason_t nav_command(nav_t *nav, const nav_command_t *command) {
  if (command->cmd <= MISSION_CMD_NONE || command->cmd >= MISSION_CMDS) {
    return MISSION_UNKNOWN_COMMAND;
  }
  bool airborne = mission_airborne(nav->mission.state);
  if (command->cmd == MISSION_CMD_FORGET) {
    nav->mapped = airborne;
    nav->mission.lost = false;
    nav_make_map(nav);
    nav_apply(nav, MISSION_EV_SCAN); // the route went with the map: look, then plan again
    return MISSION_OK;
  }
  return airborne ? command_airborne(nav, command) : command_grounded(nav, command);
}
