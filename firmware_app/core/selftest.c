// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
#include "selftest.h"

#include <string.h>

enum {
  TICK_MS = 20,
  SET_TICKS = 5,     ///< period of the ranges: 100 ms
  MEASURED_TICK = 1, ///< tick of that period in which they are measured: published 80 ms later
  COMMAND_TICK = 5,  ///< tick of the command to fly to GOAL_M
  LAND_TICK = 950,   ///< tick of the command to land
  READY = NAV_HAS_FLOW | NAV_HAS_RANGER | NAV_ESTIMATOR_SETTLED | NAV_CAN_FLY | NAV_LINK_ALIVE,
};

/** Expected hash. Any other decision changes it; a test (tests/core/test_selftest.py) computes the
 *  new value. */
static const uint32_t GOLDEN = 0xccf9b2fdu;

static const float TICK_S = 0.001f * (float)TICK_MS;
static const float ANSWER = 0.13f;     ///< share of the velocity error that the body removes a tick
static const float FLOW_SCALE = 1.04f; ///< odometry per metre flown
static const float RANGE_MAX_M = 3.5f; ///< no return from farther
static const float NOISE_M = 0.01f;    ///< full width of the uniform noise of a range
static const vec2_t GOAL_M = {2.0f, -0.6f};

/** A room, an inner wall with a door, and an oblique corner. */
static const struct {
  vec2_t from_m;
  vec2_t to_m;
} WALLS[] = {
    {{-0.9f, -1.3f}, {2.6f, -1.3f}}, {{2.6f, -1.3f}, {2.6f, 1.4f}}, {{2.6f, 1.4f}, {-0.9f, 1.4f}},
    {{-0.9f, 1.4f}, {-0.9f, -1.3f}}, {{1.1f, -1.3f}, {1.1f, 0.2f}}, {{1.7f, 1.4f}, {2.6f, 0.7f}},
};

enum { WALL_COUNT = sizeof WALLS / sizeof *WALLS };

/** Add to the hash, which depends on the order and on every bit. */
static void add_word(selftest_t *test, uint32_t word) {
  uint32_t turned = test->hash << 5 | test->hash >> 27;
  test->hash = (turned ^ word) * 0x01000193u; // the prime of FNV-1a
}

static void add_float(selftest_t *test, float value) {
  uint32_t bits;
  memcpy(&bits, &value, sizeof bits);
  add_word(test, bits);
}

static void add_point(selftest_t *test, vec2_t point) {
  add_float(test, point.x);
  add_float(test, point.y);
}

static float cross(vec2_t a, vec2_t b) {
  return a.x * b.y - a.y * b.x;
}

/** Distance to the first wall along a ray; RANGE_MAX_M without any. */
static float cast(vec2_t from_m, float bearing_rad) {
  vec2_t beam = vec2_towards(bearing_rad);
  float nearest_m = RANGE_MAX_M;
  for (int i = 0; i < WALL_COUNT; i++) {
    vec2_t wall = vec2_sub(WALLS[i].to_m, WALLS[i].from_m);
    vec2_t offset = vec2_sub(WALLS[i].from_m, from_m);
    float slope = cross(beam, wall);
    if (slope == 0.0f) {
      continue;
    }
    float range_m = cross(offset, wall) / slope;
    float share = cross(offset, beam) / slope;
    if (range_m > 0.0f && range_m < nearest_m && share >= 0.0f && share <= 1.0f) {
      nearest_m = range_m;
    }
  }
  return nearest_m;
}

/** Range of a beam; negative: no return. */
static float measure(selftest_t *test, int beam) {
  float bearing_rad = test->pose.yaw_rad + scan_bearing_rad(beam);
  float range_m = cast(pose2_position(test->pose), bearing_rad);
  float noise_m = (rng_uniform(&test->noise) - 0.5f) * NOISE_M;
  return range_m < RANGE_MAX_M ? range_m + noise_m : -1.0f;
}

/** Advance the time; measure ranges once a period and publish them later, as the ranger does. */
static void sense(selftest_t *test) {
  test->input.odometry.time_ms = (uint32_t)test->ticks * TICK_MS;
  int phase = test->ticks % SET_TICKS;
  for (int beam = 0; beam < SCAN_BEAMS; beam++) {
    if (phase == MEASURED_TICK) {
      test->measured_m[beam] = measure(test, beam);
    } else if (phase == 0) {
      test->input.range_m[beam] = test->measured_m[beam];
    }
  }
}

