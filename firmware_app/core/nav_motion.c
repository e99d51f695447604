// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
/* From mission states to motion, and from what is met on the way to mission events. */
#include <math.h>

#include "nav.h"
#include "nav_parts.h"

enum {
  STALLS_MAX = 6,      ///< stops without progress before a task is given up
  LOOKS = 4,           ///< turns to look around before "no way" is final
  FRONTIER_CELLS = 20, ///< fewer new cells at a frontier are no progress
  FRONTIERS_VAIN = 3   ///< frontiers without progress that end an exploration
};

static const float HEIGHT_REACHED_M = 0.06f;
static const float LANDED_M = 0.05f;
static const float LANDED_BELOW_M =
    -0.3f; ///< setpoint this far under the floor: it must have touched down
static const float GUARD_HEIGHT_M = 0.15f; ///< lower, the beams see the floor
static const float BATTERY_HOLD_MS = 2000.0f;
static const float BATTERY_EMPTY_BELOW_V = 0.15f;
static const float PROGRESS_M = 0.25f; ///< along a route: what counts as progress
static const uint32_t STEP_TIMEOUT_MS = 8000u;
static const uint32_t STALL_MS = 10000u;
static const uint32_t FROZEN_MS = 1000u;
static const uint32_t BAD_ESTIMATE_MS = 300u;

static uint32_t now_ms(const nav_t *nav) {
  return nav->input.odometry.time_ms;
}

void nav_fault(nav_t *nav, mission_reason_t reason) {
  nav->mission.fault = reason;
  nav_emit(nav, WIRE_EVENT_FAULT, (uint8_t)reason, pose2_position(nav->pose));
}

/** A goal that the map refuses when it is asked for is refused at once; all else deserves a second
 * look. */
void nav_set_task(nav_t *nav, mission_task_t task) {
  nav->mission.task = task;
  nav->plan.looks_left = task == MISSION_TASK_GOTO ? 0 : LOOKS;
  nav->plan.stalls = 0;
  nav_apply(nav, MISSION_EV_TASK);
}

static void leave_ground(nav_t *nav) {
  nav->mapped = true;
  nav->home = nav->pose;
  nav->height_sp_m = nav->input.odometry.height_m;
  nav->link_lost = false;
  nav->battery_low = false;
  nav->mission.fault = MISSION_OK;
  nav->plan.looks_left = LOOKS;
  nav->plan.stalls = 0;
  nav->plan.known_cells = 0;
}

static void enter_state(nav_t *nav, mission_state_t before) {
  nav->state_since_ms = now_ms(nav);
  nav->post = nav->pose;
  switch (nav->mission.state) {
  case MISSION_IDLE:
  case MISSION_PLAN:
    nav->plan.stage = NAV_PLAN_BEGIN;
    break;
  case MISSION_TAKEOFF:
    if (!mission_airborne(before)) {
      leave_ground(nav);
    }
    break;
  case MISSION_SCAN:
    nav->turned_rad = 0.0f;
    break;
  case MISSION_FOLLOW:
  case MISSION_RETURN:
    follower_start(&nav->follower, nav->pose.yaw_rad);
    nav->best_progress_m = 0.0f;
    nav->allowed_m = route_known_m(&nav->route, &nav->grid, nav->cfg.known_half_width_m);
    break;
  case MISSION_AVOID:
  case MISSION_HOVER:
  case MISSION_LAND:
  case MISSION_FAULT:
  case MISSION_STATES:
    break;
  }
}

void nav_apply(nav_t *nav, mission_event_t event) {
  mission_state_t before = nav->mission.state;
  if (!mission_step(&nav->mission, event)) {
    return;
  }
  if (nav->mission.state != before) {
    nav_emit(nav, WIRE_EVENT_STATE, (uint8_t)nav->mission.state, pose2_position(nav->pose));
  }
  enter_state(nav, before);
}

static void watch_battery(nav_t *nav) {
  if (nav->input.battery_v >= nav->cfg.low_battery_v) {
    nav->battery_good_ms = now_ms(nav);
  }
  bool low = (float)(now_ms(nav) - nav->battery_good_ms) > BATTERY_HOLD_MS;
  if (!low || nav->mission.state == MISSION_LAND) {
    return;
  }
  if (nav->input.battery_v < nav->cfg.low_battery_v - BATTERY_EMPTY_BELOW_V) {
    nav_fault(nav, MISSION_BATTERY_EMPTY);
    nav_apply(nav, MISSION_EV_LAND);
  } else if (!nav->battery_low) {
    nav->battery_low = true;
    nav_fault(nav, MISSION_BATTERY_LOW);
    nav_set_task(nav, MISSION_TASK_HOME);
  }
}

