// SPDX-License-Identifier: GPL-3.0-or-later
/* Clearance, the wave, the planner and the route on arbitrary maps, against plain oracles:
 * distances cell by cell, and a flood fill. */
#include "bytes.h"
#include "clearance.h"
#include "pathfinder.h"
#include "route.h"
#include "wavefront.h"

enum { SIDE = GRID_SIDE_CELLS, SHAPES_MAX = 24, BUDGET = 4000, PATH_MAX = ROUTE_POINTS };

static const float CELL_M = 0.05f;

static grid_t grid;
static clearance_t clearance;
static wavefront_t wave;
static pathfinder_t planner;
static bool flooded[SIDE * SIDE];
static int queue[SIDE * SIDE];

/** Rectangles of walls, free space or the unknown. */
static void draw_map(bytes_t *bytes) {
  const grid_config_t cfg = grid_config_default();
  grid_init(&grid, &cfg, (vec2_t){0.0f, 0.0f}, CELL_M);
  int shapes = take_below(bytes, SHAPES_MAX);
  int ground = take_below(bytes, 2) * 3;
  for (int i = 0; i < GRID_CELLS; i++) {
    grid_set_value(&grid, i % SIDE, i / SIDE, ground);
  }
  for (int shape = 0; shape < shapes; shape++) {
    int x = take_below(bytes, SIDE);
    int y = take_below(bytes, SIDE);
    int width = 1 + take_below(bytes, SIDE);
    int depth = 1 + take_below(bytes, 6);
    int turned = take_below(bytes, 2);
    int value = take_below(bytes, GRID_VALUE_MAX + 1);
    for (int i = 0; i < width * depth; i++) {
      int along = i % width;
      int across = i / width;
      grid_set_value(&grid, x + (turned ? across : along), y + (turned ? along : across), value);
    }
  }
}

/** Blocked by what lies nearer than the radius, square to square. Radii end in odd eighths of a
 * cell, so that no distance equals one. */
static bool blocked_by_distance(int ix, int iy, float radius_cells) {
  for (int y = iy - CLEARANCE_REACH_MAX; y <= iy + CLEARANCE_REACH_MAX; y++) {
    for (int x = ix - CLEARANCE_REACH_MAX; x <= ix + CLEARANCE_REACH_MAX; x++) {
      int gap_x = abs(x - ix) > 1 ? abs(x - ix) - 1 : 0;
      int gap_y = abs(y - iy) > 1 ? abs(y - iy) - 1 : 0;
      if (grid_state(&grid, x, y) == GRID_CELL_OCCUPIED &&
          (float)(gap_x * gap_x + gap_y * gap_y) < radius_cells * radius_cells) {
        return true;
      }
    }
  }
  return false;
}

static void check_clearance(bytes_t *bytes) {
  float radius_cells = (float)take_below(bytes, 44) * 0.25f + 0.125f;
  vec2_t corner = {(0.5f * (float)SIDE + 1.0f) * CELL_M, (0.5f * (float)SIDE + 1.0f) * CELL_M};
  clearance_init(&clearance, &grid, radius_cells * CELL_M, vec2_scale(corner, -1.0f), corner);
  REQUIRE(clearance_refresh(&clearance, &grid, SIDE) == 0);
  for (int i = 0; i < 24; i++) {
    int ix = take_below(bytes, SIDE);
    int iy = take_below(bytes, SIDE);
    REQUIRE(clearance_blocked(&clearance, ix, iy) == blocked_by_distance(ix, iy, radius_cells));
  }
  vec2_t a = {take_float(bytes, -4.0f, 132.0f), take_float(bytes, -4.0f, 132.0f)};
  vec2_t b = {take_float(bytes, -4.0f, 132.0f), take_float(bytes, -4.0f, 132.0f)};
  vec2_t beside;
  REQUIRE(!clearance_segment_free(&clearance, a, b) || !clearance_blocked_at(&clearance, b));
  if (clearance_nearest_free(&clearance, a, take_below(bytes, 12), &beside)) {
    REQUIRE(!clearance_blocked_at(&clearance, beside));
  }
}

