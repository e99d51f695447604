// SPDX-License-Identifier: GPL-3.0-or-later
/* Flies nav in a box-shaped room by a small language: bytes move the drone, lie to it, command it,
 * configure it and let time pass. No output may ever be absurd. */
#include "bytes.h"
#include "nav.h"
#include "nav_parts.h"

static const float HEIGHT_MAX_M = 2.0f; ///< of nav_config_check
static const float ROUNDING = 1.0001f;

enum { TICKS_MAX = 4000 }; ///< of one input: a flight of 80 s at the usual rate

/** The drone as it would be, and what it is told. */
typedef struct {
  nav_t nav;
  nav_input_t input;
  nav_setpoint_t setpoint;
  float room_x_m, room_y_m; ///< half the sides of the room
  uint32_t tick_ms;
  uint32_t noise;
  int ticks_left;
  uint16_t event_sequence; ///< of the next event, or later
  bool sees;               ///< ranges are those of the room
} drone_t;

static drone_t drone; // too large for a stack

static bool finite2(vec2_t v) {
  return geometry_is_finite(v.x) && geometry_is_finite(v.y);
}

static void check_setpoint(const nav_t *nav, const nav_setpoint_t *setpoint) {
  const follower_config_t *cfg = &nav->cfg.follower;
  float rate_rps =
      fmaxf(fmaxf(cfg->yaw_rate_max_rps, fabsf(cfg->turn_rate_rps)), nav->cfg.scan_rate_rps);
  REQUIRE(setpoint->motors == mission_airborne(nav->mission.state));
  REQUIRE(finite2(setpoint->velocity_body_mps));
  bool unsure = nav->estimate_good_ms != nav->input.odometry.time_ms;
  float most_mps = fmaxf(cfg->speed_mps, nav->cfg.guard.yield_mps) + (unsure ? GUARD_SLIP_MPS : 0);
  REQUIRE(vec2_norm(setpoint->velocity_body_mps) <= most_mps * ROUNDING);
  REQUIRE(fabsf(setpoint->yaw_rate_rps) <= rate_rps * ROUNDING);
  REQUIRE(setpoint->height_m >= 0.0f && setpoint->height_m <= HEIGHT_MAX_M);
}

static void check_status(const nav_t *nav) {
  const nav_status_t *status = &nav->status;
  REQUIRE(status->state < MISSION_STATES && status->fault < MISSION_REASONS);
  REQUIRE(status->task <= MISSION_TASK_PATROL && status->confidence <= 100);
  REQUIRE(status->known_cells <= GRID_CELLS && status->plan_nodes <= TREE_NODES);
  REQUIRE(finite2(pose2_position(status->pose)) && finite2(status->goal_m));
  REQUIRE(fabsf(status->pose.yaw_rad) <= 3.1416f);
  REQUIRE(status->path_m >= 0.0f && geometry_is_finite(status->path_m));
  REQUIRE(nav->route.count <= ROUTE_POINTS);
  for (int i = 0; i < nav->route.count; i++) {
    REQUIRE(finite2(nav->route.points_m[i]));
  }
}

static void check_event(const wire_event_t *event) {
  static const uint8_t limit[] = {
      [WIRE_EVENT_STATE] = MISSION_STATES,
      [WIRE_EVENT_REFUSED] = MISSION_REASONS,
      [WIRE_EVENT_FAULT] = MISSION_REASONS,
      [WIRE_EVENT_ARRIVED] = MISSION_TASK_PATROL + 1,
      [WIRE_EVENT_EXPLORED] = 2,
      [WIRE_EVENT_FOUND] = 1,
      [WIRE_EVENT_WAYPOINT] = NAV_WAYPOINTS,
      [WIRE_EVENT_SKIPPED] = MISSION_REASONS,
  };
  REQUIRE(event->code >= WIRE_EVENT_STATE && event->code <= WIRE_EVENT_SKIPPED);
  REQUIRE(event->argument < limit[event->code]);
  REQUIRE(finite2(event->place_m));
  REQUIRE((int16_t)(uint16_t)(event->sequence - drone.event_sequence) >= 0);
  drone.event_sequence = (uint16_t)(event->sequence + 1u);
}

static void take_events(void) {
  wire_event_t event;
  for (int i = 0; i < NAV_EVENTS && nav_take_event(&drone.nav, &event); i++) {
    check_event(&event);
  }
  REQUIRE(!nav_take_event(&drone.nav, &event));
}

static void take_map_piece(uint8_t *piece) {
  uint8_t epoch;
  wire_map_t map;
  wire_tile_t tile;
  nav_next_map_piece(&drone.nav, piece);
  REQUIRE(wire_map_open(&map, piece, &epoch) && wire_map_read(&map, &tile));
  REQUIRE(epoch == drone.nav.epoch);
}

