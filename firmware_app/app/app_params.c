// SPDX-License-Identifier: GPL-3.0-or-later
#include "app_params.h"

#include <stdatomic.h>
#include <stddef.h>
#include <string.h>

#include "app_text.h"
#include "param.h"

#define DEBUG_MODULE "WAYFLIE"
#include "debug.h"

static const float RAD_PER_DEG = 0.01745329252f;

/** Values of the parameters, in their units. Without padding, as copies are compared bytewise. */
typedef struct {
  float height, speed, clearance, yaw_rate_dps;
  float area_x0, area_y0, area_x1, area_y1;
  float lost_time, low_battery, cell, look_age, look_width, yield, watch_deg, turns;
  uint8_t yaw_mode, planner, slam, lost, frontier;
  uint8_t unused[3];
} values_t;

/** As in nav_config_default(). A client that asks for a parameter's default gets these. */
#define DEFAULTS                                                                                   \
  {                                                                                                \
    .height = 0.4f, .speed = 0.5f, .clearance = 0.17f, .yaw_rate_dps = 40.0f, .area_x0 = -3.2f,    \
    .area_y0 = -3.2f, .area_x1 = 3.2f, .area_y1 = 3.2f, .lost_time = 5.0f, .low_battery = 3.3f,    \
    .cell = 0.05f, .look_age = 30.0f, .look_width = 0.1f, .yield = 0.6f, .watch_deg = 35.0f,       \
    .turns = 1.0f, .slam = NAV_SLAM_MAP, .lost = NAV_LOST_HOME,                                    \
  }

static values_t wanted = DEFAULTS;
static values_t accepted;

static uint8_t cmd;
static paramVarId_t cmd_id; ///< looked up once, as the firmware compares all names
static float goal_x, goal_y;
static _Atomic uint8_t pending_cmd;
static atomic_bool changed = true;

static uint8_t selftest;
static atomic_bool selftest_asked = true; ///< at the start the stored value requests it

typedef enum { NUMBER, DEGREES, CHOICE } kind_t;

/** Place of a value in values_t and in the core's configuration. */
typedef struct {
  const char *name;
  kind_t kind;
  uint16_t core_offset;
  uint8_t core_size;
  uint8_t offset;
} tunable_t;

#define TUNABLE(name, kind, field, core_field)                                                     \
  {                                                                                                \
    (name), (kind), (uint16_t)offsetof(nav_config_t, core_field),                                  \
        (uint8_t)sizeof(((const nav_config_t *)0)->core_field), (uint8_t)offsetof(values_t, field) \
  }

static const tunable_t tunables[] = {
    TUNABLE("height", NUMBER, height, height_m),
    TUNABLE("speed", NUMBER, speed, follower.speed_mps),
    TUNABLE("clearance", NUMBER, clearance, clearance_m),
    TUNABLE("yawMode", CHOICE, yaw_mode, follower.yaw_mode),
    TUNABLE("yawRate", DEGREES, yaw_rate_dps, follower.turn_rate_rps),
    TUNABLE("planner", CHOICE, planner, planner),
    TUNABLE("slam", CHOICE, slam, slam),
    TUNABLE("areaX0", NUMBER, area_x0, area_min_m.x),
    TUNABLE("areaY0", NUMBER, area_y0, area_min_m.y),
    TUNABLE("areaX1", NUMBER, area_x1, area_max_m.x),
    TUNABLE("areaY1", NUMBER, area_y1, area_max_m.y),
    TUNABLE("lost", CHOICE, lost, lost),
    TUNABLE("frontier", CHOICE, frontier, frontier),
    TUNABLE("lostTime", NUMBER, lost_time, lost_time_s),
    TUNABLE("lowBat", NUMBER, low_battery, low_battery_v),
    TUNABLE("cell", NUMBER, cell, cell_m),
    TUNABLE("lookAge", NUMBER, look_age, look_age_s),
    TUNABLE("yield", NUMBER, yield, guard.yield_m),
    TUNABLE("watch", DEGREES, watch_deg, watch_rad),
    TUNABLE("lookWidth", NUMBER, look_width, look_half_width_m),
    TUNABLE("turns", NUMBER, turns, turns),
};

