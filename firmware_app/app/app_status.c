// SPDX-License-Identifier: GPL-3.0-or-later
#include "app_status.h"

#include "log.h"

static const float DEG_PER_RAD = 57.29577951f;

static nav_status_t shown;
static uint8_t shown_source;
static float yaw_deg;
static uint32_t plan_us;
static bool was_planning;
static uint8_t refused;
static uint16_t drops;
static uint16_t bad;
static uint8_t self_state;
static uint32_t self_hash;

static volatile uint32_t worst_us;
static uint32_t worst_read_ms;
static uint32_t worst_read_us;

void app_status_show(const nav_status_t *status, nav_source_t source) {
  shown = *status;
  shown_source = (uint8_t)source;
  yaw_deg = DEG_PER_RAD * status->pose.yaw_rad;
}

void app_status_time(uint32_t tick_us, bool planning) {
  if (planning) {
    plan_us = was_planning ? plan_us + tick_us : tick_us;
  }
  was_planning = planning;
  if (tick_us > worst_us) {
    worst_us = tick_us;
  }
}

void app_status_answer(mission_reason_t reason) {
  refused = (uint8_t)reason;
}

void app_status_selftest(uint8_t state, uint32_t hash) {
  self_state = state;
  self_hash = hash;
}

void app_status_count_drop(void) {
  drops++;
}

void app_status_count_bad(void) {
  bad++;
}

/** Longest tick since the last sample; each sample starts over. */
static uint32_t take_worst(uint32_t timestamp, void *data) {
  (void)data;
  if (timestamp != worst_read_ms) {
    worst_read_ms = timestamp;
    worst_read_us = worst_us;
    worst_us = 0;
  }
  return worst_read_us;
}

static logByFunction_t tick = {.acquireUInt32 = take_worst};

/**
 * State of the mission, pose in the map and cost of the computation. The map frame has its origin
 * and its x axis at the pose of the first take-off.
 */
LOG_GROUP_START(way)
/**
 * @brief Mission state: 0 idle, 1 take-off, 2 scan, 3 plan, 4 follow, 5 avoid, 6 hover, 7 return,
 * 8 land, 9 fault, 10 relocalise, 11 spin
 */
LOG_ADD(LOG_UINT8, state, &shown.state)
/**
 * @brief Why the last flight ended early, a number of mission_reason_t; 0 none
 */
LOG_ADD(LOG_UINT8, fault, &shown.fault)
/**
 * @brief Task of the flight: 0 none, 1 go to, 2 explore, 3 home, 4 spin, 5 fly along the
 * waypoints, 6 patrol
 */
LOG_ADD(LOG_UINT8, task, &shown.task)
/**
 * @brief Answer to the last command, a number of mission_reason_t; 0 taken
 */
LOG_ADD(LOG_UINT8, refused, &refused)
/**
 * @brief Position in the map, x [m]
 */
LOG_ADD(LOG_FLOAT, x, &shown.pose.x_m)
/**
 * @brief Position in the map, y [m]
 */
LOG_ADD(LOG_FLOAT, y, &shown.pose.y_m)
/**
 * @brief Heading in the map, counter-clockwise, -180 to 180 [deg]
 */
LOG_ADD(LOG_FLOAT, yaw, &yaw_deg)
/**
 * @brief Confidence of the map pose, 0 to 100 [%]
 */
LOG_ADD(LOG_UINT8, conf, &shown.confidence)
/**
 * @brief Source of the map pose: 0 odometry alone, 1 SLAM, 2 SLAM that also feeds the estimator,
 * 3 Lighthouse, 4 Loco, 5 positions sent from the ground (motion capture). From 3 on SLAM is off
 */
LOG_ADD(LOG_UINT8, source, &shown_source)
/**
 * @brief Present goal in the map, x [m]
 */
LOG_ADD(LOG_FLOAT, goalX, &shown.goal_m.x)
/**
 * @brief Present goal in the map, y [m]
 */
LOG_ADD(LOG_FLOAT, goalY, &shown.goal_m.y)
/**
 * @brief Length of the present route [m]
 */
LOG_ADD(LOG_FLOAT, pathLen, &shown.path_m)
/**
 * @brief Computing time of the last plan, all its ticks together [us]
 */
LOG_ADD(LOG_UINT32, planUs, &plan_us)
/**
 * @brief Nodes of the last plan
 */
LOG_ADD(LOG_UINT16, planNodes, &shown.plan_nodes)
/**
 * @brief Cells of the map that were observed at least once
 */
LOG_ADD(LOG_UINT16, known, &shown.known_cells)
/**
 * @brief Longest tick since this was last read [us]
 */
LOG_ADD_BY_FUNCTION(LOG_UINT32, tickUs, &tick)
/**
 * @brief App channel packets that found no room, in either direction
 */
LOG_ADD(LOG_UINT16, drops, &drops)
/**
 * @brief App channel packets from the ground that were invalid or refused
 */
LOG_ADD(LOG_UINT16, bad, &bad)
/**
 * @brief Self-test: 0 not run, 1 running, 2 computes the same as a PC, 3 computes something else
 */
LOG_ADD(LOG_UINT8, selfState, &self_state)
/**
 * @brief Hash of all decisions in the self-test
 */
LOG_ADD(LOG_UINT32, selfHash, &self_hash)
LOG_GROUP_STOP(way)
