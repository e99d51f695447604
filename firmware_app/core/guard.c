// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
#include "guard.h"

#include <math.h>

static const float NOTHING_M = 100.0f;

guard_config_t guard_config_default(void) {
  return (guard_config_t){
      .slow_m = 0.6f,
      .stop_m = 0.20f, // propeller tips are 0.07 m out; the rest is for range noise and overshoot
      .retreat_m = 0.14f,
      .release_m = 0.21f,
      .retreat_mps = 0.25f,
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

vec2_t guard_step(guard_t *guard, const guard_config_t *cfg, const float *range_m,
                  vec2_t wanted_mps) {
  guard->nearest_m = NOTHING_M;
  for (int beam = 0; beam < SCAN_BEAMS; beam++) {
    float range = level_range(range_m, beam);
    guard->nearest_m = range < guard->nearest_m ? range : guard->nearest_m;
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
  bool slowed = slow_down(cfg, range_m, &velocity_mps);
  bool stopped = slowed && vec2_norm(velocity_mps) < 0.1f * vec2_norm(wanted_mps);
  guard->status = stopped                                    ? GUARD_STOP
                  : slowed || guard->nearest_m < cfg->slow_m ? GUARD_SLOW
                                                             : GUARD_CLEAR;
  return velocity_mps;
}
