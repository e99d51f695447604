// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
/* What flights meet rarely, over many inputs: one line for each part, with a hash over every
 * result. */
#include <string.h>

#include "bits.h"
#include "nav.h"
#include "port.h"
#include "ray.h"

enum { PATTERNS = 4000, MAPS = 6, WALLS = 40, BUDGET = 1500, FRAMES = 40 };

static grid_t grid;
static clearance_t clearance;
static wavefront_t wave;
static pathfinder_t planner;
static lattice_t way[ROUTE_POINTS];
static route_t route;

static void tell(const char *name, uint32_t hash) {
  char line[] = " 00000000\n";
  for (int i = 0; i < 8; i++) {
    line[8 - i] = "0123456789abcdef"[hash >> (4 * i) & 15u];
  }
  port_write(name, strlen(name));
  port_write(line, sizeof line - 1);
}

/** Any float there is: zeros, denormals, infinities and NaN among them. */
static float any_float(rng_t *rng) {
  uint32_t bits = rng_next(rng);
  float value;
  if ((bits & 15u) == 0u) {
    bits &= 0x807FFFFFu;
  } else if ((bits & 15u) == 1u) {
    bits |= 0x7F800000u;
  }
  memcpy(&value, &bits, sizeof value);
  return value;
}

static float between(rng_t *rng, float low, float high) {
  float share = rng_uniform(rng);
  return low + share * (high - low);
}

static vec2_t place(rng_t *rng, float low, float high) {
  float x = between(rng, low, high);
  return (vec2_t){x, between(rng, low, high)};
}

static pose2_t pose(rng_t *rng, float reach_m) {
  vec2_t at = place(rng, -reach_m, reach_m);
  return (pose2_t){at.x, at.y, between(rng, -3.2f, 3.2f)};
}

static void random_numbers(void) {
  uint32_t hash = BITS_HASH_START;
  for (uint32_t seed = 0; seed < 50u; seed++) {
    rng_t rng = rng_seed(seed);
    for (int i = 0; i < 50; i++) {
      hash = bits_hash_u32(hash, rng_next(&rng));
      hash = bits_hash_float(hash, rng_uniform(&rng));
    }
  }
  tell("rng", hash);
}

static void angles(void) {
  rng_t rng = rng_seed(1);
  uint32_t hash = BITS_HASH_START;
  for (int i = 0; i < PATTERNS; i++) {
    sincos_t near = geometry_sincos(between(&rng, -7.0f, 7.0f));
    sincos_t far = geometry_sincos(between(&rng, -1000.0f, 1000.0f));
    hash = bits_hash_vec2(hash, (vec2_t){near.sin, near.cos});
    hash = bits_hash_vec2(hash, (vec2_t){far.sin, far.cos});
    float y = any_float(&rng);
    hash = bits_hash_float(hash, geometry_atan2(y, any_float(&rng)));
    vec2_t v = place(&rng, -9.0f, 9.0f);
    hash = bits_hash_float(hash, geometry_atan2(v.y, v.x));
    hash = bits_hash_float(hash, geometry_wrap_rad(between(&rng, -100.0f, 100.0f)));
    hash = bits_hash_float(hash, geometry_wrap_rad(any_float(&rng)));
  }
  tell("angles", hash);
}

static void vectors(void) {
  rng_t rng = rng_seed(2);
  uint32_t hash = BITS_HASH_START;
  for (int i = 0; i < PATTERNS; i++) {
    vec2_t a = {any_float(&rng), 0.0f};
    a.y = any_float(&rng);
    vec2_t b = place(&rng, -5.0f, 5.0f);
    hash = bits_hash_vec2(bits_hash_vec2(hash, vec2_add(a, b)), vec2_limit(a, 1.0f));
    hash = bits_hash_float(bits_hash_float(hash, vec2_dot(a, b)), vec2_distance(a, b));
    hash = bits_hash_u32(hash, geometry_is_finite(a.x));
    hash = bits_hash_float(hash, geometry_clamp(a.x, -1.0f, 1.0f));
    pose2_t p = pose(&rng, 5.0f);
    pose2_t q = pose2_compose(pose2_inverse(p), pose(&rng, 5.0f));
    hash = bits_hash_float(bits_hash_vec2(hash, pose2_position(q)), q.yaw_rad);
    hash = bits_hash_float(hash, pose2_interpolate(p, q, 0.3f).yaw_rad);
  }
  tell("vectors", hash);
}