static void watch_link(nav_t *nav) {
  if ((nav->input.flags & NAV_LINK_ALIVE) != 0) {
    nav->link_seen_ms = now_ms(nav);
    nav->link_lost = false;
    return;
  }
  bool late = (float)(now_ms(nav) - nav->link_seen_ms) > nav->cfg.lost_time_s * 1000.0f;
  if (!late || nav->link_lost || nav->cfg.lost == NAV_LOST_GO_ON ||
      nav->mission.state == MISSION_LAND) {
    return;
  }
  nav->link_lost = true;
  nav_fault(nav, MISSION_LINK_LOST);
  if (nav->cfg.lost == NAV_LOST_HOLD) {
    nav_apply(nav, MISSION_EV_HOLD);
  } else if (nav->cfg.lost == NAV_LOST_LAND) {
    nav_apply(nav, MISSION_EV_LAND);
  } else if (nav->mission.task != MISSION_TASK_HOME) {
    nav_set_task(nav, MISSION_TASK_HOME);
  }
}

static void watch_senses(nav_t *nav) {
  bool blind = scan_age_ms(&nav->scan, now_ms(nav)) > FROZEN_MS;
  bool lost = now_ms(nav) - nav->estimate_good_ms > BAD_ESTIMATE_MS;
  if ((blind || lost) && nav->mission.state != MISSION_LAND) {
    nav_fault(nav, blind ? MISSION_RANGES_FROZEN : MISSION_ESTIMATOR);
    nav_apply(nav, MISSION_EV_LAND);
  }
}

void nav_watch(nav_t *nav) {
  if (!mission_airborne(nav->mission.state)) {
    nav->battery_good_ms = nav->link_seen_ms = nav->estimate_good_ms = now_ms(nav);
    return;
  }
  bool tumbled = (nav->input.flags & NAV_TUMBLED) != 0;
  if (tumbled || (nav->input.flags & NAV_CAN_FLY) == 0) {
    nav_fault(nav, tumbled ? MISSION_TUMBLED : MISSION_CANNOT_FLY);
    nav_apply(nav, MISSION_EV_FAILED);
    return;
  }
  watch_battery(nav);
  watch_link(nav);
  watch_senses(nav);
}

static float ramp(float from, float to, float step) {
  return from + geometry_clamp(to - from, -step, step);
}

static bool waited(const nav_t *nav, uint32_t timeout_ms) {
  return now_ms(nav) - nav->state_since_ms > timeout_ms;
}

static void steer_height(nav_t *nav) {
  float height_m = nav->input.odometry.height_m;
  if (nav->mission.state == MISSION_LAND) {
    nav->height_sp_m -= nav->cfg.descend_mps * nav->tick_s;
    if ((nav->height_sp_m < 0.0f && height_m < LANDED_M) || nav->height_sp_m < LANDED_BELOW_M) {
      nav_apply(nav, MISSION_EV_LANDED);
    }
    return;
  }
  nav->height_sp_m = ramp(nav->height_sp_m, nav->cfg.height_m, nav->cfg.climb_mps * nav->tick_s);
  if (nav->mission.state == MISSION_TAKEOFF &&
      (height_m > nav->cfg.height_m - HEIGHT_REACHED_M || waited(nav, STEP_TIMEOUT_MS))) {
    nav_apply(nav, MISSION_EV_HEIGHT);
  }
}

static follower_command_t turn_around(nav_t *nav) {
  follower_command_t command = follower_hold(&nav->cfg.follower, nav->pose, nav->post);
  command.yaw_rate_rps = nav->cfg.scan_rate_rps;
  float turned = geometry_wrap_rad(nav->pose.yaw_rad - nav->post.yaw_rad);
  nav->turned_rad = turned > nav->turned_rad ? turned : nav->turned_rad;
  if (nav->turned_rad >= nav->cfg.scan_turn_rad || waited(nav, STEP_TIMEOUT_MS)) {
    nav_apply(nav, MISSION_EV_SCANNED);
  }
  return command;
}

/** The first way point not behind. */
static int route_index(const nav_t *nav) {
  float left_m = nav->follower.progress_m;
  int i = 0;
  while (i + 2 < nav->route.count) {
    left_m -= vec2_distance(nav->route.points_m[i], nav->route.points_m[i + 1]);
    if (left_m < 0.0f) {
      break;
    }
    i++;
  }
  return i;
}

/** Too many looks without getting on: give up, say so, hold. */
static void look_again(nav_t *nav) {
  if (++nav->plan.stalls > STALLS_MAX) {
    nav_emit(nav, WIRE_EVENT_REFUSED, MISSION_STUCK, pose2_position(nav->pose));
    nav->mission.fault = MISSION_STUCK;
    nav_apply(nav, MISSION_EV_HOLD);
  } else {
    nav_apply(nav, MISSION_EV_LOOK);
  }
}

