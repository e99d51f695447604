// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
#include "nav.h"

#include <math.h>
#include <string.h>

#include "nav_parts.h"

enum {
  CLEARANCE_ROWS_PER_TICK = 8, ///< rows of the clearance layer that are rebuilt
  STRANGE_CELLS = 5,           ///< an echo within this of a known wall is not strange
  STRANGE_BEAMS = 2, ///< strange echoes in a set that doubt the pose: a person is on one side only
  ASTRAY = 25,       ///< excess of strange over familiar echoes at which the pose is lost
};

static const float MAPPING_HEIGHT_M = 0.2f;  ///< below, the beams see the floor
static const float ODOMETRY_MAX_M = 1000.0f; ///< larger values are garbage

void nav_init(nav_t *nav, const nav_config_t *cfg) {
  if (cfg != &nav->cfg) {
    nav->cfg = *cfg;
  }
  memset((uint8_t *)nav + sizeof nav->cfg, 0, sizeof *nav - sizeof nav->cfg);
  mission_init(&nav->mission);
  scan_init(&nav->scan, &nav->cfg.scan);
  guard_init(&nav->guard);
  mapstream_init(&nav->stream);
  nav_start_slam(nav);
  nav_make_map(nav);
}

void nav_make_map(nav_t *nav) {
  vec2_t centre_m = vec2_scale(vec2_add(nav->cfg.area_min_m, nav->cfg.area_max_m), 0.5f);
  grid_init(&nav->grid, &nav->cfg.grid, centre_m, nav->cfg.cell_m);
  clearance_init(&nav->clearance, &nav->grid, nav_clearance_m(nav), nav->cfg.area_min_m,
                 nav->cfg.area_max_m);
  seen_forget(&nav->seen);
  nav->route.count = 0;
  nav->epoch = (uint8_t)((nav->epoch + 1u) % WIRE_MAP_EPOCHS);
  nav_resend_map(nav);
}

static bool odometry_usable(const scan_odometry_t *odometry) {
  float sum = fabsf(odometry->pose.x_m) + fabsf(odometry->pose.y_m) +
              fabsf(odometry->pose.yaw_rad) + fabsf(odometry->height_m) +
              fabsf(odometry->roll_rad) + fabsf(odometry->pitch_rad);
  return sum < ODOMETRY_MAX_M;
}

/** Take the input. Odometry and battery voltage that are not usable are replaced by those of the
 *  previous tick, rates by zero. */
static void take_input(nav_t *nav, const nav_input_t *input) {
  nav_input_t before = nav->input;
  uint32_t elapsed_ms = input->odometry.time_ms - before.odometry.time_ms;
  nav->tick_s = geometry_clamp((float)elapsed_ms, 1.0f, 100.0f) * 0.001f;
  nav->input = *input;
  if (!odometry_usable(&input->odometry)) {
    nav->input.odometry = before.odometry;
    nav->input.odometry.pose = nav_estimate(nav);
    nav->input.odometry.time_ms = input->odometry.time_ms;
    nav->input.flags &= (uint8_t)~NAV_ESTIMATOR_SETTLED;
  }
  if (!(vec2_norm(input->velocity_mps) < ODOMETRY_MAX_M)) {
    nav->input.velocity_mps = (vec2_t){0.0f, 0.0f};
  }
  if (!geometry_is_finite(input->yaw_rate_rps)) {
    nav->input.yaw_rate_rps = 0.0f;
  }
  if (!geometry_is_finite(input->battery_v)) {
    nav->input.battery_v = before.battery_v;
  }
  nav->input.odometry.pose.yaw_rad = geometry_wrap_rad(nav->input.odometry.pose.yaw_rad);
}

/** Is there a map, and does the drone fly high enough that the beams do not see the floor? */
static bool may_look(const nav_t *nav) {
  return nav->mapped && mission_airborne(nav->mission.state) &&
         nav->input.odometry.height_m > MAPPING_HEIGHT_M;
}

