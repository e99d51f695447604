// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
#include "guard.h"

#include <math.h>

enum { COMING_SETS = 3 /* in a row: no noise comes nearer so often */ };

static const float NOTHING_M = 100.0f;
static const float NEVER_S = 1000.0f;
static const float WATCHED_M = 2.0f;    ///< farther away nothing is a comer
static const float STEADY_RAD = 0.04f;  ///< a set turned more against the one before tells no rate
static const float COMING_MPS = 0.2f;   ///< slower than this is noise
static const float RUNNING_MPS = 2.5f;  ///< faster is another thing in the beam
static const float SAME_M = 0.5f;       ///< so near to where it was met, it is the same comer
static const float REMEMBERED_S = 1.5f; ///< a comer that no beam meets
static const float AHEAD_S = 0.5f;      ///< so long it is thought to go on coming
static const float RESTING_MPS = 0.21f;
static const float STANDING = 0.6f; ///< of the distance, kept from one that stands still
static const float YIELD_GAIN_PER_S = 1.5f;
static const float ASIDE_M = 0.6f; ///< with less room behind it steps aside as well

guard_config_t guard_config_default(void) {
  return (guard_config_t){
      .slow_m = 0.6f,
      .stop_m = 0.20f, // propeller tips are 0.07 m out; the rest is for range noise and overshoot
      .retreat_m = 0.14f,
      .release_m = 0.21f,
      .yield_m = 0.6f,
      .retreat_mps = 0.25f,
      .yield_mps = 0.7f,
      .reaction_s = 0.25f, // ranges are up to 0.2 s old
      .brake_mps2 = 0.8f,
  };
}

void guard_init(guard_t *guard) {
  *guard = (guard_t){.status = GUARD_CLEAR, .nearest_m = NOTHING_M, .away = {0.0f, 0.0f}};
}

static vec2_t beam_direction(int beam) {
  switch (beam) {
  case SCAN_FRONT:
    return (vec2_t){1.0f, 0.0f};
  case SCAN_BACK:
    return (vec2_t){-1.0f, 0.0f};
  case SCAN_LEFT:
    return (vec2_t){0.0f, 1.0f};
  default:
    return (vec2_t){0.0f, -1.0f};
  }
}

static float level_range(const float *range_m, int beam) {
  return range_m[beam] >= 0.0f && range_m[beam] < NOTHING_M ? range_m[beam] : NOTHING_M;
}

/** Greatest speed towards something at range_m from which the drone still stops in time: the root
 * of v reaction + v^2 / (2 brake) = range - stop. */
static float allowed_mps(const guard_config_t *cfg, float range_m) {
  float room_m = range_m - cfg->stop_m;
  if (room_m <= 0.0f) {
    return 0.0f;
  }
  float t = cfg->reaction_s;
  return cfg->brake_mps2 * (sqrtf(t * t + 2.0f * room_m / cfg->brake_mps2) - t);
}

/** Unit vector away from the centre of what is near, each beam weighing by how far it lies within
 * `within_m`. */
static vec2_t away_from_near(const float *range_m, float within_m) {
  vec2_t away = {0.0f, 0.0f};
  for (int beam = 0; beam < SCAN_BEAMS; beam++) {
    float depth_m = within_m - level_range(range_m, beam);
    if (depth_m > 0.0f) {
      away = vec2_sub(away, vec2_scale(beam_direction(beam), depth_m));
    }
  }
  float norm = vec2_norm(away);
  return norm > 1.0e-4f ? vec2_scale(away, 1.0f / norm) : (vec2_t){0.0f, 0.0f};
}

/** Take out of a velocity what goes too fast towards any beam's obstacle. @return true if it was
 * slowed */
static bool slow_down(const guard_config_t *cfg, const float *range_m, vec2_t *velocity_mps) {
  bool slowed = false;
  for (int beam = 0; beam < SCAN_BEAMS; beam++) {
    vec2_t direction = beam_direction(beam);
    float towards_mps = vec2_dot(*velocity_mps, direction);
    float limit_mps = allowed_mps(cfg, level_range(range_m, beam));
    if (towards_mps > limit_mps) {
      *velocity_mps = vec2_sub(*velocity_mps, vec2_scale(direction, towards_mps - limit_mps));
      slowed = true;
    }
  }
  return slowed;
}

static uint32_t age_ms(uint32_t time_ms, uint32_t then_ms) {
  return time_ms - then_ms;
}

/** How much faster than the body's own motion explains a beam's echo comes nearer [m/s], walls at
 * 45 degrees beside it included; 0 if that cannot be told. */
