// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
#include "follower.h"

#include <math.h>

static const float SEARCH_AHEAD_M = 0.6f;  ///< largest advance of progress_m in one tick
static const float SLEW_S = 0.3f;          ///< accel_mps2 times this bounds the change of velocity
static const float TURN_MIN_RAD = 0.05f;   ///< smaller bends do not limit the speed
static const float STOP_GAIN_PER_S = 1.5f; ///< speed per metre left, for the last centimetres
static const float FACE_MIN_M = 0.05f;     ///< a carrot nearer than this gives no direction
static const float FACING_RAD = 0.2f;      ///< heading error at which the front beam sees the route

follower_config_t follower_config_default(void) {
  return (follower_config_t){
      .speed_mps = 0.5f,
      .accel_mps2 = 0.6f,
      .lookahead_m = 0.20f,
      .arrive_m = 0.10f,
      .position_gain_per_s = 1.0f,
      .yaw_gain_per_s = 2.5f,
      .yaw_rate_max_rps = 1.6f,
      .turn_rate_rps = 0.6981317f, // 40 deg/s
      .stray_s = 0.25f,
      .yaw_mode = FOLLOWER_YAW_FORWARD,
  };
}

void follower_start(follower_t *follower, float yaw_rad) {
  *follower = (follower_t){.progress_m = 0.0f, .keep_yaw_rad = yaw_rad, .cross_track_m = 0.0f};
}

static float least(float a, float b) {
  return a < b ? a : b;
}

/** Point of the route at arc length at_m, clamped to its ends. */
static vec2_t point_at(const route_t *route, float at_m) {
  for (int i = 1; i < route->count; i++) {
    vec2_t a = route->points_m[i - 1];
    vec2_t along = vec2_sub(route->points_m[i], a);
    float length_m = vec2_norm(along);
    if (at_m <= length_m && length_m > 0.0f) {
      return vec2_add(a, vec2_scale(along, geometry_clamp(at_m / length_m, 0.0f, 1.0f)));
    }
    at_m -= length_m;
  }
  return route->points_m[route->count - 1];
}

/** Move progress_m to the nearest point of the route; not backwards and not far ahead, because a
 *  route may pass near itself. */
static void advance(follower_t *follower, const route_t *route, vec2_t position) {
  float start_m = 0.0f;
  float best_m = vec2_distance(point_at(route, follower->progress_m), position);
  float progress_m = follower->progress_m;
  for (int i = 1; i < route->count; i++) {
    vec2_t a = route->points_m[i - 1];
    vec2_t along = vec2_sub(route->points_m[i], a);
    float length_m = vec2_norm(along);
    float on_m = length_m > 0.0f ? vec2_dot(vec2_sub(position, a), along) / length_m : 0.0f;
    float at_m = start_m + geometry_clamp(on_m, 0.0f, length_m);
    at_m = geometry_clamp(at_m, follower->progress_m, follower->progress_m + SEARCH_AHEAD_M);
    if (at_m >= start_m && at_m <= start_m + length_m) {
      float distance_m = vec2_distance(point_at(route, at_m), position);
      if (distance_m < best_m) {
        best_m = distance_m;
        progress_m = at_m;
      }
    }
    start_m += length_m;
  }
  follower->progress_m = progress_m;
  follower->cross_track_m = best_m;
}

static float yaw_towards(const follower_config_t *cfg, float yaw_rad, float wanted_rad) {
  float error_rad = geometry_wrap_rad(wanted_rad - yaw_rad);
  return geometry_clamp(cfg->yaw_gain_per_s * error_rad, -cfg->yaw_rate_max_rps,
                        cfg->yaw_rate_max_rps);
}

static float yaw_rate(const follower_t *follower, const follower_config_t *cfg, float yaw_rad,
                      vec2_t ahead_m) {
  switch (cfg->yaw_mode) {
  case FOLLOWER_YAW_TURN:
    return cfg->turn_rate_rps;
  case FOLLOWER_YAW_FORWARD:
    if (vec2_norm(ahead_m) > FACE_MIN_M) {
      return yaw_towards(cfg, yaw_rad, geometry_atan2(ahead_m.y, ahead_m.x));
    }
    return 0.0f;
  case FOLLOWER_YAW_KEEP:
  case FOLLOWER_YAW_MODES:
    break;
  }
  return yaw_towards(cfg, yaw_rad, follower->keep_yaw_rad);
}