/** A piece of its own map comes back, with some bits turned. */
static void give_map_piece(bytes_t *bytes) {
  uint8_t piece[WIRE_MAP_BYTES];
  take_map_piece(piece);
  piece[take_below(bytes, WIRE_MAP_BYTES)] ^= take_u8(bytes);
  REQUIRE(!nav_take_map_piece(&drone.nav, piece) || !mission_airborne(drone.nav.mission.state));
}

/** From inside along a direction to the walls. */
static float to_wall_m(float at_m, float half_m, float direction) {
  return fabsf(direction) > 1e-3f ? (half_m - (direction > 0.0f ? at_m : -at_m)) / fabsf(direction)
                                  : 100.0f;
}

static void look(void) {
  const pose2_t pose = drone.input.odometry.pose;
  for (int beam = 0; beam < SCAN_BEAMS; beam++) {
    sincos_t way = geometry_sincos(pose.yaw_rad + scan_bearing_rad(beam));
    float range_m = fminf(to_wall_m(pose.x_m, drone.room_x_m, way.cos),
                          to_wall_m(pose.y_m, drone.room_y_m, way.sin));
    drone.noise = drone.noise * 1664525u + 1013904223u;
    range_m += (float)(drone.noise >> 24) * 1e-5f;
    drone.input.range_m[beam] = range_m > 0.0f && range_m < 4.0f ? range_m : -1.0f;
  }
}

/** A perfect vehicle: it does at once what it is told. */
static void move(void) {
  scan_odometry_t *o = &drone.input.odometry;
  float elapsed_s = 0.001f * (float)(drone.tick_ms < 100u ? drone.tick_ms : 100u);
  o->time_ms += drone.tick_ms;
  if (!drone.setpoint.motors) {
    return;
  }
  drone.input.velocity_mps = vec2_rotate(drone.setpoint.velocity_body_mps, o->pose.yaw_rad);
  o->pose.x_m += elapsed_s * drone.input.velocity_mps.x;
  o->pose.y_m += elapsed_s * drone.input.velocity_mps.y;
  o->pose.yaw_rad += elapsed_s * drone.setpoint.yaw_rate_rps;
  o->height_m = drone.setpoint.height_m;
}

static void step(int ticks) {
  for (int i = 0; i < ticks && drone.ticks_left > 0; i++) {
    drone.ticks_left--;
    move();
    if (drone.sees) {
      look();
    }
    drone.setpoint = nav_step(&drone.nav, &drone.input);
    check_setpoint(&drone.nav, &drone.setpoint);
    check_status(&drone.nav);
  }
}

static void lie(bytes_t *bytes) {
  scan_odometry_t *o = &drone.input.odometry;
  switch (take_below(bytes, 10)) {
  case 0:
    o->pose.x_m = take_float(bytes, -5.0f, 5.0f);
    break;
  case 1:
    o->pose.y_m = take_float(bytes, -5.0f, 5.0f);
    break;
  case 2:
    o->pose.yaw_rad = take_float(bytes, -7.0f, 7.0f);
    break;
  case 3:
    o->height_m = take_float(bytes, -0.1f, 2.0f);
    break;
  case 4:
    o->roll_rad = take_float(bytes, -0.5f, 0.5f);
    break;
  case 5:
    o->pitch_rad = take_float(bytes, -0.5f, 0.5f);
    break;
  case 6:
    drone.input.velocity_mps.x = take_float(bytes, -1.0f, 1.0f);
    break;
  case 7:
    drone.input.velocity_mps.y = take_float(bytes, -1.0f, 1.0f);
    break;
  case 8:
    drone.input.battery_v = take_float(bytes, 2.8f, 4.2f);
    break;
  default:
    o->time_ms = take_u32(bytes);
    break;
  }
}

static void configure(bytes_t *bytes) {
  nav_config_t cfg = drone.nav.cfg;
  switch (take_below(bytes, 14)) {
  case 0:
    cfg.height_m = take_float(bytes, 0.2f, 2.0f);
    break;
  case 1:
    cfg.clearance_m = take_float(bytes, 0.08f, 0.5f);
    break;
  case 2:
    cfg.cell_m = take_float(bytes, 0.02f, 0.5f);
    break;
  case 3:
    cfg.area_min_m.x = take_float(bytes, -30.0f, 30.0f);
    break;
  case 4:
    cfg.area_min_m.y = take_float(bytes, -30.0f, 30.0f);
    break;
  case 5:
    cfg.area_max_m.x = take_float(bytes, -30.0f, 30.0f);
    break;
  case 6:
    cfg.area_max_m.y = take_float(bytes, -30.0f, 30.0f);
    break;
  case 7:
    cfg.low_battery_v = take_float(bytes, 2.8f, 4.2f);
    break;
  case 8:
    cfg.lost_time_s = take_float(bytes, 0.5f, 600.0f);
    break;
  case 9:
    cfg.follower.speed_mps = take_float(bytes, 0.05f, 1.0f);
    break;
  case 10:
    cfg.follower.turn_rate_rps = take_float(bytes, -2.0f, 2.0f);
    break;
  case 11:
    cfg.planner = (nav_planner_t)take_below(bytes, NAV_PLANNERS + 1);
    cfg.slam = (nav_slam_mode_t)take_below(bytes, NAV_SLAM_MODES + 1);
    break;
  case 12:
    cfg.lost = (nav_lost_t)take_below(bytes, NAV_LOST_POLICIES + 1);
    break;
  default:
    cfg.follower.yaw_mode = (follower_yaw_mode_t)take_below(bytes, FOLLOWER_YAW_MODES + 1);
    break;
  }
  REQUIRE(nav_configure(&drone.nav, &cfg) == nav_config_check(&cfg));
}

