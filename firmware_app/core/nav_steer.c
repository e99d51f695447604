// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
/* Flying by hand: the stick moves the post, within the geofence and the limits of height. */
#include <math.h>

#include "nav.h"
#include "nav_parts.h"

enum {
  HELD_MS = 500, ///< a stick packet holds for this long
  REST_MS = 500, ///< then the drone has this long to come to rest
};

static const float STICK_MAX = 4.0f;        ///< bound of speed + |yaw rate| + |climb rate|
static const float FENCE_GAIN_PER_S = 1.5f; ///< speed per metre left to the geofence
static const float HEIGHT_MIN_M = 0.2f;     ///< limits of height_m in nav_config_check()
static const float HEIGHT_MAX_M = 2.0f;
static const float CEILING_M = 0.4f; ///< no climbing with anything nearer above

mission_reason_t nav_steer(nav_t *nav, const wire_steer_t *stick) {
  if (!(vec2_norm(stick->velocity_mps) + fabsf(stick->yaw_rate_rps) + fabsf(stick->climb_mps) <=
        STICK_MAX)) {
    return MISSION_BAD_VALUE;
  }
  mission_state_t state = nav->mission.state;
  if (!mission_airborne(state)) {
    return MISSION_NOT_FLYING;
  }
  if (state != MISSION_HOVER && !(state == MISSION_AVOID && nav->by_hand)) {
    return MISSION_BUSY;
  }
  nav->stick = *stick;
  nav->steered_ms = nav_now_ms(nav);
  nav->by_hand = true;
  nav->plan.stalls = 0;
  return MISSION_OK;
}

bool nav_is_steered(const nav_t *nav) {
  return nav->by_hand && nav_now_ms(nav) - nav->steered_ms < HELD_MS + REST_MS;
}

bool nav_rests(const nav_t *nav) {
  return nav->mission.state == MISSION_HOVER && !nav_is_steered(nav);
}

/** Velocity along one axis, limited towards the geofence by the distance left. */
static float fenced(float wanted_mps, float at_m, float low_m, float high_m) {
  float least_mps = FENCE_GAIN_PER_S * (low_m - at_m);
  float most_mps = FENCE_GAIN_PER_S * (high_m - at_m);
  return geometry_clamp(wanted_mps, least_mps < 0.0f ? least_mps : 0.0f,
                        most_mps > 0.0f ? most_mps : 0.0f);
}

static void climb(nav_t *nav) {
  float most_mps = nav->cfg.climb_mps;
  float up_m = nav->input.range_m[SCAN_UP];
  float rise_mps = up_m >= 0.0f && up_m < CEILING_M ? 0.0f : most_mps;
  nav->height_sp_m += nav->tick_s * geometry_clamp(nav->stick.climb_mps, -most_mps, rise_mps);
  nav->height_sp_m = geometry_clamp(nav->height_sp_m, HEIGHT_MIN_M, HEIGHT_MAX_M);
}

follower_command_t nav_follow_stick(nav_t *nav) {
  const nav_config_t *cfg = &nav->cfg;
  if (nav_now_ms(nav) - nav->steered_ms >= HELD_MS) {
    nav->stick = (wire_steer_t){0};
  }
  climb(nav);
  float yaw_rad = geometry_wrap_rad(nav->post.yaw_rad + nav->stick.yaw_rate_rps * nav->tick_s);
  nav->post = (pose2_t){nav->pose.x_m, nav->pose.y_m, yaw_rad};
  follower_command_t command = follower_hold(&cfg->follower, nav->pose, nav->post);
  vec2_t wanted_mps = vec2_rotate(nav->stick.velocity_mps, yaw_rad);
  command.velocity_mps.x =
      fenced(wanted_mps.x, nav->pose.x_m, cfg->area_min_m.x, cfg->area_max_m.x);
  command.velocity_mps.y =
      fenced(wanted_mps.y, nav->pose.y_m, cfg->area_min_m.y, cfg->area_max_m.y);
  float most_rps = cfg->follower.yaw_rate_max_rps;
  command.yaw_rate_rps =
      geometry_clamp(command.yaw_rate_rps + nav->stick.yaw_rate_rps, -most_rps, most_rps);
  return command;
}