/** Speed at which the bend ahead takes no more than accel_mps2 of lateral acceleration. The bend is
 *  the angle between the way to the carrot and from there to a second one, over lookahead_m. */
static float bend_speed_mps(const route_t *route, const follower_config_t *cfg, float at_m,
                            vec2_t near_point) {
  vec2_t first = vec2_sub(near_point, point_at(route, at_m));
  vec2_t second = vec2_sub(point_at(route, at_m + 2.0f * cfg->lookahead_m), near_point);
  float across = first.x * second.y - first.y * second.x;
  float turn_rad = fabsf(geometry_atan2(across, vec2_dot(first, second)));
  return turn_rad > TURN_MIN_RAD ? sqrtf(cfg->accel_mps2 * cfg->lookahead_m / turn_rad)
                                 : cfg->speed_mps;
}

/** Share of the speed: in face-forward mode the front beam must first see where the drone flies. */
static float facing_factor(const follower_config_t *cfg, pose2_t pose, vec2_t direction) {
  if (cfg->yaw_mode != FOLLOWER_YAW_FORWARD) {
    return 1.0f;
  }
  sincos_t heading = geometry_sincos(pose.yaw_rad);
  return geometry_clamp(heading.cos * direction.x + heading.sin * direction.y, 0.1f, 1.0f);
}

follower_status_t follower_step(follower_t *follower, const follower_config_t *cfg,
                                const route_t *route, pose2_t pose, vec2_t velocity_mps,
                                follower_limits_t limits, follower_command_t *command) {
  vec2_t position = pose2_position(pose);
  float end_m = route_length_m(route);
  float stop_m = least(limits.until_m, end_m);
  advance(follower, route, position);
  float carrot_m = follower->progress_m + cfg->lookahead_m;
  vec2_t ahead_m = vec2_sub(point_at(route, carrot_m), position);
  vec2_t carrot = point_at(route, least(carrot_m, stop_m));
  vec2_t to_carrot = vec2_sub(carrot, position);
  float left_m = stop_m - follower->progress_m;
  float distance_m = left_m > vec2_norm(to_carrot) ? left_m : vec2_norm(to_carrot);

  float speed_mps = cfg->speed_mps;
  speed_mps = least(speed_mps, limits.room_m / cfg->stray_s);
  speed_mps = least(speed_mps, bend_speed_mps(route, cfg, follower->progress_m, carrot));
  speed_mps = least(speed_mps, sqrtf(2.0f * cfg->accel_mps2 * distance_m));
  speed_mps = least(speed_mps, STOP_GAIN_PER_S * distance_m);
  float norm = vec2_norm(to_carrot);
  vec2_t direction = norm > 1.0e-4f ? vec2_scale(to_carrot, 1.0f / norm) : (vec2_t){0.0f, 0.0f};
  vec2_t wanted_mps = vec2_scale(direction, speed_mps);
  command->yaw_rate_rps = yaw_rate(follower, cfg, pose.yaw_rad, ahead_m);
  wanted_mps = vec2_scale(wanted_mps, facing_factor(cfg, pose, direction));
  vec2_t change = vec2_limit(vec2_sub(wanted_mps, velocity_mps), cfg->accel_mps2 * SLEW_S);
  command->velocity_mps = vec2_limit(vec2_add(velocity_mps, change), cfg->speed_mps);

  if (distance_m >= cfg->arrive_m) {
    return FOLLOWER_MOVING;
  }
  if (stop_m >= end_m) {
    return FOLLOWER_ARRIVED;
  }
  bool turning = fabsf(command->yaw_rate_rps) > cfg->yaw_gain_per_s * FACING_RAD;
  return turning && cfg->yaw_mode == FOLLOWER_YAW_FORWARD ? FOLLOWER_MOVING : FOLLOWER_AT_LIMIT;
}

follower_command_t follower_hold(const follower_config_t *cfg, pose2_t pose, pose2_t post) {
  vec2_t error = vec2_sub(pose2_position(post), pose2_position(pose));
  return (follower_command_t){
      .velocity_mps =
          vec2_limit(vec2_scale(error, cfg->position_gain_per_s), 0.5f * cfg->speed_mps),
      .yaw_rate_rps = yaw_towards(cfg, pose.yaw_rad, post.yaw_rad),
  };
}