static void flood(grid_cell_t start) {
  static const int way[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
  int first = 0;
  int count = 1;
  memset(flooded, 0, sizeof flooded);
  queue[0] = start.iy * SIDE + start.ix;
  flooded[queue[0]] = true;
  while (first < count) {
    int at = queue[first++];
    for (int i = 0; i < 4; i++) {
      int ix = at % SIDE + way[i][0];
      int iy = at / SIDE + way[i][1];
      if (!clearance_blocked(&clearance, ix, iy) && !flooded[iy * SIDE + ix]) {
        flooded[iy * SIDE + ix] = true;
        queue[count++] = iy * SIDE + ix;
      }
    }
  }
}

static wavefront_status_t search(wavefront_kind_t kind, grid_cell_t start, grid_cell_t goal,
                                 int waves) {
  wavefront_start(&wave, kind, start, goal);
  while (wavefront_extend(&wave, &clearance, &grid, waves) == WAVEFRONT_RUNNING) {
  }
  return wave.status;
}

static vec2_t middle(grid_cell_t cell) {
  return (vec2_t){(float)cell.ix + 0.5f, (float)cell.iy + 0.5f};
}

static float check_path(const vec2_t *path, int count, vec2_t start, vec2_t goal) {
  float length = 0.0f;
  REQUIRE(vec2_distance(path[0], start) < 0.01f);
  REQUIRE(vec2_distance(path[count - 1], goal) < 0.01f);
  for (int i = 1; i < count; i++) {
    REQUIRE(clearance_segment_free(&clearance, path[i - 1], path[i]));
    length += vec2_distance(path[i - 1], path[i]);
  }
  return length;
}

/** The route ends where the path ends, is clear all along, and takes no detour. */
static void check_route(const vec2_t *path, int count, float length_cells) {
  static route_t route;
  memcpy(route.points_m, path, (size_t)count * sizeof *path);
  route_build(&route, &grid, &clearance, count);
  REQUIRE(route.count >= 2 && route.count <= ROUTE_POINTS);
  float length_m = route_length_m(&route);
  float detour_cells = (float)(2 * ROUTE_STAND_OFF_CELLS * count);
  REQUIRE(length_m <= (length_cells + detour_cells) * CELL_M);
  REQUIRE(route_clear_m(&route, &grid, &clearance, 0.0f) >= length_m - 0.01f);
  vec2_t end = grid_to_metres(&grid, path[count - 1]);
  REQUIRE(vec2_distance(route.points_m[route.count - 1], end) < 0.001f);
}

static void check_wave(grid_cell_t start, grid_cell_t goal, int waves) {
  lattice_t lattice[PATH_MAX];
  vec2_t path[PATH_MAX];
  bool reached = search(WAVEFRONT_TO_CELL, start, goal, waves) == WAVEFRONT_REACHED;
  REQUIRE(reached == flooded[goal.iy * SIDE + goal.ix]);
  int count = wavefront_path(&wave, &clearance, lattice, PATH_MAX, SIDE * SIDE);
  REQUIRE(count >= 0 && count <= PATH_MAX && (reached || count == 0));
  for (int i = 0; i < count; i++) {
    path[i] = lattice_to_cells(lattice[i]);
  }
  if (count > 1) {
    check_path(path, count, middle(goal), middle(start));
  }
  search(WAVEFRONT_EVERYWHERE, start, goal, waves);
  for (int i = 0; i < SIDE * SIDE; i++) {
    REQUIRE(wavefront_reached(&wave, i % SIDE, i / SIDE) == flooded[i]);
  }
  search(WAVEFRONT_OBSERVED, start, goal, waves);
  for (int i = 0; i < SIDE * SIDE; i++) {
    bool observed = grid_state(&grid, i % SIDE, i / SIDE) != GRID_CELL_UNKNOWN;
    bool root = i == start.iy * SIDE + start.ix;
    REQUIRE(!wavefront_reached(&wave, i % SIDE, i / SIDE) || root || (observed && flooded[i]));
  }
}

/** Spend the budget; what the planner says of a way must be true. */
static void check_planner(grid_cell_t start, grid_cell_t goal, int slice) {
  vec2_t path[PATH_MAX];
  for (int spent = 0; spent < BUDGET && !pathfinder_enough(&planner); spent += slice) {
    pathfinder_extend(&planner, &clearance, &grid, slice);
  }
  bool reachable = flooded[goal.iy * SIDE + goal.ix];
  pathfinder_status_t status = planner.status;
  REQUIRE(status != PATHFINDER_START_BLOCKED);
  REQUIRE((status == PATHFINDER_GOAL_BLOCKED) == clearance_blocked(&clearance, goal.ix, goal.iy));
  REQUIRE(status != PATHFINDER_FOUND || reachable);
  REQUIRE(status != PATHFINDER_NO_WAY || !reachable);
  REQUIRE(pathfinder_nodes(&planner) <= TREE_NODES);
  if (status == PATHFINDER_NO_WAY) {
    vec2_t nearest = pathfinder_nearest(&planner);
    REQUIRE(flooded[(int)nearest.y * SIDE + (int)nearest.x]);
  }
  int count = pathfinder_path(&planner, path, PATH_MAX);
  REQUIRE(count >= 0 && count <= PATH_MAX && (count > 0) == (status == PATHFINDER_FOUND));
  if (count > 1) {
    float length = check_path(path, count, middle(start), middle(goal));
    REQUIRE(fabsf(length - planner.best_cells) <= 0.001f * length + 0.05f);
    check_route(path, count, length);
  }
}

/** A wall appears; the planner mends its way. */
static void check_repair(bytes_t *bytes, grid_cell_t start, grid_cell_t goal, int slice) {
  int x = take_below(bytes, SIDE);
  int y = take_below(bytes, SIDE);
  for (int i = take_below(bytes, SIDE); i >= 0; i--) {
    grid_set_value(&grid, x, y + i, GRID_VALUE_MAX);
  }
  clearance_mark(&clearance, &grid);
  REQUIRE(clearance_refresh(&clearance, &grid, SIDE) == 0);
  if (!clearance_blocked(&clearance, start.ix, start.iy)) {
    flood(start);
    pathfinder_repair(&planner, &clearance, middle(start));
    check_planner(start, goal, slice);
  }
}

static void check_searches(bytes_t *bytes) {
  grid_cell_t start = {take_below(bytes, SIDE), take_below(bytes, SIDE)};
  grid_cell_t goal = {take_below(bytes, SIDE), take_below(bytes, SIDE)};
  int slice = 1 + take_below(bytes, 200);
  uint32_t seed = take_u32(bytes);
  if (clearance_blocked(&clearance, start.ix, start.iy)) {
    return;
  }
  flood(start);
  check_wave(start, goal, slice);
  pathfinder_config_t cfg = pathfinder_config_default();
  cfg.adaptive = take_below(bytes, 2) != 0;
  cfg.grid_only = take_below(bytes, 4) == 3;
  pathfinder_start(&planner, &cfg, &clearance, middle(start), middle(goal), seed);
  check_planner(start, goal, slice);
  check_repair(bytes, start, goal, slice);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  bytes_t bytes = {data, size};
  draw_map(&bytes);
  check_clearance(&bytes);
  check_searches(&bytes);
  return 0;
}