/** The body follows the setpoint with a lag, and odometry follows the body. */
static void move(selftest_t *test, const nav_setpoint_t *setpoint) {
  scan_odometry_t *odometry = &test->input.odometry;
  vec2_t asked = vec2_rotate(setpoint->velocity_body_mps, test->pose.yaw_rad);
  vec2_t *velocity = &test->input.velocity_mps;
  if (!setpoint->motors) {
    *velocity = (vec2_t){0.0f, 0.0f};
    odometry->height_m = 0.0f;
    return;
  }
  *velocity = vec2_add(*velocity, vec2_scale(vec2_sub(asked, *velocity), ANSWER));
  vec2_t moved = vec2_scale(*velocity, TICK_S);
  test->pose.x_m += moved.x;
  test->pose.y_m += moved.y;
  test->pose.yaw_rad = geometry_wrap_rad(test->pose.yaw_rad + setpoint->yaw_rate_rps * TICK_S);
  odometry->pose.x_m += moved.x * FLOW_SCALE;
  odometry->pose.y_m += moved.y * FLOW_SCALE;
  odometry->pose.yaw_rad = test->pose.yaw_rad;
  odometry->height_m += (setpoint->height_m - odometry->height_m) * ANSWER;
}

static void command(selftest_t *test) {
  if (test->ticks == COMMAND_TICK) {
    add_word(test, nav_command(test->nav, &(nav_command_t){MISSION_CMD_GOTO, GOAL_M}));
  } else if (test->ticks == LAND_TICK) {
    add_word(test, nav_command(test->nav, &(nav_command_t){.cmd = MISSION_CMD_LAND}));
  }
}

/** Hash the decisions of this tick. */
static void add_tick(selftest_t *test, const nav_setpoint_t *setpoint) {
  const nav_t *nav = test->nav;
  add_word(test, setpoint->motors ? 1u : 0u);
  add_float(test, setpoint->height_m);
  add_point(test, setpoint->velocity_body_mps);
  add_float(test, setpoint->yaw_rate_rps);
  add_point(test, pose2_position(nav->pose));
  add_float(test, nav->pose.yaw_rad);
  add_word(test, (uint32_t)nav->mission.state);
  add_word(test, (uint32_t)nav->plan.stage);
  add_word(test, nav->status.plan_nodes);
}

static void add_route(selftest_t *test) {
  const route_t *route = &test->nav->route;
  if (route->revision == test->revision) {
    return;
  }
  test->revision = route->revision;
  for (int i = 0; i < route->count; i++) {
    add_point(test, route->points_m[i]);
  }
}

static void add_map(selftest_t *test) {
  const grid_t *grid = &test->nav->grid;
  add_word(test, grid->known);
  for (int i = 0; i < GRID_CELLS / 8; i++) {
    add_word(test, grid->cells[i]);
  }
  for (int i = 0; i < GRID_POINTS; i++) {
    add_word(test, grid->points[i]);
  }
}

void selftest_start(selftest_t *test, nav_t *nav) {
  memset(test, 0, sizeof *test);
  test->nav = nav;
  test->state = SELFTEST_RUNNING;
  test->noise = rng_seed(1u);
  test->input.battery_v = 4.0f;
  test->input.flags = READY;
  for (int beam = 0; beam < SCAN_RANGES; beam++) {
    test->input.range_m[beam] = -1.0f;
  }
  nav_config_default(&nav->cfg);
  nav->cfg.watch_rad = 0.0f; // it sees less on the way, so it has to stop, look and replan
  nav_init(nav, &nav->cfg);
}

bool selftest_step(selftest_t *test, int ticks) {
  for (int i = 0; i < ticks && test->state == SELFTEST_RUNNING; i++) {
    sense(test);
    command(test);
    nav_setpoint_t setpoint = nav_step(test->nav, &test->input);
    add_tick(test, &setpoint);
    add_route(test);
    move(test, &setpoint);
    if (++test->ticks == SELFTEST_TICKS) {
      add_map(test);
      test->state = test->hash == GOLDEN ? SELFTEST_AGREES : SELFTEST_DIFFERS;
    }
  }
  return test->state != SELFTEST_RUNNING;
}

uint32_t selftest_golden(void) {
  return GOLDEN;
}