static float coming_mps(const guard_t *guard, const scan_frame_t *frame, int beam) {
  float before_m = guard->seen_m[beam];
  float elapsed_s = (float)age_ms(frame->time_ms, guard->seen_ms) * 0.001f;
  pose2_t step = pose2_compose(pose2_inverse(guard->seen_from), frame->pose);
  if (before_m < 0.0f || elapsed_s > 0.3f || elapsed_s < 0.02f ||
      fabsf(step.yaw_rad) > STEADY_RAD) {
    return 0.0f;
  }
  vec2_t direction = beam_direction(beam);
  float along_m = vec2_dot(pose2_position(step), direction);
  float across_m = fabsf(vec2_dot(pose2_position(step), (vec2_t){-direction.y, direction.x}));
  return (before_m - along_m - across_m - frame->range_m[beam]) / elapsed_s;
}

/** A comer's echo: the same comer goes on, or another one is nearer. How fast it comes is told by
 * a beam that is held on it. */
static void meet(guard_t *guard, const scan_frame_t *frame, vec2_t echo_m) {
  vec2_t here = pose2_position(frame->pose);
  float elapsed_s = (float)age_ms(frame->time_ms, guard->comer_ms) * 0.001f;
  bool known = guard->comer_ms != 0u && elapsed_s < REMEMBERED_S;
  float was_m = vec2_distance(guard->comer_m, here);
  float is_m = vec2_distance(echo_m, here);
  bool same = known && vec2_distance(guard->comer_m, echo_m) < SAME_M;
  bool steady =
      fabsf(geometry_wrap_rad(frame->pose.yaw_rad - guard->seen_from.yaw_rad)) < STEADY_RAD;
  if (!same && known && was_m < is_m) {
    return;
  }
  if (!same) {
    guard->comer_mps = 0.0f;
    guard->side = 0;
    guard->met_ms = frame->time_ms;
  } else if (steady && elapsed_s > 0.02f && elapsed_s < 0.5f) {
    float mps = geometry_clamp((was_m - is_m) / elapsed_s, -RUNNING_MPS, RUNNING_MPS);
    guard->comer_mps += 0.5f * (mps - guard->comer_mps);
  }
  guard->comer_m = echo_m;
  guard->comer_ms = frame->time_ms;
}

void guard_watch(guard_t *guard, const guard_config_t *cfg, const scan_frame_t *frame,
                 const uint8_t *judged) {
  int nearest = -1;
  for (int beam = 0; beam < SCAN_BEAMS; beam++) {
    bool hit = (frame->hit >> beam & 1) != 0 && frame->range_m[beam] < WATCHED_M;
    float mps = hit ? coming_mps(guard, frame, beam) : 0.0f;
    bool comes = mps > COMING_MPS && mps < RUNNING_MPS;
    guard->coming[beam] =
        comes ? (uint8_t)(guard->coming[beam] < 100 ? guard->coming[beam] + 1 : 100) : 0;
    bool comer =
        hit && ((guard->coming[beam] >= COMING_SETS && judged[beam] != GRID_ECHO_FAMILIAR) ||
                judged[beam] == GRID_ECHO_STRANGE);
    if (comer && (nearest < 0 || frame->range_m[beam] < frame->range_m[nearest])) {
      nearest = beam;
    }
  }
  if (nearest >= 0 && cfg->yield_m > 0.0f) {
    vec2_t offset = vec2_scale(beam_direction(nearest), frame->range_m[nearest]);
    meet(guard, frame,
         vec2_add(pose2_position(frame->pose), vec2_rotate(offset, frame->pose.yaw_rad)));
  }
  for (int beam = 0; beam < SCAN_BEAMS; beam++) {
    guard->seen_m[beam] = (frame->hit >> beam & 1) != 0 ? frame->range_m[beam] : -1.0f;
  }
  guard->seen_from = frame->pose;
  guard->seen_ms = frame->time_ms;
}

float guard_comer(const guard_t *guard, pose2_t pose, uint32_t time_ms, vec2_t *offset_m) {
  float age_s = (float)age_ms(time_ms, guard->comer_ms) * 0.001f;
  if (guard->comer_ms == 0u || age_s > REMEMBERED_S) {
    return NEVER_S;
  }
  *offset_m = vec2_rotate(vec2_sub(guard->comer_m, pose2_position(pose)), -pose.yaw_rad);
  return age_s;
}

/** Room in a direction of the body frame, by the beams that look about there. */
static float room_m(const float *range_m, vec2_t direction) {
  float room = NOTHING_M;
  for (int beam = 0; beam < SCAN_BEAMS; beam++) {
    float along = vec2_dot(direction, beam_direction(beam));
    if (along > 0.5f && level_range(range_m, beam) / along < room) {
      room = level_range(range_m, beam) / along;
    }
  }
  return room;
}