/** Hand a measured set to relocalisation, or to SLAM and mapping. */
static void take_set(nav_t *nav, const scan_frame_t *frame) {
  if (nav->mission.state == MISSION_RELOCALISE) {
    reloc_add(&nav->reloc, frame);
  } else if (!nav->mission.lost) {
    slam_update(&nav->slam, frame);
    seen_mark(&nav->seen, &nav->grid, frame, slam_to_map(&nav->slam, frame->pose));
  }
}

static bool differ(pose2_t a, pose2_t b) {
  return a.x_m != b.x_m || a.y_m != b.y_m || a.yaw_rad != b.yaw_rad;
}

/** Run one slice of matching, or draw one pair of beams. @return true if there was something to do;
 *  planning then waits, so that the worst cases of heavy stages never meet in one tick */
static bool map_slice(nav_t *nav) {
  scan_frame_t frame;
  pose2_t map_pose = slam_pose(&nav->slam);
  if (slam_work(&nav->slam, &nav->grid)) {
    nav->matched = nav->matched || differ(map_pose, slam_pose(&nav->slam));
    return true;
  }
  if (!slam_take(&nav->slam, &frame, &map_pose)) {
    return false;
  }
  nav->grid.sweeping = nav_rests(nav) && nav->cfg.watch_rad > 0.0f;
  grid_insert(&nav->grid, &frame, map_pose);
  clearance_mark(&nav->clearance, &nav->grid);
  return true;
}

static void report(nav_t *nav) {
  nav->status.pose = nav->pose;
  nav->status.goal_m = nav->goal_m;
  nav->status.path_m = route_length_m(&nav->route);
  nav->status.known_cells = nav->grid.known;
  nav->status.confidence = nav_confidence(nav);
  nav->status.state = (uint8_t)nav->mission.state;
  nav->status.fault = (uint8_t)nav->mission.fault;
  nav->status.task = (uint8_t)nav->mission.task;
}

/** Kidnapped in flight? Strange echoes outnumber familiar ones in set after set, on two sides. */
static void doubt_place(nav_t *nav, const int *echoes) {
  mission_state_t state = nav->mission.state;
  int more = echoes[GRID_ECHO_STRANGE] - echoes[GRID_ECHO_FAMILIAR];
  bool odd = echoes[GRID_ECHO_STRANGE] >= STRANGE_BEAMS && more > 0;
  if (!odd || state == MISSION_LAND || state == MISSION_TAKEOFF) {
    nav->astray = (uint8_t)(nav->astray - (nav->astray > 0));
    return;
  }
  nav->astray = (uint8_t)(nav->astray + more);
  if (nav->astray >= ASTRAY) {
    nav->astray = 0;
    nav_fault(nav, MISSION_LOST);
    nav_lose(nav);
    nav_apply(nav, MISSION_EV_RELOCALISE);
  }
}

/** Search a set for intruders. Without a trusted map every echo is unexplained. With one, an
 *  unexplained echo counts as strange while the drone rests: it may be a person. */
static void watch_set(nav_t *nav, const scan_frame_t *frame, pose2_t map_pose) {
  uint8_t judged[SCAN_BEAMS];
  bool rests = nav_rests(nav);
  bool map = nav->slam.enabled && !nav->mission.lost;
  int echoes[GRID_ECHO_STRANGE + 1] = {0, 0, 0};
  for (int beam = 0; beam < SCAN_BEAMS; beam++) {
    vec2_t way = vec2_towards(map_pose.yaw_rad + scan_bearing_rad(beam));
    vec2_t reach_m = vec2_scale(way, frame->range_m[beam]);
    vec2_t end_m = vec2_add(pose2_position(map_pose), reach_m);
    grid_echo_t echo =
        map ? grid_classify_echo(&nav->grid, end_m, STRANGE_CELLS) : GRID_ECHO_UNEXPLAINED;
    echoes[echo] += frame->hit >> beam & 1;
    judged[beam] =
        (uint8_t)(map && rests && echo == GRID_ECHO_UNEXPLAINED ? GRID_ECHO_STRANGE : echo);
  }
  guard_watch(&nav->guard, &nav->cfg.guard, frame, judged);
  if (map) {
    doubt_place(nav, echoes);
  }
}