enum { TUNABLES = sizeof tunables / sizeof *tunables };

static size_t size_of(const tunable_t *tunable) {
  return tunable->kind == CHOICE ? sizeof(uint8_t) : sizeof(float);
}

/** Copy one value to the core's configuration, where enumerations may be wider. */
static void hand_over(const tunable_t *tunable, const values_t *values, nav_config_t *cfg) {
  const uint8_t *from = (const uint8_t *)values + tunable->offset;
  uint8_t *to = (uint8_t *)cfg + tunable->core_offset;
  memset(to, 0, tunable->core_size);
  memcpy(to, from, size_of(tunable));
  if (tunable->kind == DEGREES) {
    float angle;
    memcpy(&angle, from, sizeof angle);
    angle *= RAD_PER_DEG;
    memcpy(to, &angle, sizeof angle);
  }
}

static void to_config(const values_t *values, nav_config_t *cfg) {
  for (int i = 0; i < TUNABLES; i++) {
    hand_over(&tunables[i], values, cfg);
  }
}

void app_params_init(nav_t *nav) {
  accepted = (values_t)DEFAULTS;
  nav_config_default(&nav->cfg);
  to_config(&accepted, &nav->cfg);
  nav_init(nav, &nav->cfg);
  cmd_id = paramGetVarId("way", "cmd");
  changed = true;
}

/** Try a set of values; if it is refused, the configuration stays as it was. */
static mission_reason_t offer(nav_t *nav, const values_t *values) {
  to_config(values, &nav->cfg);
  const mission_reason_t reason = nav_configure(nav, &nav->cfg);
  if (reason == MISSION_OK) {
    accepted = *values;
  } else {
    to_config(&accepted, &nav->cfg);
  }
  return reason;
}

/** Set a parameter back to its accepted value, which also tells the client. */
static void put_back(const tunable_t *tunable) {
  const paramVarId_t id = paramGetVarId("way", tunable->name);
  const uint8_t *value = (const uint8_t *)&accepted + tunable->offset;
  if (!PARAM_VARID_IS_VALID(id)) {
    return;
  }
  if (tunable->kind == CHOICE) {
    paramSetInt(id, *value);
  } else {
    float number;
    memcpy(&number, value, sizeof number);
    paramSetFloat(id, number);
  }
}

static bool is_new(const values_t *all, const tunable_t *tunable) {
  const uint8_t *wanted_value = (const uint8_t *)all + tunable->offset;
  return memcmp(wanted_value, (const uint8_t *)&accepted + tunable->offset, size_of(tunable)) != 0;
}

/** Try one of the wanted values together with those accepted so far. */
static mission_reason_t offer_one(nav_t *nav, const values_t *all, const tunable_t *tunable) {
  values_t trial = accepted;
  memcpy((uint8_t *)&trial + tunable->offset, (const uint8_t *)all + tunable->offset,
         size_of(tunable));
  return offer(nav, &trial);
}

void app_params_apply(nav_t *nav) {
  if (!atomic_exchange(&changed, false)) {
    return;
  }
  const values_t all = wanted;
  // NOLINTNEXTLINE(bugprone-suspicious-memory-comparison): any other bits are another value
  if (memcmp(&all, &accepted, sizeof all) == 0) {
    return;
  }
  if (offer(nav, &all) == MISSION_OK) {
    return;
  }
  for (int i = 0; i < TUNABLES; i++) {
    const mission_reason_t reason =
        is_new(&all, &tunables[i]) ? offer_one(nav, &all, &tunables[i]) : MISSION_OK;
    if (reason != MISSION_OK) {
      DEBUG_PRINT("way.%s refused: %s\n", tunables[i].name, app_reason_text(reason));
      put_back(&tunables[i]);
    }
  }
}

