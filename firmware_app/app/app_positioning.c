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
  LIGHTHOUSE_MEASURES = 2, ///< lighthouse.status: angles go to the estimator; updated each 200 ms
  SILENT_MS = 500,         ///< a system silent for this long no longer measures
};

/** Position variance per axis below which the estimator follows a positioning system. It starts
 *  with 100 m2, and flow alone never lowers it. */
static const float BELIEVED_BELOW_M2 = 0.09f;
/** The estimator's own limits of a variance. */
static const float VARIANCE_MIN = 1.0e-6f;
static const float VARIANCE_MAX = 100.0f;
/** Fall of the variance from one tick to the next that shows a measurement: flow lowers it less. */
static const float FELL = 0.99f;
/** Largest correction of the estimate at once: 3 degrees for the yaw. */
static const float STEP_M = 0.10f;
static const float STEP_RAD = 0.052f;

static logVarId_t variance, yaw_variance, lighthouse_status, received;
static paramVarId_t loco_deck;
static uint16_t received_tick;        ///< locSrvZ.tick of the last external position
static uint32_t received_ms, fell_ms; ///< external position, fall of the variance; 0: never
static float variance_before_m2;      ///< in the previous tick
static uint8_t said;                  ///< nav_positioning_t last printed on the console

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

/** No log variable shows in all modes whether Loco measures: a falling variance does. */
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

/** Largest innovation by which the estimator moves `most` at most: its Kalman gain is P / (P + R),
 *  with P its variance and R = sd^2. */
static float longest(float most, float estimate_variance, float sd) {
  return most * (1.0f + sd * sd / (estimate_variance + VARIANCE_MIN));
}

/** Feed the estimator with position and yaw separately, not as one pose: a pose would measure roll
 *  and pitch too, which SLAM does not know, and about the world's axes, which mm_pose.c takes for
 *  the body's. The height is the estimate's own. */
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

/** With a Loco deck the estimator is not fed: Loco is recognised by a falling variance, which our
 *  corrections would cause too. */
void app_positioning_tell(nav_t *nav) {
  nav_fix_t fix;
  if (nav_take_fix(nav, &fix) && !loco_attached()) {
    tell(&fix, nav->input.odometry.height_m);
  }
}
