// SPDX-License-Identifier: GPL-3.0-or-later
#include "ours.h"

#include <math.h>

#include "clearance.h"
#include "grid.h"
#include "pathfinder.h"
#include "route.h"

static grid_t grid;
static clearance_t clearance;
static pathfinder_t planner;
static route_t route;
static vec2_t from_cells;

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
  const pathfinder_config_t cfg = pathfinder_config_default();
  from_cells = start_cells;
  pathfinder_start(&planner, &cfg, &clearance, start_cells, goal_cells, seed);
}

bool ours_search(int units) {
  pathfinder_extend(&planner, &clearance, &grid, units);
  return planner.stage != PATHFINDER_END;
}

long ours_samples(void) {
  return (long)planner.samples;
}

void ours_repair(void) {
  pathfinder_repair(&planner, &clearance, from_cells);
}

bool ours_enough(void) {
  return pathfinder_enough(&planner);
}

float ours_cost(void) {
  return planner.status == PATHFINDER_FOUND ? planner.best_cells : INFINITY;
}

int ours_nodes(void) {
  return pathfinder_nodes(&planner);
}

int ours_way(vec2_t *way_cells, int capacity) {
  return pathfinder_path(&planner, way_cells, capacity);
}

int ours_route(vec2_t *way_cells, int capacity) {
  int count = pathfinder_path(&planner, route.points_m, ROUTE_POINTS);
  if (count < 2) {
    return 0;
  }
  route_build(&route, &grid, &clearance, count);
  for (int i = 0; i < route.count && i < capacity; i++) {
    way_cells[i] = grid_to_cells(&grid, route.points_m[i]);
  }
  return route.count <= capacity ? route.count : 0;
}

bool ours_no_way(vec2_t start_cells, vec2_t goal_cells, uint32_t seed) {
  ours_start(start_cells, goal_cells, seed);
  while (planner.status == PATHFINDER_SEARCHING) {
    pathfinder_extend(&planner, &clearance, &grid, GRID_SIDE_CELLS);
  }
  return planner.status == PATHFINDER_NO_WAY;
}

ours_sizes_t ours_sizes(void) {
  return (ours_sizes_t){sizeof planner, sizeof clearance.bits};
}