static void packets(void) {
  rng_t rng = rng_seed(3);
  uint32_t hash = BITS_HASH_START;
  for (int i = 0; i < PATTERNS; i++) {
    uint8_t bytes[WIRE_PACKET_BYTES];
    for (int k = 0; k < WIRE_PACKET_BYTES; k++) {
      bytes[k] = (uint8_t)rng_next(&rng);
    }
    bytes[0] = WIRE_VERSION;
    bytes[1] = (uint8_t)(1u + rng_next(&rng) % 7u);
    for (int length = 0; length <= WIRE_PACKET_BYTES; length++) {
      wire_message_t message;
      if (wire_decode(bytes, length, &message) == WIRE_OK) {
        uint8_t again[WIRE_PACKET_BYTES] = {0};
        int used = wire_encode(&message, again);
        for (int k = 0; k < used; k++) {
          hash = bits_hash_u32(hash, again[k]);
        }
      }
    }
  }
  tell("wire", hash);
}

/** Walls at any angle, as a drone would see them that turns at random places. */
static void draw_room(uint32_t seed) {
  rng_t rng = rng_seed(seed);
  grid_config_t cfg = grid_config_default();
  grid_init(&grid, &cfg, (vec2_t){0.0f, 0.0f}, 0.05f);
  for (int i = 0; i < FRAMES; i++) {
    scan_frame_t frame = {.hit = (uint8_t)(rng_next(&rng) & 15u)};
    frame.clear = (uint8_t)(~frame.hit & 15u);
    for (int beam = 0; beam < SCAN_BEAMS; beam++) {
      frame.range_m[beam] = between(&rng, 0.1f, 4.0f);
    }
    grid_insert(&grid, &frame, pose(&rng, 2.5f));
  }
  for (int i = 0; i < WALLS; i++) {
    vec2_t from = place(&rng, 4.0f, 124.0f);
    ray_t ray = ray_start(from, place(&rng, 4.0f, 124.0f));
    for (int k = 0; k < 24; k++) {
      grid_set_value(&grid, ray.ix, ray.iy, 12);
      if (!ray_next(&ray)) {
        break;
      }
    }
  }
  clearance_init(&clearance, &grid, 0.17f, (vec2_t){-3.1f, -3.1f}, (vec2_t){3.1f, 3.1f});
  clearance_mark(&clearance, &grid);
  clearance_refresh(&clearance, &grid, GRID_SIDE_CELLS);
}

static bool free_place(rng_t *rng, vec2_t *cells) {
  return clearance_nearest_free(&clearance, place(rng, 8.0f, 120.0f), 12, cells);
}

static uint32_t hash_route(uint32_t hash, int count) {
  if (count >= 2) {
    route_build(&route, &grid, &clearance, count);
    hash = bits_hash_u32(hash, bits_hash_route(&route));
    hash = bits_hash_float(hash, route_length_m(&route));
    hash = bits_hash_float(hash, route_clear_m(&route, &grid, &clearance, 0.1f));
    hash = bits_hash_float(hash, route_known_m(&route, &grid, 0.1f, 0.1f, 100.0f));
  }
  return hash;
}

static uint32_t hash_wave(uint32_t hash, vec2_t start, vec2_t goal, int slice) {
  wavefront_start(&wave, WAVEFRONT_TO_CELL, (grid_cell_t){(int)start.x, (int)start.y},
                  (grid_cell_t){(int)goal.x, (int)goal.y});
  while (wavefront_extend(&wave, &clearance, &grid, slice) == WAVEFRONT_RUNNING) {
  }
  int count = WAVEFRONT_WALKING;
  while (count == WAVEFRONT_WALKING) {
    count = wavefront_path(&wave, &clearance, way, ROUTE_POINTS, slice);
  }
  for (int i = 0; i < count; i++) {
    route.points_m[i] = lattice_to_cells(way[i]);
  }
  hash = bits_hash_u32(bits_hash_u32(hash, wave.waves), (uint32_t)wave.status);
  return hash_route(hash, count);
}

static uint32_t hash_tree(uint32_t hash, const tree_t *tree) {
  for (int i = 0; i < tree->count; i++) {
    const tree_node_t *node = &tree->nodes[i];
    hash = bits_hash_u32(hash, (uint32_t)node->at.x << 16 | (uint32_t)node->at.y);
    hash = bits_hash_float(bits_hash_u32(hash, (uint32_t)node->parent), node->cost_cells);
  }
  return hash;
}

