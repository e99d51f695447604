// SPDX-License-Identifier: GPL-3.0-or-later
#include "app_sensors.h"

#include "FreeRTOS.h"
#include "app_link.h"
#include "app_positioning.h"
#include "log.h"
#include "param.h"
#include "supervisor.h"
#include "task.h"

#define DEBUG_MODULE "WAYFLIE"
#include "debug.h"

enum {
  SOURCE_X,
  SOURCE_Y,
  SOURCE_HEIGHT,
  SOURCE_VX,
  SOURCE_VY,
  SOURCE_ROLL,
  SOURCE_PITCH,
  SOURCE_YAW,
  SOURCE_VARIANCE,
  SOURCE_BATTERY = SOURCE_VARIANCE + 3,
  SOURCE_RANGE,
  SOURCE_GYRO = SOURCE_RANGE + SCAN_RANGES,
  SOURCE_FLOW,
  SOURCES,
  RANGE_NOTHING_MM = 8000, ///< values from here on are no return; the firmware uses 32767
  SETTLE_MS = 1000,        ///< low variances for this long: the estimator has settled
  FLOW_FEATURES_MIN = 10,  ///< features on the floor below which the flow is noise
};

static const float RAD_PER_DEG = 0.01745329252f;
static const float M_PER_MM = 0.001f;
/** Variance of the velocity [(m/s)^2] below which the estimator settles, and above which it is no
 *  longer settled. With a Flow deck it is about 0.002 on the ground and 0.02 at a height of 1 m;
 *  without flow it exceeds LOST_ABOVE within seconds. */
static const float SETTLED_BELOW = 0.05f;
static const float LOST_ABOVE = 0.1f;

/** A log variable, and the flag that is never set without it. */
static const struct {
  const char *group;
  const char *name;
  uint8_t flag;
} sources[SOURCES] = {
    [SOURCE_X] = {"stateEstimate", "x", NAV_ESTIMATOR_SETTLED},
    [SOURCE_Y] = {"stateEstimate", "y", NAV_ESTIMATOR_SETTLED},
    [SOURCE_HEIGHT] = {"stateEstimate", "z", NAV_ESTIMATOR_SETTLED},
    [SOURCE_VX] = {"stateEstimate", "vx", NAV_ESTIMATOR_SETTLED},
    [SOURCE_VY] = {"stateEstimate", "vy", NAV_ESTIMATOR_SETTLED},
    [SOURCE_ROLL] = {"stateEstimate", "roll", NAV_ESTIMATOR_SETTLED},
    [SOURCE_PITCH] = {"stateEstimate", "pitch", NAV_ESTIMATOR_SETTLED},
    [SOURCE_YAW] = {"stateEstimate", "yaw", NAV_ESTIMATOR_SETTLED},
    [SOURCE_VARIANCE + 0] = {"kalman", "varPX", NAV_ESTIMATOR_SETTLED},
    [SOURCE_VARIANCE + 1] = {"kalman", "varPY", NAV_ESTIMATOR_SETTLED},
    [SOURCE_VARIANCE + 2] = {"kalman", "varPZ", NAV_ESTIMATOR_SETTLED},
    [SOURCE_BATTERY] = {"pm", "vbat", NAV_CAN_FLY},
    [SOURCE_RANGE + SCAN_FRONT] = {"range", "front", NAV_HAS_RANGER},
    [SOURCE_RANGE + SCAN_BACK] = {"range", "back", NAV_HAS_RANGER},
    [SOURCE_RANGE + SCAN_LEFT] = {"range", "left", NAV_HAS_RANGER},
    [SOURCE_RANGE + SCAN_RIGHT] = {"range", "right", NAV_HAS_RANGER},
    [SOURCE_RANGE + SCAN_UP] = {"range", "up", NAV_HAS_RANGER},
    [SOURCE_GYRO] = {"gyro", "z", NAV_ESTIMATOR_SETTLED},
    [SOURCE_FLOW] = {"motion", "squal", NAV_HAS_FLOW},
};

static logVarId_t ids[SOURCES];
static paramVarId_t flow_deck;
static paramVarId_t ranger_deck;
static uint8_t missing; ///< of nav_flag_t: flags that can never be set
static bool settled;
static uint32_t unsettled_ms; ///< last time a variance was too large

