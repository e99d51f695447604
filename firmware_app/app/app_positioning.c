// SPDX-License-Identifier: GPL-3.0-or-later
#include "app_positioning.h"

#include <stdbool.h>

#include "FreeRTOS.h"
#include "estimator.h"
#include "log.h"
#include "param.h"
#include "task.h"

#define DEBUG_MODULE "WAYFLIE"
#include "debug.h"

enum {
  LIGHTHOUSE_MEASURES = 2, ///< lighthouse.status: sent to the estimator, looked at each 200 ms
  SILENT_MS = 500,
};

/** Variance of an axis. The estimator begins with 100 m2, flow alone never lowers it. */
static const float BELIEVED_BELOW_M2 = 0.09f;
/** The estimator's own limits. */
static const float VARIANCE_MIN = 1.0e-6f;
static const float VARIANCE_MAX = 100.0f;
/** Of the variance, from one tick to the next: flow lowers it less. */
static const float FELL = 0.99f;
/** The estimator is moved by no more at once. */
static const float STEP_M = 0.10f;
static const float STEP_RAD = 0.052f;

static logVarId_t variance, yaw_variance, lighthouse_status, received;
static paramVarId_t loco_deck;
static uint16_t received_tick;
static uint32_t received_ms, fell_ms; ///< 0: never
static float variance_before_m2;
static uint8_t said; ///< nav_positioning_t that the console was told

void app_positioning_init(void) {
  variance = logGetVarId("kalman", "varX");
  yaw_variance = logGetVarId("kalman", "varD2");
  lighthouse_status = logGetVarId("lighthouse", "status");
  received = logGetVarId("locSrvZ", "tick");
  loco_deck = paramGetVarId("deck", "bcLoco");
  received_tick = logVarIdIsValid(received) ? (uint16_t)logGetUint(received) : 0;
}

static bool loco_attached(void) {
  return PARAM_VARID_IS_VALID(loco_deck) && paramGetUint(loco_deck) != 0;
}

static float variance_of(logVarId_t id) {
  return logVarIdIsValid(id) ? logGetFloat(id) : VARIANCE_MAX;
}

static bool lately(uint32_t time_ms) {
  return time_ms != 0 && T2M(xTaskGetTickCount()) - time_ms < SILENT_MS;
}

/** Loco has no log variable that tells in all its modes: whatever lowers the variance measures. */
static void watch_variance(float variance_m2) {
  if (variance_m2 < FELL * variance_before_m2) {
    fell_ms = T2M(xTaskGetTickCount());
  }
  variance_before_m2 = variance_m2;
}

static void watch_ground(void) {
  const uint16_t tick = logVarIdIsValid(received) ? (uint16_t)logGetUint(received) : 0;
  if (tick != received_tick) {
    received_ms = T2M(xTaskGetTickCount());
    received_tick = tick;
  }
}

static nav_positioning_t who_measures(void) {
  const float variance_m2 = variance_of(variance);
  watch_variance(variance_m2);
  watch_ground();
  if (!(variance_m2 < BELIEVED_BELOW_M2)) {
    return NAV_POSITIONING_NONE;
  }
  if (logVarIdIsValid(lighthouse_status) && logGetUint(lighthouse_status) == LIGHTHOUSE_MEASURES) {
    return NAV_POSITIONING_LIGHTHOUSE;
  }
  if (lately(received_ms)) {
    return NAV_POSITIONING_EXTERNAL;
  }
  return loco_attached() && lately(fell_ms) ? NAV_POSITIONING_LOCO : NAV_POSITIONING_NONE;
}

nav_positioning_t app_positioning_now(void) {
  static const char *const names[] = {"none", "Lighthouse", "Loco", "from the ground"};
  const nav_positioning_t now = who_measures();
  if (now != said) {
    said = (uint8_t)now;
    DEBUG_PRINT("positioning: %s\n", names[now]);
  }
  return now;
}

/** So much that the estimator, as sure as it is, moves by no more than most. */
static float longest(float most, float estimate_variance, float sd) {
  return most * (1.0f + sd * sd / (estimate_variance + VARIANCE_MIN));
}

/** Position and yaw apart, not as one pose: a pose would measure roll and pitch too, which SLAM
 * knows nothing of, and in axes of the world, which mm_pose.c takes for the body's. The height is
 * the estimate's own. */
static void tell(const nav_fix_t *fix, float height_m) {
  const float most_m = longest(STEP_M, variance_of(variance), fix->sd_m);
  const float most_rad = longest(STEP_RAD, variance_of(yaw_variance), fix->sd_rad);
  const vec2_t off_m = vec2_limit(fix->off_m, most_m);
  const positionMeasurement_t position = {
      .x = fix->estimate.x_m + off_m.x,
      .y = fix->estimate.y_m + off_m.y,
      .z = height_m,
      .stdDev = fix->sd_m,
      .source = MeasurementSourceLocationService,
  };
  const yawErrorMeasurement_t yaw = {
      .timestamp = xTaskGetTickCount(),
      .yawError = -geometry_clamp(fix->off_rad, -most_rad, most_rad),
      .stdDev = fix->sd_rad,
  };
  estimatorEnqueuePosition(&position);
  estimatorEnqueueYawError(&yaw);
}

/** Where Loco might measure its word alone counts: it could not be told from ours. */
void app_positioning_tell(nav_t *nav) {
  nav_fix_t fix;
  if (nav_take_fix(nav, &fix) && !loco_attached()) {
    tell(&fix, nav->input.odometry.height_m);
  }
}