static void command(bytes_t *bytes) {
  nav_command_t order;
  order.cmd = (mission_cmd_t)take_below(bytes, MISSION_CMDS + 2);
  order.goal_m.x = take_float(bytes, -3.3f, 3.3f);
  order.goal_m.y = take_float(bytes, -3.3f, 3.3f);
  REQUIRE(nav_command(&drone.nav, &order) < MISSION_REASONS);
}

/** What is no number, or too much, must not come through. */
static void steer(bytes_t *bytes) {
  wire_steer_t stick;
  stick.sequence = take_u8(bytes);
  stick.velocity_mps.x = take_float(bytes, -1.2f, 1.2f);
  stick.velocity_mps.y = take_float(bytes, -1.2f, 1.2f);
  stick.yaw_rate_rps = take_float(bytes, -1.2f, 1.2f);
  stick.climb_mps = take_float(bytes, -1.2f, 1.2f);
  mission_reason_t reason = nav_steer(&drone.nav, &stick);
  REQUIRE(reason < MISSION_REASONS);
  bool usable = finite2(stick.velocity_mps) && geometry_is_finite(stick.yaw_rate_rps) &&
                geometry_is_finite(stick.climb_mps);
  REQUIRE(usable || reason == MISSION_BAD_VALUE);
  REQUIRE(reason != MISSION_OK || mission_airborne(drone.nav.mission.state));
  REQUIRE(finite2(drone.nav.stick.velocity_mps));
}

static void interpret(bytes_t *bytes) {
  switch (take_below(bytes, 13)) {
  case 0:
    lie(bytes);
    break;
  case 1:
    configure(bytes);
    break;
  case 2:
    command(bytes);
    break;
  case 3: // something near
    drone.sees = false;
    drone.input.range_m[take_below(bytes, SCAN_RANGES)] = take_float(bytes, -0.1f, 3.0f);
    break;
  case 4:
    drone.sees = true;
    drone.room_x_m = take_between(bytes, 0.3f, 5.0f);
    drone.room_y_m = take_between(bytes, 0.3f, 5.0f);
    break;
  case 5:
    drone.input.flags ^= (uint8_t)(1u << take_below(bytes, 8));
    break;
  case 6:
    drone.tick_ms = take_u8(bytes);
    break;
  case 7:
    take_events();
    break;
  case 11:
    give_map_piece(bytes);
    break;
  case 12:
    steer(bytes);
    break;
  default:
    step(1 + take_u8(bytes));
    break;
  }
}

static void begin(void) {
  nav_config_t cfg;
  nav_config_default(&cfg);
  memset(&drone, 0, sizeof drone);
  nav_init(&drone.nav, &cfg);
  drone.input.battery_v = 4.1f;
  drone.input.flags =
      NAV_HAS_FLOW | NAV_HAS_RANGER | NAV_ESTIMATOR_SETTLED | NAV_CAN_FLY | NAV_LINK_ALIVE;
  drone.input.range_m[SCAN_UP] = -1.0f;
  drone.tick_ms = 20u;
  drone.ticks_left = TICKS_MAX;
  drone.room_x_m = 2.6f;
  drone.room_y_m = 1.9f;
  drone.sees = true;
}

/** Bookkeeping that single steps cannot afford to check. */
static void check_map(const grid_t *grid) {
  int known = 0;
  for (int i = 0; i < GRID_CELLS; i++) {
    known += grid_state(grid, i % GRID_SIDE_CELLS, i / GRID_SIDE_CELLS) != GRID_CELL_UNKNOWN;
  }
  REQUIRE(grid->known == known);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  bytes_t bytes = {data, size};
  begin();
  step(2);
  while (bytes.left > 0 && drone.ticks_left > 0) {
    interpret(&bytes);
  }
  take_events();
  check_map(&drone.nav.grid);
  return 0;
}
