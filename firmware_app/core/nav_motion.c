// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
/* From mission states to motion, and from what happens on the way to mission events. */
#include <math.h>

#include "nav.h"
#include "nav_parts.h"

enum {
  GLANCES = 3,     ///< sets measured at the end of the observed route, before a stop-and-look
  STALLS_MAX = 12, ///< retreats without progress before a task is given up
  LOOK_STALLS = 2, ///< weight of a stop-and-look among these; a retreat weighs 1
};

static const float HEIGHT_REACHED_M = 0.06f; ///< below the flight height: a take-off is complete
static const float LANDED_M = 0.05f;         ///< measured height that counts as landed
static const float LANDED_BELOW_M = -0.3f;   ///< height setpoint at which it must have landed
static const float GUARD_HEIGHT_M = 0.15f;   ///< below, the beams see the floor
static const float PROGRESS_M = 0.25f;       ///< advance along a route that counts as progress
static const float LOOKAHEAD_M = 1.5f;      ///< of route that is checked: enough to stop from 1 m/s
static const float CLOSEST_M = 0.10f;       ///< propeller tips are 0.07 m out; the rest: map errors
static const float CREEP_M = 0.03f;         ///< room beside the route that is assumed at least
static const float ROOM_AHEAD_M = 0.5f;     ///< of route whose room limits the speed
static const float BLOCKED_MARGIN_M = 0.3f; ///< stop this far before a blocked piece
static const float QUARTER_RAD = 1.57079633f;
static const float FACE_GAIN_PER_S = 3.0f; ///< yaw rate per radian off an approaching obstacle
static const float FACED_S = 2.0f;         ///< time ahead for which an approach is extrapolated
static const float FACED_M = 0.3f; ///< an obstacle that then is this near, beyond yield_m, is faced
static const float FACED_MPS = 0.1f;           ///< slowest approach that is faced
static const uint32_t JUDGED_MS = 800u;        ///< a new obstacle is faced this long in any case
static const float HAND_M = 0.15f;             ///< anything nearer above than this counts as a hand
static const float HAND_S = 0.5f;              ///< a hand above for this long asks to land
static const float WATCH_RPS = 1.3f;           ///< yaw rate of the sweep by watch_rad
static const float SPIN_GAIN_PER_S = 2.0f;     ///< yaw rate per radian left of a spin
static const float SPUN_RAD = 0.05f;           ///< angle left at which a spin is over
static const uint32_t STEP_TIMEOUT_MS = 8000u; ///< of a take-off, and of a stop-and-look
static const uint32_t CALM_MS = 1000u;         ///< without a retreat, before the flight goes on
static const uint32_t STALL_MS = 10000u;       ///< without progress, before a stop-and-look
static const uint32_t RETRY_MS = 3000u;        ///< stops within this time count as one

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
  float wanted_m = nav->by_hand ? nav->height_sp_m : nav->cfg.height_m;
  nav->height_sp_m = ramp(nav->height_sp_m, wanted_m, nav->cfg.climb_mps * nav->tick_s);
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

/** Turn at the post until the spin is complete. */
static follower_command_t spin(nav_t *nav) {
  nav->to_spin_rad -= geometry_wrap_rad(nav->pose.yaw_rad - nav->post.yaw_rad);
  nav->post.yaw_rad = nav->pose.yaw_rad;
  float rate_rps = nav->cfg.scan_rate_rps;
  follower_command_t command = follower_hold(&nav->cfg.follower, nav->pose, nav->post);
  command.yaw_rate_rps = geometry_clamp(SPIN_GAIN_PER_S * nav->to_spin_rad, -rate_rps, rate_rps);
  if (fabsf(nav->to_spin_rad) < SPUN_RAD) {
    nav_apply(nav, MISSION_EV_SCANNED);
  }
  return command;
}

/** Count a stop without progress. After too many, skip the waypoint, or report STUCK and hold; a
 *  drone without a task lands, as it is not left in peace. Exploring never gives up here: planning
 *  chooses another frontier. @return false if it gave up */
static bool keep_trying(nav_t *nav, uint8_t weight) {
  bool idle = nav->mission.task == MISSION_TASK_NONE;
  if (nav->mission.task == MISSION_TASK_EXPLORE ||
      nav_now_ms(nav) - nav->plan.stalled_ms < RETRY_MS) {
    return true;
  }
  nav->plan.stalled_ms = nav_now_ms(nav);
  nav->plan.stalls = (uint8_t)(nav->plan.stalls + weight);
  if (nav->plan.stalls <= STALLS_MAX) {
    return true;
  }
  if (nav_skip_waypoint(nav, MISSION_STUCK)) {
    return true;
  }
  nav->plan.stalls = 0;
  nav_emit(nav, WIRE_EVENT_REFUSED, MISSION_STUCK, pose2_position(nav->pose));
  nav->mission.fault = MISSION_STUCK;
  nav_apply(nav, idle ? MISSION_EV_LAND : MISSION_EV_HOLD);
  return false;
}

