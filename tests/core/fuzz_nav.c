// SPDX-License-Identifier: GPL-3.0-or-later
/* Feeds nav with odometry, ranges, commands and configurations of which many are absurd, for
 * `fuzz_nav SEED TICKS`, and stops with status 1 at an output that no vehicle should get. Compiled
 * with the address and undefined-behaviour sanitizers, which stop at everything else. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "nav.h"
#include "nav_parts.h"
#include "rng.h"

static rng_t rng;

static int pick(int count) {
  return (int)(rng_uniform(&rng) * (float)count);
}

static float between(float low, float high) {
  return low + (high - low) * rng_uniform(&rng);
}

static float absurd(void) {
  static const float values[] = {NAN, INFINITY, -INFINITY, 1e30f, -1e30f, 3.4e38f, 1e-40f, -0.0f};
  return values[pick((int)(sizeof values / sizeof values[0]))];
}

/** Mostly in range, sometimes anything. */
static float some(float low, float high, int one_in) {
  return pick(one_in) == 0 ? absurd() : between(low, high);
}

static void wander(nav_input_t *input) {
  scan_odometry_t *o = &input->odometry;
  o->time_ms += pick(200) == 0 ? rng_next(&rng) : 20u;
  o->pose.x_m = pick(400) == 0 ? absurd() : o->pose.x_m + between(-0.02f, 0.02f);
  o->pose.y_m = pick(400) == 0 ? absurd() : o->pose.y_m + between(-0.02f, 0.02f);
  o->pose.yaw_rad = pick(400) == 0 ? absurd() : o->pose.yaw_rad + between(-0.02f, 0.06f);
  if (!(fabsf(o->pose.x_m) < 4.0f && fabsf(o->pose.y_m) < 4.0f && fabsf(o->pose.yaw_rad) < 99.0f)) {
    o->pose = pick(3) == 0 ? o->pose : (pose2_t){0.0f, 0.0f, 0.0f};
  }
  o->height_m = some(0.0f, 0.5f, 500);
  o->roll_rad = some(-0.2f, 0.2f, 500);
  o->pitch_rad = some(-0.2f, 0.2f, 500);
  input->velocity_mps = (vec2_t){some(-0.5f, 0.5f, 300), some(-0.5f, 0.5f, 300)};
  for (int i = 0; i < SCAN_RANGES && pick(3) == 0; i++) {
    input->range_m[i] = pick(5) == 0 ? -1.0f : some(0.0f, 4.0f, 50);
  }
  input->battery_v = some(3.5f, 4.2f, 800);
  uint8_t good =
      NAV_HAS_FLOW | NAV_HAS_RANGER | NAV_ESTIMATOR_SETTLED | NAV_CAN_FLY | NAV_LINK_ALIVE;
  input->flags = pick(1500) == 0 ? (uint8_t)pick(256) : good;
}

static void reconfigure(nav_t *nav) {
  nav_config_t cfg;
  nav_config_default(&cfg);
  cfg.height_m = some(0.2f, 1.0f, 4);
  cfg.clearance_m = some(0.08f, 0.5f, 4);
  cfg.cell_m = some(0.02f, 0.5f, 4);
  cfg.area_min_m = (vec2_t){some(-30.0f, 0.0f, 6), some(-30.0f, 0.0f, 6)};
  cfg.area_max_m = (vec2_t){some(0.0f, 30.0f, 6), some(0.0f, 30.0f, 6)};
  cfg.planner = (nav_planner_t)pick(3);
  cfg.slam = (nav_slam_mode_t)pick(4);
  cfg.lost = (nav_lost_t)pick(5);
  cfg.follower.yaw_mode = (follower_yaw_mode_t)pick(4);
  cfg.follower.speed_mps = some(0.05f, 1.0f, 6);
  if (pick(2) == 0) {
    nav_config_default(&cfg);
  }
  nav_configure(nav, &cfg);
}

/** Its own map comes back, sometimes damaged. */
static void give_map(nav_t *nav) {
  uint8_t piece[WIRE_MAP_BYTES];
  nav_next_map_piece(nav, piece);
  if (pick(4) == 0) {
    piece[pick(WIRE_MAP_BYTES)] ^= (uint8_t)(1 << pick(8));
  }
  nav_take_map_piece(nav, piece);
}

static void disturb(nav_t *nav) {
  if (pick(100) == 0) {
    give_map(nav);
  }
  if (pick(40) == 0) {
    nav_command_t command = {(mission_cmd_t)pick(12), {some(-3.3f, 3.3f, 8), some(-3.3f, 3.3f, 8)}};
    nav_command(nav, &command);
  }
  if (pick(300) == 0) {
    reconfigure(nav);
  }
}

static bool sane(const nav_t *nav, const nav_setpoint_t *setpoint) {
  float speed_mps = vec2_norm(setpoint->velocity_body_mps);
  float yield_mps = nav->cfg.guard.yield_mps;
  float most_mps =
      nav->cfg.follower.speed_mps > yield_mps ? nav->cfg.follower.speed_mps : yield_mps;
  if (nav->estimate_good_ms != nav->input.odometry.time_ms) {
    most_mps += GUARD_SLIP_MPS;
  }
  return geometry_is_finite(setpoint->height_m) && geometry_is_finite(setpoint->yaw_rate_rps) &&
         fabsf(setpoint->yaw_rate_rps) < 4.0f && setpoint->height_m >= 0.0f &&
         speed_mps <= most_mps * 1.001f &&
         setpoint->motors == mission_airborne(nav->mission.state) &&
         geometry_is_finite(nav->status.pose.x_m) && geometry_is_finite(nav->status.pose.y_m) &&
         geometry_is_finite(nav->status.pose.yaw_rad) && geometry_is_finite(nav->status.path_m);
}

int main(int argc, char **argv) {
  static nav_t nav; // as in the firmware: too large for a stack
  nav_config_t cfg;
  nav_config_default(&cfg);
  nav_input_t input;
  uint8_t piece[WIRE_MAP_BYTES];
  uint32_t seen_states = 0;
  if (argc != 3) {
    return 2;
  }
  rng = rng_seed((uint32_t)atoi(argv[1]));
  memset(&input, 0, sizeof input);
  nav_init(&nav, &cfg);
  for (int tick = 0; tick < atoi(argv[2]); tick++) {
    wander(&input);
    disturb(&nav);
    nav_setpoint_t setpoint = nav_step(&nav, &input);
    if (!sane(&nav, &setpoint)) {
      printf("tick %d: state %d, height %g, velocity %g %g, yaw rate %g\n", tick, nav.mission.state,
             (double)setpoint.height_m, (double)setpoint.velocity_body_mps.x,
             (double)setpoint.velocity_body_mps.y, (double)setpoint.yaw_rate_rps);
      return 1;
    }
    seen_states |= 1u << nav.mission.state;
    wire_event_t event;
    while (pick(3) == 0 && nav_take_event(&nav, &event)) {
    }
    nav_next_map_piece(&nav, piece);
  }
  printf("%x\n", seen_states);
  return 0;
}
