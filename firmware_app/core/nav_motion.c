// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
/* From mission states to motion, and from what is met on the way to mission events. */
#include <math.h>

#include "nav.h"
#include "nav_parts.h"

enum {
  STALLS_MAX = 6,      ///< stops without progress before a task is given up
  FRONTIER_CELLS = 20, ///< fewer new cells at a frontier are no progress
  FRONTIERS_VAIN = 3,  ///< frontiers without progress that end an exploration
};

static const float HEIGHT_REACHED_M = 0.06f;
static const float LANDED_M = 0.05f;
static const float LANDED_BELOW_M =
    -0.3f; ///< setpoint this far under the floor: it must have touched down
static const float GUARD_HEIGHT_M = 0.15f; ///< lower, the beams see the floor
static const float PROGRESS_M = 0.25f;     ///< along a route: what counts as progress
static const float LOOKAHEAD_M = 1.5f; ///< of observed route: more than it takes to stop from 1 m/s
static const float BLOCKED_MARGIN_M = 0.3f; ///< stop this much before a blocked piece
static const uint32_t STEP_TIMEOUT_MS = 8000u;
static const uint32_t STALL_MS = 10000u;

static float ramp(float from, float to, float step) {
  return from + geometry_clamp(to - from, -step, step);
}

static bool waited(const nav_t *nav, uint32_t timeout_ms) {
  return nav_now_ms(nav) - nav->state_since_ms > timeout_ms;
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
    nav->state_since_ms = nav_now_ms(nav);
    nav->plan.stalls = 0;
    nav->plan.looks_left = NAV_LOOKS;
  }
}

/** At the end of a route. An exploration ends when frontiers show nothing new. */
static void arrive(nav_t *nav) {
  if (nav->plan.approach) {
    look_again(nav);
    return;
  }
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

bool nav_look_along(nav_t *nav) {
  float from_m = nav->follower.progress_m;
  float clear_m = route_clear_m(&nav->route, &nav->grid, &nav->clearance, from_m);
  float known_m = route_known_m(&nav->route, &nav->grid, nav->cfg.known_half_width_m, from_m,
                                from_m + LOOKAHEAD_M);
  bool all_clear = clear_m > route_length_m(&nav->route) - 1.0e-3f;
  float safe_m = all_clear ? clear_m : clear_m - BLOCKED_MARGIN_M;
  nav->allowed_m = known_m < safe_m ? known_m : safe_m;
  return all_clear;
}

static follower_status_t steer_along(nav_t *nav, follower_command_t *command) {
  vec2_t velocity_mps =
      vec2_rotate(nav->input.velocity_mps, nav->pose.yaw_rad - nav->input.odometry.pose.yaw_rad);
  return follower_step(&nav->follower, &nav->cfg.follower, &nav->route, nav->pose, velocity_mps,
                       nav->allowed_m, command);
}

static follower_command_t follow(nav_t *nav, bool fresh) {
  bool clear = !fresh || nav_look_along(nav);
  follower_command_t command;
  follower_status_t status = steer_along(nav, &command);
  note_progress(nav);
  if (status == FOLLOWER_ARRIVED) {
    arrive(nav);
  } else if (!clear) {
    nav_apply(nav, MISSION_EV_BLOCKED);
  } else if (status == FOLLOWER_AT_LIMIT || waited(nav, STALL_MS)) {
    look_again(nav);
  }
  return command;
}

/** While a new route is computed: on along what is still clear of the old one, or hover. */
static follower_command_t bridge(nav_t *nav, bool fresh) {
  follower_command_t command = follower_hold(&nav->cfg.follower, nav->pose, nav->post);
  if (nav->rolling) {
    if (fresh) {
      nav_look_along(nav);
    }
    steer_along(nav, &command);
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
  case MISSION_PLAN:
    return bridge(nav, fresh);
  case MISSION_RELOCALISE:
    return nav_look_about(nav);
  case MISSION_AVOID:
    return (follower_command_t){.velocity_mps = {0.0f, 0.0f}, .yaw_rate_rps = 0.0f};
  case MISSION_IDLE:
  case MISSION_TAKEOFF:
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