static void look_again(nav_t *nav) {
  if (keep_trying(nav, LOOK_STALLS)) {
    nav_apply(nav, MISSION_EV_LOOK);
  }
}

static void note_progress(nav_t *nav) {
  if (nav->follower.progress_m > nav->best_progress_m + PROGRESS_M) {
    nav->best_progress_m = nav->follower.progress_m;
    nav->state_since_ms = nav_now_ms(nav);
    nav->plan.stalls = nav->mission.task == MISSION_TASK_EXPLORE ? nav->plan.stalls : 0u;
    nav->plan.looks_left = NAV_LOOKS;
  }
}

/** At the end of a route. */
static void arrive(nav_t *nav) {
  if (nav->plan.approach) {
    look_again(nav);
    return;
  }
  if (nav_pass_waypoint(nav)) {
    return;
  }
  nav_emit(nav, WIRE_EVENT_ARRIVED, (uint8_t)nav->mission.task, pose2_position(nav->pose));
  nav->plan.wandering = false;
  nav_apply(nav, MISSION_EV_ARRIVED);
  nav->post.x_m = nav->goal_m.x;
  nav->post.y_m = nav->goal_m.y;
}

bool nav_look_along(nav_t *nav) {
  float from_m = nav->follower.progress_m;
  float clear_m = route_clear_m(&nav->route, &nav->grid, &nav->clearance, from_m);
  float known_m = route_known_m(&nav->route, &nav->grid, nav->cfg.look_half_width_m, from_m,
                                from_m + LOOKAHEAD_M);
  known_m = route_seen_m(&nav->route, &nav->grid, &nav->seen, from_m, known_m);
  bool all_clear = clear_m > route_length_m(&nav->route) - 1.0e-3f;
  float safe_m = all_clear ? clear_m : clear_m - BLOCKED_MARGIN_M;
  nav->limits.until_m = known_m < safe_m ? known_m : safe_m;
  nav->limits.room_m =
      geometry_clamp(nav_clearance_m(nav) - CLOSEST_M, CREEP_M, 1.0f) +
      route_room_m(&nav->route, &nav->grid, &nav->clearance, from_m, from_m + ROOM_AHEAD_M);
  return all_clear;
}

static follower_status_t steer_along(nav_t *nav, follower_command_t *command) {
  vec2_t velocity_mps =
      vec2_rotate(nav->input.velocity_mps, nav->pose.yaw_rad - nav->input.odometry.pose.yaw_rad);
  return follower_step(&nav->follower, &nav->cfg.follower, &nav->route, nav->pose, velocity_mps,
                       nav->limits, command);
}

/** Has the follower been waiting at the end of the observed route for too many sets? */
static bool waits_in_vain(nav_t *nav, follower_status_t status, bool fresh) {
  if (status != FOLLOWER_AT_LIMIT) {
    nav->glances = 0;
  } else if (fresh) {
    nav->glances++;
  }
  return nav->glances > GLANCES;
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
  } else if (waits_in_vain(nav, status, fresh) || waited(nav, STALL_MS)) {
    look_again(nav);
  }
  return command;
}

/** While a new route is computed: fly on along the clear part of the old one, or hover. */
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
  follower_command_t command = follower_hold(&nav->cfg.follower, nav->pose, nav->post);
  if (nav_is_steered(nav)) {
    command = nav_follow_stick(nav);
  }
  switch (nav->mission.state) {
  case MISSION_SCAN:
    return turn_around(nav);
  case MISSION_SPIN:
    return spin(nav);
  case MISSION_FOLLOW:
  case MISSION_RETURN:
    return follow(nav, fresh);
  case MISSION_PLAN:
    return bridge(nav, fresh);
  case MISSION_RELOCALISE:
    return nav_reloc_move(nav);
  case MISSION_AVOID:
    return (follower_command_t){.velocity_mps = {0.0f, 0.0f}, .yaw_rate_rps = 0.0f};
  case MISSION_HOVER:
  case MISSION_IDLE:
  case MISSION_TAKEOFF:
  case MISSION_LAND:
  case MISSION_FAULT:
  case MISSION_STATES:
    break;
  }
  return command;
}

/** Velocity that the guard allows, body frame, and the events that follow from it. */
static vec2_t past_guard(nav_t *nav, vec2_t wanted_mps) {
  if (nav->input.odometry.height_m < GUARD_HEIGHT_M) {
    return wanted_mps;
  }
  bool hand = nav->input.range_m[SCAN_UP] >= 0.0f && nav->input.range_m[SCAN_UP] < HAND_M;
  nav->hand_s = hand ? nav->hand_s + nav->tick_s : 0.0f;
  vec2_t allowed_mps = guard_step(&nav->guard, &nav->cfg.guard, nav->input.range_m,
                                  &nav->input.odometry, wanted_mps);
  if (nav->hand_s > HAND_S) {
    nav_apply(nav, MISSION_EV_LAND);
  } else if (nav->guard.status == GUARD_RETREAT) {
    nav_apply(nav, MISSION_EV_NEAR);
    nav->near_ms = nav_now_ms(nav);
    if (nav->mission.state == MISSION_AVOID && waited(nav, STALL_MS)) {
      nav->state_since_ms = nav_now_ms(nav);
      keep_trying(nav, LOOK_STALLS);
    }
  } else if (nav->mission.state == MISSION_AVOID && nav_now_ms(nav) - nav->near_ms > CALM_MS) {
    keep_trying(nav, 1);
    nav_apply(nav, MISSION_EV_CLEAR);
  } else if (nav->mission.state == MISSION_HOVER && waited(nav, STALL_MS)) {
    nav->plan.stalls = 0;
  }
  return allowed_mps;
}