bool app_params_take_command(nav_command_t *command) {
  const uint8_t taken = atomic_exchange(&pending_cmd, 0);
  if (taken == MISSION_CMD_NONE) {
    return false;
  }
  command->cmd = (mission_cmd_t)taken;
  command->goal_m = (vec2_t){goal_x, goal_y};
  if (PARAM_VARID_IS_VALID(cmd_id)) {
    paramSetInt(cmd_id, MISSION_CMD_NONE);
  }
  return true;
}

bool app_params_take_selftest(void) {
  return atomic_exchange(&selftest_asked, false) && selftest != 0;
}

/** Callbacks: they run in the task that received the value. */
static void on_change(void) {
  changed = true;
}

static void on_command(void) {
  if (cmd != MISSION_CMD_NONE) {
    pending_cmd = cmd;
  }
}

static void on_selftest(void) {
  selftest_asked = true;
}

/**
 * Autonomous flight through unknown rooms: commands and tuning. The map frame has its origin and
 * its x axis at the pose of the first take-off. A value that is not a number or out of range is
 * refused: it reads back unchanged, and the console says why. Tuning can be stored.
 */
PARAM_GROUP_START(way)
/**
 * @brief Command: 1 take off, 2 go to goalX/goalY, 3 explore, 4 return home, 5 land, 6 hold here,
 * 7 scan (stop and look: a quarter turn), 8 forget the map, 9 relocalise in the map, 10 spin,
 * 11 fly along the waypoints, 12 patrol them. Reads 0 once taken; log way.refused has the answer.
 */
PARAM_ADD_WITH_CALLBACK(PARAM_UINT8, cmd, &cmd, on_command)
/**
 * @brief Goal of command 2 in the map, x [m]
 */
PARAM_ADD(PARAM_FLOAT, goalX, &goal_x)
/**
 * @brief Goal of command 2 in the map, y [m]
 */
PARAM_ADD(PARAM_FLOAT, goalY, &goal_y)
/**
 * @brief Flight height above the floor, 0.2 to 2 [m]
 */
PARAM_ADD_WITH_CALLBACK(PARAM_FLOAT | PARAM_PERSISTENT, height, &wanted.height, on_change)
/**
 * @brief Cruise speed, 0.05 to 1 [m/s]
 */
PARAM_ADD_WITH_CALLBACK(PARAM_FLOAT | PARAM_PERSISTENT, speed, &wanted.speed, on_change)
/**
 * @brief Distance that routes keep from obstacles, measured from the drone's centre,
 * 0.08 to 0.5 [m]
 */
PARAM_ADD_WITH_CALLBACK(PARAM_FLOAT | PARAM_PERSISTENT, clearance, &wanted.clearance, on_change)
/**
 * @brief Heading: 0 face the direction of flight, 1 keep heading, 2 turn steadily at yawRate
 */
PARAM_ADD_WITH_CALLBACK(PARAM_UINT8 | PARAM_PERSISTENT, yawMode, &wanted.yaw_mode, on_change)
/**
 * @brief Yaw rate of yawMode 2, counter-clockwise, -120 to 120 [deg/s]
 */
PARAM_ADD_WITH_CALLBACK(PARAM_FLOAT | PARAM_PERSISTENT, yawRate, &wanted.yaw_rate_dps, on_change)
/**
 * @brief Planner: 0 RRT*, 1 search on the grid
 */
PARAM_ADD_WITH_CALLBACK(PARAM_UINT8 | PARAM_PERSISTENT, planner, &wanted.planner, on_change)
/**
 * @brief SLAM: 0 off, 1 correct the map pose, 2 also feed the firmware's estimator
 */
PARAM_ADD_WITH_CALLBACK(PARAM_UINT8 | PARAM_PERSISTENT, slam, &wanted.slam, on_change)
/**
 * @brief Geofence: smallest x of the area that is explored and never left, in the map,
 * -30 to 30 [m]
 */
