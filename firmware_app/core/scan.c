// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
#include "scan.h"

#include <string.h>

enum {
  STUCK_TICKS = 75 /* ticks without a change, after which a range counts as stuck: 15 sets */
};

static const float NO_RANGE = -1.0f; ///< stands for no return
static const float QUARTER_RAD = 1.57079633f;

scan_config_t scan_config_default(void) {
  return (scan_config_t){
      .latency_ms = 90u, // 60-100 ms old when published, seen up to one tick later
      .period_ms = 100u,
      .min_range_m = 0.04f,      // VL53L1X data sheet
      .max_range_m = 3.8f,       // what the sensors call valid, up to a little below their 4 m
      .no_return_clear_m = 1.2f, // a black wall at 45 degrees still answers from here
      .floor_margin_m = 0.08f,
      .offset_m = {0.016f, 0.016f, 0.016f, 0.016f, 0.0f}, // the deck's sensors sit on its rim
  };
}

void scan_init(scan_t *scan, const scan_config_t *cfg) {
  memset(scan, 0, sizeof *scan);
  scan->cfg = *cfg;
  for (int i = 0; i < SCAN_RANGES; i++) {
    scan->last_m[i] = NO_RANGE;
  }
}

float scan_bearing_rad(int beam) {
  switch (beam) {
  case SCAN_BACK:
    return 2.0f * QUARTER_RAD;
  case SCAN_LEFT:
    return QUARTER_RAD;
  case SCAN_RIGHT:
    return -QUARTER_RAD;
  default:
    return 0.0f;
  }
}

uint32_t scan_age_ms(const scan_t *scan, uint32_t time_ms) {
  return time_ms - scan->changed_ms;
}

uint32_t scan_silent_ms(const scan_t *scan, uint32_t time_ms) {
  return time_ms - scan->answered_ms;
}

static void remember(scan_t *scan, const scan_odometry_t *odometry) {
  scan->newest = (uint8_t)((scan->newest + 1u) % SCAN_HISTORY);
  scan->history[scan->newest] = *odometry;
  if (scan->count < SCAN_HISTORY) {
    scan->count++;
  }
}

static const scan_odometry_t *back(const scan_t *scan, int ticks) {
  return &scan->history[(scan->newest + SCAN_HISTORY - ticks) % SCAN_HISTORY];
}

/** State of the body at time_ms, interpolated in the history; its oldest or newest state if time_ms
 *  lies outside. */
static scan_odometry_t odometry_at(const scan_t *scan, uint32_t time_ms) {
  const scan_odometry_t *later = back(scan, 0);
  for (int ticks = 1; ticks < scan->count; ticks++) {
    const scan_odometry_t *earlier = back(scan, ticks);
    int32_t since_ms = (int32_t)(time_ms - earlier->time_ms);
    if (since_ms >= 0) {
      int32_t span_ms = (int32_t)(later->time_ms - earlier->time_ms);
      float fraction =
          span_ms > 0 ? geometry_clamp((float)since_ms / (float)span_ms, 0.0f, 1.0f) : 0.0f;
      scan_odometry_t between = *earlier;
      between.time_ms = time_ms;
      between.pose = pose2_interpolate(earlier->pose, later->pose, fraction);
      between.height_m += fraction * (later->height_m - earlier->height_m);
      between.roll_rad += fraction * (later->roll_rad - earlier->roll_rad);
      between.pitch_rad += fraction * (later->pitch_rad - earlier->pitch_rad);
      return between;
    }
    later = earlier;
  }
  return *later;
}

bool scan_unchanged(const scan_t *scan, int beam) {
  return scan->repeats[beam] >= STUCK_TICKS;
}

/** Store the ranges. @return true if they are a new set */
static bool is_new(scan_t *scan, const float *range_m, uint32_t time_ms) {
  bool changed = false;
  bool answered = false;
  for (int i = 0; i < SCAN_RANGES; i++) {
    float value_m = range_m[i] >= 0.0f && geometry_is_finite(range_m[i]) ? range_m[i] : NO_RANGE;
    bool same = value_m == scan->last_m[i];
    scan->repeats[i] = same ? (uint8_t)(scan->repeats[i] + (scan->repeats[i] < STUCK_TICKS)) : 0;
    changed = changed || !same;
    answered = answered || value_m >= 0.0f;
    scan->last_m[i] = value_m;
  }
  if (answered) {
    scan->answered_ms = time_ms;
  }
  bool silent_set = !answered && time_ms - scan->changed_ms >= scan->cfg.period_ms;
  if (changed || silent_set) {
    scan->changed_ms = time_ms;
  }
  return changed || silent_set;
}

/** Rise of a beam per metre along it, by the body's tilt. */
static float beam_rise(int beam, const scan_odometry_t *odometry) {
  switch (beam) {
  case SCAN_FRONT:
    return geometry_sincos(odometry->pitch_rad).sin;
  case SCAN_BACK:
    return -geometry_sincos(odometry->pitch_rad).sin;
  case SCAN_LEFT:
    return geometry_sincos(odometry->roll_rad).sin;
  default:
    return -geometry_sincos(odometry->roll_rad).sin;
  }
}

static void add_beam(const scan_t *scan, int beam, const scan_odometry_t *odometry,
                     scan_frame_t *frame) {
  const scan_config_t *cfg = &scan->cfg;
  float along_m = scan->last_m[beam];
  bool answered = along_m >= 0.0f && along_m <= cfg->max_range_m;
  if (answered && along_m < cfg->min_range_m) {
    return;
  }
  along_m = (answered ? along_m : cfg->no_return_clear_m) + cfg->offset_m[beam];
  float rise = beam_rise(beam, odometry);
  if (odometry->height_m + rise * along_m < cfg->floor_margin_m) {
    return;
  }
  frame->range_m[beam] = along_m * (1.0f - 0.5f * rise * rise);
  if (answered) {
    frame->hit |= (uint8_t)(1u << beam);
  } else {
    frame->clear |= (uint8_t)(1u << beam);
  }
}

bool scan_step(scan_t *scan, const scan_odometry_t *odometry, const float *range_m,
               scan_frame_t *frame) {
  remember(scan, odometry);
  if (!is_new(scan, range_m, odometry->time_ms)) {
    return false;
  }
  scan_odometry_t then = odometry_at(scan, odometry->time_ms - scan->cfg.latency_ms);
  *frame = (scan_frame_t){.time_ms = then.time_ms, .pose = then.pose};
  for (int beam = 0; beam < SCAN_BEAMS; beam++) {
    add_beam(scan, beam, &then, frame);
  }
  return true;
}
