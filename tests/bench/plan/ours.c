// SPDX-License-Identifier: GPL-3.0-or-later
#include "ours.h"

#include <math.h>

#include "clearance.h"
#include "grid.h"
#include "route.h"
#include "rrtstar.h"
#include "wavefront.h"

static grid_t grid;
static clearance_t clearance;
static rrtstar_t tree;
static wavefront_t wave;
static route_t route;
static vec2_t from_cells, to_cells;

static bool is_set(const uint32_t bits[OURS_WORDS], int ix, int iy) {
  return (bits[iy * OURS_ROW_WORDS + ix / 32] >> (ix % 32) & 1u) != 0u;
}

bool ours_change_blocked(const uint32_t bits[OURS_WORDS]) {
  bool alike = true;
  for (int iy = 0; iy < OURS_SIDE; iy++) {
    for (int ix = 0; ix < OURS_SIDE; ix++) {
      int wanted = is_set(bits, ix, iy) ? GRID_VALUE_MAX : GRID_FREE_MIN;
      if (grid_value(&grid, ix, iy) != wanted) {
        grid_set_value(&grid, ix, iy, wanted);
      }
    }
  }
  clearance_mark(&clearance, &grid);
  clearance_refresh(&clearance, &grid, GRID_SIDE_CELLS);
  for (int cell = 0; cell < OURS_SIDE * OURS_SIDE; cell++) {
    int ix = cell % OURS_SIDE;
    int iy = cell / OURS_SIDE;
    alike = alike && clearance_blocked(&clearance, ix, iy) == is_set(bits, ix, iy);
  }
  return alike;
}

/** The cells are blocked already as wide as the drone makes them: a radius of nothing. */
bool ours_set_blocked(const uint32_t bits[OURS_WORDS]) {
  const grid_config_t cfg = grid_config_default();
  const vec2_t beyond_m = {10.0f, 10.0f};
  grid_init(&grid, &cfg, (vec2_t){0.0f, 0.0f}, 0.05f);
  clearance_init(&clearance, &grid, 0.0f, vec2_scale(beyond_m, -1.0f), beyond_m);
  return ours_change_blocked(bits);
}

void ours_start(vec2_t start_cells, vec2_t goal_cells, uint32_t seed) {
  const rrtstar_config_t cfg = rrtstar_config_default();
  from_cells = start_cells;
  to_cells = goal_cells;
  rrtstar_start(&tree, &cfg, &clearance, start_cells, goal_cells, seed);
}

bool ours_search(int samples) {
  rrtstar_status_t status = rrtstar_extend(&tree, &clearance, samples);
  return status == RRTSTAR_SEARCHING || status == RRTSTAR_FOUND;
}

void ours_repair(uint32_t seed) {
  ours_start(from_cells, to_cells, seed);
}

float ours_cost(void) {
  return tree.goal_parent == RRTSTAR_NONE ? INFINITY : tree.best_cells;
}

int ours_nodes(void) {
  return tree.count;
}

int ours_way(vec2_t *way_cells, int capacity) {
  return rrtstar_path(&tree, way_cells, capacity);
}

int ours_route(vec2_t *way_cells, int capacity) {
  int count = rrtstar_path(&tree, route.points_m, ROUTE_POINTS);
  if (count < 2) {
    return 0;
  }
  route_build(&route, &grid, &clearance, count);
  for (int i = 0; i < route.count && i < capacity; i++) {
    way_cells[i] = grid_to_cells(&grid, route.points_m[i]);
  }
  return route.count <= capacity ? route.count : 0;
}

bool ours_no_way(vec2_t start_cells, vec2_t goal_cells) {
  grid_cell_t start = {(int)start_cells.x, (int)start_cells.y};
  grid_cell_t goal = {(int)goal_cells.x, (int)goal_cells.y};
  wavefront_start(&wave, WAVEFRONT_TO_GOAL, start, goal);
  while (wavefront_extend(&wave, &clearance, &grid, GRID_CELLS) == WAVEFRONT_RUNNING) {
  }
  return wave.status == WAVEFRONT_EXHAUSTED;
}

ours_sizes_t ours_sizes(void) {
  return (ours_sizes_t){sizeof tree, sizeof clearance.bits, sizeof wave};
}