PARAM_ADD_WITH_CALLBACK(PARAM_FLOAT | PARAM_PERSISTENT, areaX0, &wanted.area_x0, on_change)
/**
 * @brief Smallest y of the area, -30 to 30 [m]
 */
PARAM_ADD_WITH_CALLBACK(PARAM_FLOAT | PARAM_PERSISTENT, areaY0, &wanted.area_y0, on_change)
/**
 * @brief Largest x of the area, -30 to 30 [m]
 */
PARAM_ADD_WITH_CALLBACK(PARAM_FLOAT | PARAM_PERSISTENT, areaX1, &wanted.area_x1, on_change)
/**
 * @brief Largest y of the area, -30 to 30 [m]
 */
PARAM_ADD_WITH_CALLBACK(PARAM_FLOAT | PARAM_PERSISTENT, areaY1, &wanted.area_y1, on_change)
/**
 * @brief Exploring: 0 the frontier with the best gain for its distance, 1 the nearest frontier,
 * 2 random points
 */
PARAM_ADD_WITH_CALLBACK(PARAM_UINT8 | PARAM_PERSISTENT, frontier, &wanted.frontier, on_change)
/**
 * @brief When the ground station is silent: 0 go on, 1 hold, 2 return home, 3 land
 */
PARAM_ADD_WITH_CALLBACK(PARAM_UINT8 | PARAM_PERSISTENT, lost, &wanted.lost, on_change)
/**
 * @brief Silence of the ground station after which way.lost applies, 0.5 to 600 [s]
 */
PARAM_ADD_WITH_CALLBACK(PARAM_FLOAT | PARAM_PERSISTENT, lostTime, &wanted.lost_time, on_change)
/**
 * @brief Battery voltage to be left on arrival at home, as far as can be predicted; below
 * lowBat - 0.15 the drone lands at once. 2.8 to 4.2 [V]
 */
PARAM_ADD_WITH_CALLBACK(PARAM_FLOAT | PARAM_PERSISTENT, lowBat, &wanted.low_battery, on_change)
/**
 * @brief Side of a grid cell; takes effect when the next map is made, 0.02 to 0.5 [m]
 */
PARAM_ADD_WITH_CALLBACK(PARAM_FLOAT | PARAM_PERSISTENT, cell, &wanted.cell, on_change)
/**
 * @brief The drone flies only where it has looked within this time, and stops to look elsewhere,
 * 1 to 3600 [s]
 */
PARAM_ADD_WITH_CALLBACK(PARAM_FLOAT | PARAM_PERSISTENT, lookAge, &wanted.look_age, on_change)
/**
 * @brief Distance kept from people and things that approach; 0: they are treated as walls,
 * 0 to 1.5 [m]
 */
PARAM_ADD_WITH_CALLBACK(PARAM_FLOAT | PARAM_PERSISTENT, yield, &wanted.yield, on_change)
/**
 * @brief Yaw sweep to each side while the drone hovers or flies face forward, 0 to 60 [deg]
 */
PARAM_ADD_WITH_CALLBACK(PARAM_FLOAT | PARAM_PERSISTENT, watch, &wanted.watch_deg, on_change)
/**
 * @brief The drone flies only where this much on both sides of the route was observed,
 * 0 to 0.5 [m]
 */
PARAM_ADD_WITH_CALLBACK(PARAM_FLOAT | PARAM_PERSISTENT, lookWidth, &wanted.look_width, on_change)
/**
 * @brief Turns of a spin; positive is counter-clockwise, -20 to 20 [turns]
 */
PARAM_ADD_WITH_CALLBACK(PARAM_FLOAT | PARAM_PERSISTENT, turns, &wanted.turns, on_change)
/**
 * @brief Not 0: self-test whether this drone computes the same bits as a PC, at the start and when
 * written on the ground without a map; takes some seconds. Result in log way.selfState
 */
PARAM_ADD_WITH_CALLBACK(PARAM_UINT8 | PARAM_PERSISTENT, selftest, &selftest, on_selftest)
PARAM_GROUP_STOP(way)