/** The best way, and the tree that looks for a better one. */
static uint32_t hash_planner(uint32_t hash) {
  for (int i = 0; i < BUDGET; i += 7) {
    pathfinder_extend(&planner, &clearance, &grid, 7);
  }
  hash = bits_hash_u32(bits_hash_u32(hash, (uint32_t)planner.status), planner.samples);
  hash = planner.grown ? hash_tree(hash, &planner.search.rrt.tree) : hash;
  return hash_route(hash, pathfinder_path(&planner, route.points_m, ROUTE_POINTS));
}

/** A way, the way round what then stands in it, and the way to what is not known. */
static uint32_t hash_plans(uint32_t hash, vec2_t start, vec2_t goal, uint32_t seed) {
  pathfinder_config_t cfg = pathfinder_config_default();
  pathfinder_start(&planner, &cfg, &clearance, start, goal, seed);
  hash = hash_planner(hash);
  if (planner.path_count > 2) {
    vec2_t at = lattice_to_cells(planner.path[1]);
    grid_set_value(&grid, (int)at.x, (int)at.y, GRID_VALUE_MAX);
    clearance_mark(&clearance, &grid);
    clearance_refresh(&clearance, &grid, GRID_SIDE_CELLS);
    pathfinder_repair(&planner, &clearance, start);
    hash = hash_planner(hash);
  }
  for (int mode = FRONTIER_GAIN; mode < FRONTIER_MODES; mode++) {
    frontier_vain_t vain = {.count = 0};
    pathfinder_start_frontier(&planner, &cfg, &clearance, start, (frontier_mode_t)mode, &vain,
                              goal);
    hash = hash_planner(hash);
  }
  return hash;
}

static void rooms(void) {
  uint32_t drawn = BITS_HASH_START;
  uint32_t waves = BITS_HASH_START;
  uint32_t plans = BITS_HASH_START;
  for (uint32_t seed = 0; seed < MAPS; seed++) {
    rng_t rng = rng_seed(100u + seed);
    vec2_t start;
    vec2_t goal;
    draw_room(seed);
    drawn = bits_hash_u32(drawn, bits_hash_grid(&grid));
    drawn = bits_hash_u32(drawn, bits_hash_clearance(&clearance));
    if (free_place(&rng, &start) && free_place(&rng, &goal)) {
      waves = hash_wave(waves, start, goal, 5);
      plans = hash_plans(plans, start, goal, seed);
    }
  }
  tell("grid", drawn);
  tell("wavefront", waves);
  tell("planner", plans);
}

/** Sensors that say anything, finite or not. */
static void absurd_input(void) {
  static nav_t nav;
  rng_t rng = rng_seed(5);
  nav_config_t cfg;
  uint32_t hash = BITS_HASH_START;
  nav_config_default(&cfg);
  nav_init(&nav, &cfg);
  for (uint32_t tick = 0; tick < 400u; tick++) {
    nav_input_t input = {.odometry.time_ms = 20u * tick, .battery_v = 4.0f, .flags = 0x5F};
    bool sane = rng_next(&rng) % 4u != 0u;
    input.odometry.height_m = 0.4f;
    input.odometry.pose = sane ? pose(&rng, 0.3f) : (pose2_t){any_float(&rng), 0.0f, 0.0f};
    input.velocity_mps.x = sane ? 0.1f : any_float(&rng);
    for (int beam = 0; beam < SCAN_RANGES; beam++) {
      input.range_m[beam] = sane ? between(&rng, 0.2f, 4.0f) : any_float(&rng);
    }
    if (tick % 50u == 10u) {
      nav_command_t order = {(mission_cmd_t)(1u + tick / 50u), {1.0f, 0.5f}};
      hash = bits_hash_u32(hash, (uint32_t)nav_command(&nav, &order));
    }
    nav_setpoint_t wanted = nav_step(&nav, &input);
    hash = bits_hash_u32(hash, wanted.motors);
    if (wanted.motors) {
      hash = bits_hash_vec2(hash, wanted.velocity_body_mps);
      hash = bits_hash_float(bits_hash_float(hash, wanted.height_m), wanted.yaw_rate_rps);
    }
  }
  tell("absurd input", bits_hash_u32(hash, bits_hash_nav(&nav)));
}

void port_main(void) {
  random_numbers();
  angles();
  vectors();
  packets();
  rooms();
  absurd_input();
}