static paramVarId_t find_deck(const char *name, uint8_t flag) {
  const paramVarId_t id = paramGetVarId("deck", name);
  if (!PARAM_VARID_IS_VALID(id)) {
    DEBUG_PRINT("no parameter deck.%s: will not fly\n", name);
    missing |= flag;
  }
  return id;
}

void app_sensors_init(void) {
  for (int i = 0; i < SOURCES; i++) {
    ids[i] = logGetVarId(sources[i].group, sources[i].name);
    if (!logVarIdIsValid(ids[i])) {
      DEBUG_PRINT("no log %s.%s: will not fly\n", sources[i].group, sources[i].name);
      missing |= sources[i].flag;
    }
  }
  flow_deck = find_deck("bcFlow2", NAV_HAS_FLOW);
  ranger_deck = find_deck("bcMultiranger", NAV_HAS_RANGER);
  app_positioning_init();
}

static float value(int source) {
  return logVarIdIsValid(ids[source]) ? logGetFloat(ids[source]) : 0.0f;
}

static float range_m(int beam) {
  const logVarId_t id = ids[SOURCE_RANGE + beam];
  const unsigned range_mm = logVarIdIsValid(id) ? logGetUint(id) : 0;
  return range_mm == 0 || range_mm >= RANGE_NOTHING_MM ? -1.0f : M_PER_MM * (float)range_mm;
}

static bool attached(paramVarId_t deck) {
  return PARAM_VARID_IS_VALID(deck) && paramGetUint(deck) != 0;
}

/** Settled once all variances were small for SETTLE_MS, until one is large or not a number. */
static bool estimator_settled(uint32_t time_ms) {
  const float limit = settled ? LOST_ABOVE : SETTLED_BELOW;
  for (int axis = 0; axis < 3; axis++) {
    if (!(value(SOURCE_VARIANCE + axis) < limit)) {
      settled = false;
      unsettled_ms = time_ms;
    }
  }
  settled = settled || time_ms - unsettled_ms >= SETTLE_MS;
  return settled;
}

static bool sees_floor(void) {
  return value(SOURCE_FLOW) >= FLOW_FEATURES_MIN;
}

static uint8_t read_flags(uint32_t time_ms) {
  const bool can_fly =
      supervisorIsArmed() && supervisorCanFly() && !supervisorIsLocked() && !supervisorIsCrashed();
  uint8_t flags = 0;
  flags |= attached(flow_deck) ? NAV_HAS_FLOW : 0;
  flags |= attached(ranger_deck) ? NAV_HAS_RANGER : 0;
  flags |= estimator_settled(time_ms) ? NAV_ESTIMATOR_SETTLED : 0;
  flags |= can_fly ? NAV_CAN_FLY : 0;
  flags |= supervisorIsFlying() ? NAV_IS_FLYING : 0;
  flags |= supervisorIsTumbled() ? NAV_TUMBLED : 0;
  flags |= sees_floor() ? 0 : NAV_FLOW_LOST;
  flags |= app_link_ground_alive() ? NAV_LINK_ALIVE : 0;
  return flags & (uint8_t)~missing;
}

void app_sensors_read(nav_input_t *input) {
  const uint32_t time_ms = T2M(xTaskGetTickCount());
  input->odometry.time_ms = time_ms;
  input->odometry.pose.x_m = value(SOURCE_X);
  input->odometry.pose.y_m = value(SOURCE_Y);
  input->odometry.pose.yaw_rad = RAD_PER_DEG * value(SOURCE_YAW);
  input->odometry.height_m = value(SOURCE_HEIGHT);
  input->odometry.roll_rad = RAD_PER_DEG * value(SOURCE_ROLL);
  input->odometry.pitch_rad = RAD_PER_DEG * value(SOURCE_PITCH);
  input->velocity_mps.x = value(SOURCE_VX);
  input->velocity_mps.y = value(SOURCE_VY);
  input->yaw_rate_rps = RAD_PER_DEG * value(SOURCE_GYRO);
  for (int beam = 0; beam < SCAN_RANGES; beam++) {
    input->range_m[beam] = range_m(beam);
  }
  input->battery_v = value(SOURCE_BATTERY);
  input->flags = read_flags(time_ms);
  input->positioning = (uint8_t)app_positioning_now();
}