static void note_progress(nav_t *nav) {
  if (nav->follower.progress_m > nav->best_progress_m + PROGRESS_M) {
    nav->best_progress_m = nav->follower.progress_m;
    nav->state_since_ms = now_ms(nav);
    nav->plan.stalls = 0;
    nav->plan.looks_left = LOOKS;
  }
}

/** At the end of a route. An exploration ends when frontiers show nothing new. */
static void arrive(nav_t *nav) {
  nav_emit(nav, WIRE_EVENT_ARRIVED, (uint8_t)nav->mission.task, pose2_position(nav->pose));
  if (nav->mission.task == MISSION_TASK_EXPLORE) {
    bool vain = nav->grid.known < nav->plan.known_cells + FRONTIER_CELLS;
    nav->plan.known_cells = nav->grid.known;
    nav->plan.stalls = vain ? (uint8_t)(nav->plan.stalls + 1u) : 0;
    if (nav->plan.stalls >= FRONTIERS_VAIN) {
      nav_emit(nav, WIRE_EVENT_EXPLORED, 0, pose2_position(nav->pose));
      nav_set_task(nav, MISSION_TASK_HOME);
      return;
    }
  }
  nav_apply(nav, MISSION_EV_ARRIVED);
  nav->post.x_m = nav->goal_m.x;
  nav->post.y_m = nav->goal_m.y;
}

static follower_command_t follow(nav_t *nav, bool fresh) {
  if (fresh) {
    nav->allowed_m = route_known_m(&nav->route, &nav->grid, nav->cfg.known_half_width_m);
  }
  sincos_t turn = geometry_sincos(nav->slam.map_from_odom.yaw_rad);
  vec2_t v = nav->input.velocity_mps;
  vec2_t velocity_mps = {turn.cos * v.x - turn.sin * v.y, turn.sin * v.x + turn.cos * v.y};
  follower_command_t command;
  follower_status_t status = follower_step(&nav->follower, &nav->cfg.follower, &nav->route,
                                           nav->pose, velocity_mps, nav->allowed_m, &command);
  note_progress(nav);
  if (status == FOLLOWER_ARRIVED) {
    arrive(nav);
  } else if (status == FOLLOWER_AT_LIMIT || waited(nav, STALL_MS)) {
    look_again(nav);
  } else if (fresh && route_blocked(&nav->route, &nav->grid, &nav->clearance, route_index(nav))) {
    nav_apply(nav, MISSION_EV_BLOCKED);
  }
  return command;
}

static follower_command_t command_of_state(nav_t *nav, bool fresh) {
  switch (nav->mission.state) {
  case MISSION_SCAN:
    return turn_around(nav);
  case MISSION_FOLLOW:
  case MISSION_RETURN:
    return follow(nav, fresh);
  case MISSION_AVOID:
    return (follower_command_t){.velocity_mps = {0.0f, 0.0f}, .yaw_rate_rps = 0.0f};
  case MISSION_IDLE:
  case MISSION_TAKEOFF:
  case MISSION_PLAN:
  case MISSION_HOVER:
  case MISSION_LAND:
  case MISSION_FAULT:
  case MISSION_STATES:
    break;
  }
  return follower_hold(&nav->cfg.follower, nav->pose, nav->post);
}

static vec2_t past_guard(nav_t *nav, vec2_t wanted_mps) {
  if (nav->input.odometry.height_m < GUARD_HEIGHT_M) {
    return wanted_mps;
  }
  vec2_t allowed_mps = guard_step(&nav->guard, &nav->cfg.guard, nav->input.range_m, wanted_mps);
  if (nav->guard.status == GUARD_RETREAT) {
    nav_apply(nav, MISSION_EV_NEAR);
  } else if (nav->mission.state == MISSION_AVOID) {
    nav_apply(nav, MISSION_EV_CLEAR);
  }
  return allowed_mps;
}

nav_setpoint_t nav_move(nav_t *nav, bool fresh) {
  if (!mission_airborne(nav->mission.state)) {
    return (nav_setpoint_t){.motors = false};
  }
  steer_height(nav);
  follower_command_t command = command_of_state(nav, fresh);
  vec2_t body_mps = past_guard(nav, vec2_rotate(command.velocity_mps, -nav->pose.yaw_rad));
  if (!mission_airborne(nav->mission.state)) {
    return (nav_setpoint_t){.motors = false};
  }
  return (nav_setpoint_t){
      .motors = true,
      .height_m = nav->height_sp_m > 0.0f ? nav->height_sp_m : 0.0f,
      .velocity_body_mps = vec2_limit(body_mps, nav->cfg.follower.speed_mps),
      .yaw_rate_rps = command.yaw_rate_rps,
  };
}
