// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
/* Relocalisation: when the pose is lost, how the drone moves to find it, and what follows. */
#include <math.h>
#include <string.h>

#include "nav.h"
#include "nav_parts.h"

enum { UNITS_PER_TICK = 400 /* budget of reloc_work() */ };

static const float PI = 3.14159265f;
static const float LOOK_RAD = 3.5f;    ///< turn after each move: 200 degrees
static const float TURN_RPS = 0.7854f; ///< 45 deg/s: sets, ten a second, are 5 degrees apart
static const float MOVE_M = 0.8f;      ///< longest move
static const float MOVED_M = 0.1f;     ///< distance from its end at which a move is over
static const float MOVE_MPS = 0.25f;
static const float MOVE_MIN_M = 0.1f; ///< shortest move
static const float ROOM_M = 0.45f;    ///< range to be left ahead at the end of a move
static const float BACK_RAD = 2.35f;  ///< directions farther than this from the last move undo it
static const float NO_ECHO_M = 1.2f;  ///< range assumed for a beam without return
static const float LIFTED_M = 0.25f;  ///< height with motors off at which somebody holds the drone
static const uint32_t MOVE_TIMEOUT_MS = 5000u;
static const uint32_t GIVE_UP_MS = 60000u; ///< longest relocalisation
static const uint32_t LIFTED_MS = 400u;    ///< above LIFTED_M for this long: lifted

void nav_lose(nav_t *nav) {
  nav->mission.lost = true;
  slam_tie(&nav->slam, nav->input.odometry.pose, nav->pose);
}

void nav_watch_lifting(nav_t *nav) {
  if (!nav->mapped || nav->input.odometry.height_m < LIFTED_M) {
    nav->reloc_motion.down_ms = nav_now_ms(nav);
  } else if (!nav->mission.lost && !nav->aside &&
             nav_now_ms(nav) - nav->reloc_motion.down_ms > LIFTED_MS) {
    nav_lose(nav);
  }
}

bool nav_take_map_piece(nav_t *nav, const uint8_t *bytes) {
  if (mission_airborne(nav->mission.state) || !mapstream_take(&nav->grid, nav->epoch, bytes)) {
    return false;
  }
  clearance_mark(&nav->clearance, &nav->grid);
  nav->mapped = true;
  nav_lose(nav);
  return true;
}

static void begin_turn(nav_t *nav, float turn_rad) {
  nav->reloc_motion.moving = false;
  nav->reloc_motion.to_turn_rad = turn_rad;
  nav->reloc_motion.left = !nav->reloc_motion.left;
  nav->post = nav->pose;
}

void nav_reloc_start(nav_t *nav) {
  nav->plan.stage = NAV_PLAN_DONE;
  nav->reloc_motion.came = nav->reloc_motion.left = false;
  reloc_init(&nav->reloc);
  begin_turn(nav, 2.0f * PI);
}

void nav_reloc_stop(nav_t *nav) {
  memset(&nav->planner, 0, sizeof nav->planner);
}

/** The pose is found: tie map and odometry anew. A home set while lost moves along. */
static void found(nav_t *nav, pose2_t pose) {
  if (nav->reloc_motion.home_too) {
    pose2_t to_home = pose2_compose(pose2_inverse(nav->pose), nav->home);
    nav->home = pose2_compose(pose, to_home);
    nav->reloc_motion.home_too = false;
  }
  nav->mission.lost = false;
  slam_find(&nav->slam, nav->input.odometry.pose, pose);
  nav->pose = slam_pose(&nav->slam);
  seen_forget(&nav->seen);
  nav_emit(nav, WIRE_EVENT_FOUND, 0, pose2_position(pose));
  nav_apply(nav, MISSION_EV_FOUND);
}

void nav_reloc_step(nav_t *nav) {
  reloc_work(&nav->reloc, &nav->grid, UNITS_PER_TICK);
  pose2_t pose;
  if (nav->reloc.sure && reloc_to_map(&nav->reloc, nav->input.odometry.pose, &pose)) {
    found(nav, pose);
  } else if (nav_now_ms(nav) - nav->state_since_ms > GIVE_UP_MS) {
    nav_fault(nav, MISSION_LOST);
    nav_apply(nav, MISSION_EV_NOT_FOUND);
  }
}

static float reach_m(const nav_t *nav, int beam) {
  float range_m = nav->input.range_m[beam];
  return range_m >= 0.0f ? range_m : NO_ECHO_M;
}

static float direction_rad(const nav_t *nav, int beam) {
  return nav->pose.yaw_rad + scan_bearing_rad(beam);
}

/** Beam with the longest range; backwards only if no other has room. @return -1 if none has */
static int way_out(const nav_t *nav) {
  int best = -1;
  int back = -1;
  for (int beam = 0; beam < SCAN_BEAMS; beam++) {
    float off_rad = geometry_wrap_rad(direction_rad(nav, beam) - nav->reloc_motion.came_rad);
    bool is_back = nav->reloc_motion.came && fabsf(off_rad) > BACK_RAD;
    int *kept = is_back ? &back : &best;
    bool roomy = reach_m(nav, beam) > ROOM_M + MOVE_MIN_M;
    if (roomy && (*kept < 0 || reach_m(nav, beam) > reach_m(nav, *kept))) {
      *kept = beam;
    }
  }
  return best >= 0 ? best : back;
}

static void begin_move(nav_t *nav, int beam) {
  float length_m = geometry_clamp(reach_m(nav, beam) - ROOM_M, 0.0f, MOVE_M);
  nav->reloc_motion.came_rad = direction_rad(nav, beam);
  vec2_t step_m = vec2_rotate((vec2_t){length_m, 0.0f}, nav->reloc_motion.came_rad);
  nav->post = nav->pose;
  nav->post.x_m += step_m.x;
  nav->post.y_m += step_m.y;
  nav->reloc_motion.moving = nav->reloc_motion.came = true;
  nav->reloc_motion.move_since_ms = nav_now_ms(nav);
}

/** Turn at the post. The sense alternates, so that the gyro's scale error does not add up. */
static float turn(nav_t *nav) {
  nav->reloc_motion.to_turn_rad -= TURN_RPS * nav->tick_s;
  if (nav->reloc_motion.to_turn_rad > 0.0f) {
    return nav->reloc_motion.left ? TURN_RPS : -TURN_RPS;
  }
  int beam = way_out(nav);
  if (beam >= 0) {
    begin_move(nav, beam);
  } else {
    begin_turn(nav, LOOK_RAD);
  }
  return 0.0f;
}

follower_command_t nav_reloc_move(nav_t *nav) {
  float yaw_rate_rps = 0.0f;
  if (!nav->reloc_motion.moving) {
    yaw_rate_rps = turn(nav);
  } else if (vec2_distance(pose2_position(nav->pose), pose2_position(nav->post)) < MOVED_M ||
             nav_now_ms(nav) - nav->reloc_motion.move_since_ms > MOVE_TIMEOUT_MS) {
    begin_turn(nav, LOOK_RAD);
  }
  follower_command_t command = follower_hold(&nav->cfg.follower, nav->pose, nav->post);
  command.velocity_mps = vec2_limit(command.velocity_mps, MOVE_MPS);
  command.yaw_rate_rps = nav->reloc_motion.moving ? command.yaw_rate_rps : yaw_rate_rps;
  return command;
}