/** Velocity that gives way to the comer. @return false if there is no need */
static bool yield(guard_t *guard, const guard_config_t *cfg, const float *range_m,
                  const scan_odometry_t *body, vec2_t wanted_mps, vec2_t *velocity_mps) {
  vec2_t offset;
  float age_s = guard_comer(guard, body->pose, body->time_ms, &offset);
  if (age_s > REMEMBERED_S) {
    return false;
  }
  float distance_m = vec2_norm(offset);
  float comes_mps = geometry_clamp(guard->comer_mps, 0.0f, cfg->yield_mps);
  float ahead_s = (age_s < AHEAD_S ? age_s : AHEAD_S) + cfg->reaction_s;
  float left_m = distance_m - comes_mps * ahead_s;
  float bound_m = guard->comer_mps > COMING_MPS
                      ? cfg->yield_m + (guard->status == GUARD_RETREAT ? 0.1f : 0.0f)
                  : vec2_norm(wanted_mps) < RESTING_MPS ? STANDING * cfg->yield_m
                                                        : 0.0f;
  if (left_m > bound_m || distance_m < 1.0e-3f) {
    return false;
  }
  float speed_mps =
      geometry_clamp(comes_mps + YIELD_GAIN_PER_S * (cfg->yield_m - left_m), 0.0f, cfg->yield_mps);
  vec2_t away = vec2_scale(offset, -1.0f / distance_m);
  vec2_t left = {-away.y, away.x};
  float aside = geometry_clamp(1.0f - (room_m(range_m, away) - cfg->stop_m) / ASIDE_M, 0.0f, 1.0f);
  if (aside > 0.0f && guard->side == 0) {
    float room_left_m = room_m(range_m, left);
    guard->side = room_left_m >= room_m(range_m, vec2_scale(left, -1.0f)) ? 1 : -1;
  }
  guard->away = away;
  vec2_t wish = vec2_add(vec2_scale(away, speed_mps),
                         vec2_scale(left, (float)guard->side * aside * speed_mps));
  *velocity_mps = vec2_limit(wish, cfg->yield_mps);
  slow_down(cfg, range_m, velocity_mps);
  return true;
}

/** No velocity that brings the body nearer to a comer than it would stand. */
static void keep_off(const guard_t *guard, const guard_config_t *cfg, const scan_odometry_t *body,
                     vec2_t *velocity_mps) {
  vec2_t offset;
  if (guard_comer(guard, body->pose, body->time_ms, &offset) > REMEMBERED_S) {
    return;
  }
  if (guard->comer_mps < COMING_MPS && vec2_norm(*velocity_mps) > RESTING_MPS) {
    return;
  }
  float distance_m = vec2_norm(offset);
  float limit_mps = allowed_mps(cfg, distance_m + cfg->stop_m - cfg->yield_m);
  vec2_t towards = vec2_scale(offset, 1.0f / (distance_m + 1.0e-3f));
  float speed_mps = vec2_dot(*velocity_mps, towards);
  if (speed_mps > limit_mps) {
    *velocity_mps = vec2_sub(*velocity_mps, vec2_scale(towards, speed_mps - limit_mps));
  }
}

vec2_t guard_step(guard_t *guard, const guard_config_t *cfg, const float *range_m,
                  const scan_odometry_t *body, vec2_t wanted_mps) {
  guard->nearest_m = NOTHING_M;
  for (int beam = 0; beam < SCAN_BEAMS; beam++) {
    float range = level_range(range_m, beam);
    guard->nearest_m = range < guard->nearest_m ? range : guard->nearest_m;
  }
  vec2_t yielding_mps;
  if (yield(guard, cfg, range_m, body, wanted_mps, &yielding_mps)) {
    guard->status = GUARD_RETREAT;
    return yielding_mps;
  }
  float bound_m = guard->status == GUARD_RETREAT ? cfg->release_m : cfg->retreat_m;
  if (guard->nearest_m < bound_m) {
    guard->status = GUARD_RETREAT;
    guard->away = away_from_near(range_m, cfg->release_m);
    vec2_t retreat_mps = vec2_scale(guard->away, cfg->retreat_mps);
    slow_down(cfg, range_m, &retreat_mps);
    return retreat_mps;
  }
  guard->away = (vec2_t){0.0f, 0.0f};
  vec2_t velocity_mps = wanted_mps;
  keep_off(guard, cfg, body, &velocity_mps);
  bool slowed = slow_down(cfg, range_m, &velocity_mps);
  bool stopped = slowed && vec2_norm(velocity_mps) < 0.1f * vec2_norm(wanted_mps);
  guard->status = stopped                                    ? GUARD_STOP
                  : slowed || guard->nearest_m < cfg->slow_m ? GUARD_SLOW
                                                             : GUARD_CLEAR;
  return velocity_mps;
}