nav_setpoint_t nav_step(nav_t *nav, const nav_input_t *input) {
  pose2_t odometry_before = nav->input.odometry.pose;
  take_input(nav, input);
  nav_tie_frames(nav, odometry_before);

  seen_step(&nav->seen, nav_now_ms(nav), nav->cfg.look_age_s);
  scan_frame_t frame;
  bool fresh =
      scan_step(&nav->scan, &nav->input.odometry, nav->input.range_m, &frame) && may_look(nav);
  if (fresh) {
    pose2_t map_pose = slam_to_map(&nav->slam, frame.pose);
    watch_set(nav, &frame, map_pose);
    nav_check_beams(nav, &frame, map_pose);
    take_set(nav, &frame);
  }
  bool busy = fresh || map_slice(nav); // with a fresh set nav_move() checks the route: work enough
  if (!nav->mission.lost && grid_fade(&nav->grid, nav_now_ms(nav))) {
    clearance_mark(&nav->clearance, &nav->grid);
  }
  clearance_refresh(&nav->clearance, &nav->grid, CLEARANCE_ROWS_PER_TICK);
  nav->pose = slam_pose(&nav->slam);

  nav_watch(nav);
  if (nav->mission.state == MISSION_RELOCALISE) {
    nav_reloc_step(nav);
  } else if (!busy) {
    nav_plan_step(nav);
  }
  nav_setpoint_t setpoint = nav_move(nav, fresh);
  report(nav);
  return setpoint;
}

void nav_emit(nav_t *nav, wire_event_code_t code, uint8_t argument, vec2_t place_m) {
  if (nav->event_count == NAV_EVENTS) {
    nav->event_first = (uint8_t)((nav->event_first + 1u) % NAV_EVENTS);
    nav->event_count--;
  }
  nav->events[(nav->event_first + nav->event_count) % NAV_EVENTS] = (wire_event_t){
      .sequence = nav->event_sequence++,
      .time_ms = nav->input.odometry.time_ms,
      .code = (uint8_t)code,
      .argument = argument,
      .place_m = place_m,
  };
  nav->event_count++;
}

bool nav_take_event(nav_t *nav, wire_event_t *event) {
  if (nav->event_count == 0) {
    return false;
  }
  *event = nav->events[nav->event_first];
  nav->event_first = (uint8_t)((nav->event_first + 1u) % NAV_EVENTS);
  nav->event_count--;
  return true;
}

bool nav_past_event(const nav_t *nav, uint16_t sequence, wire_event_t *event) {
  uint16_t ago = (uint16_t)(nav->event_sequence - 1u - sequence);
  *event = nav->events[sequence % NAV_EVENTS]; // event n is stored at n % NAV_EVENTS
  return ago < NAV_EVENTS && event->sequence == sequence && event->code != 0;
}

wire_hello_t nav_hello(const nav_t *nav) {
  return (wire_hello_t){
      .request = 0,
      .capabilities = WIRE_CAP_RRTSTAR | WIRE_CAP_GRID_SEARCH | WIRE_CAP_SLAM | WIRE_CAP_EXPLORE,
      .epoch = nav->epoch,
      .cell_mm = (uint16_t)(nav->grid.cell_m * 1000.0f + 0.5f),
      .side_cells = GRID_SIDE_CELLS,
      .origin_m = nav->grid.origin_m,
  };
}

void nav_next_map_piece(nav_t *nav, uint8_t *bytes) {
  mapstream_next(&nav->stream, &nav->grid, nav->epoch, bytes);
}

void nav_resend_map(nav_t *nav) {
  memset(nav->grid.changed_tiles, 0xFF, sizeof nav->grid.changed_tiles);
}

void nav_resend_tiles(nav_t *nav, const wire_tiles_t *tiles) {
  for (int i = 0; i < tiles->count; i++) {
    nav->grid.changed_tiles[tiles->tiles[i] / 32] |= 1u << (tiles->tiles[i] % 32);
  }
}