/** Turn so that the nearest beam stays on an approaching obstacle, as it is not seen between two
 *  beams: for JUDGED_MS, and then while it matters or is retreated from. */
static float face_intruder(const nav_t *nav, float yaw_rate_rps) {
  vec2_t offset_m;
  const guard_t *guard = &nav->guard;
  if (!guard_intruder(guard, &nav->input.odometry, &offset_m)) {
    return yaw_rate_rps;
  }
  bool judged = nav->mission.state != MISSION_AVOID && nav_now_ms(nav) - guard->met_ms > JUDGED_MS;
  bool far = vec2_norm(offset_m) - guard->intruder_mps * FACED_S > nav->cfg.guard.yield_m + FACED_M;
  if (judged && (far || guard->intruder_mps < FACED_MPS)) {
    return yaw_rate_rps;
  }
  float bearing_rad = geometry_atan2(offset_m.y, offset_m.x);
  float off_rad = bearing_rad - QUARTER_RAD * floorf(bearing_rad / QUARTER_RAD + 0.5f);
  float most_rps = nav->cfg.follower.yaw_rate_max_rps;
  return geometry_clamp(FACE_GAIN_PER_S * off_rad, -most_rps, most_rps);
}

/** Sweep the yaw to and fro about the commanded heading: otherwise a person who comes between two
 *  beams is not seen, nor is what stands beside the way. */
static float keep_watch(const nav_t *nav, float yaw_rate_rps) {
  float half_rad = nav->cfg.watch_rad;
  if (half_rad <= 0.0f) {
    return yaw_rate_rps;
  }
  float phase = (float)nav_now_ms(nav) * 0.001f * WATCH_RPS / (4.0f * half_rad);
  phase -= floorf(phase);
  bool left = phase < 0.5f;
  float swing_rad = half_rad * (4.0f * (left ? phase : phase - 0.5f) - 1.0f);
  // a triangle wave; the second term makes up for the yaw control, which pulls back to the heading
  float rate_rps = WATCH_RPS + nav->cfg.follower.yaw_gain_per_s * swing_rad;
  float most_rps = nav->cfg.follower.yaw_rate_max_rps;
  return geometry_clamp(yaw_rate_rps + (left ? rate_rps : -rate_rps), -most_rps, most_rps);
}

/** Yaw rate of the present state, by what must be looked at. */
static float look_out(const nav_t *nav, float yaw_rate_rps) {
  switch (nav->mission.state) {
  case MISSION_HOVER:
    return nav_is_steered(nav) ? yaw_rate_rps : face_intruder(nav, keep_watch(nav, yaw_rate_rps));
  case MISSION_AVOID:
    return face_intruder(nav, yaw_rate_rps);
  case MISSION_FOLLOW:
  case MISSION_RETURN:
    return nav->cfg.follower.yaw_mode == FOLLOWER_YAW_FORWARD ? keep_watch(nav, yaw_rate_rps)
                                                              : yaw_rate_rps;
  default:
    return yaw_rate_rps;
  }
}

nav_setpoint_t nav_move(nav_t *nav, bool fresh) {
  if (!mission_airborne(nav->mission.state)) {
    return (nav_setpoint_t){.motors = false};
  }
  steer_height(nav);
  follower_command_t command = command_of_state(nav, fresh);
  bool steers = (nav->input.flags & NAV_ESTIMATOR_SETTLED) != 0;
  float most_mps = steers ? nav->cfg.follower.speed_mps : 0.0f;
  vec2_t wanted_mps = vec2_limit(command.velocity_mps, most_mps);
  vec2_t body_mps = past_guard(nav, vec2_rotate(wanted_mps, -nav->pose.yaw_rad));
  command.yaw_rate_rps = steers ? look_out(nav, command.yaw_rate_rps) : 0.0f;
  if (nav->estimate_good_ms != nav_now_ms(nav)) {
    body_mps = vec2_add(body_mps, guard_slip(&nav->guard, nav->input.odometry.pose.yaw_rad));
  }
  if (!mission_airborne(nav->mission.state)) {
    return (nav_setpoint_t){.motors = false};
  }
  return (nav_setpoint_t){
      .motors = true,
      .height_m = nav->height_sp_m > 0.0f ? nav->height_sp_m : 0.0f,
      .velocity_body_mps = body_mps,
      .yaw_rate_rps = command.yaw_rate_rps,
  };
}
