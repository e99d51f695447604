// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
#include "pathfinder.h"

#include <math.h>
#include <string.h>

/** Cost of each kind of work in units of the budget, in proportion to its cycles on the chip. */
enum {
  UNITS_OF_STEP = 1,     ///< a step of a tree, before there is a path
  UNITS_OF_REWIRING = 2, ///< a sample of RRT*, once there is a path
  UNITS_OF_WAVE = 6,     ///< a wave to the goal
  ROWS_A_UNIT = 2,       ///< rows that a wave through observed cells treats for one unit
  UNITS_OF_RATING = 2,   ///< rating one frontier
  UNITS_OF_PULL = 2,     ///< one step of pulling taut
  UNITS_OF_WALK = 4,     ///< STEPS_OF_WALK cells of the walk back
};

enum { STEPS_OF_WALK = 16 };

static const float HUGE_CELLS = 1.0e9f;
static const float MENDED_ENOUGH = 1.25f; ///< no second look up to this multiple of the broken path
static const float STRAIGHT_ENOUGH = 1.01f; ///< no second look up to this multiple of the distance

pathfinder_config_t pathfinder_config_default(void) {
  return (pathfinder_config_t){
      .step_cells = 20.0f,
      .connect_samples = 500,
      .wave_samples = 60,
      .least_samples = 60,
      .mend_samples = 10,
      .stop_ratio = 2.0f,
  };
}

/** Lattice point of a position, moved in x to more than the margin of a line of sight from the
 * sides of its cell: otherwise a blocked cell beside it would hide everything. */
static lattice_t settled(vec2_t cells) {
  const int side = CLEARANCE_MARGIN_STEPS + 1;
  lattice_t p = lattice_from_cells(cells);
  int in_cell = p.x & (LATTICE_PER_CELL - 1);
  int moved = in_cell < side ? side : in_cell;
  moved = moved > LATTICE_PER_CELL - 1 - side ? LATTICE_PER_CELL - 1 - side : moved;
  return (lattice_t){(int16_t)(p.x + moved - in_cell), p.y};
}

static grid_cell_t cell_of(lattice_t p) {
  return (grid_cell_t){p.x >> LATTICE_BITS, p.y >> LATTICE_BITS};
}

static void start_wave(pathfinder_t *planner, wavefront_kind_t kind) {
  planner->waved = true;
  planner->grown = false;
  planner->stage = PATHFINDER_WAVE;
  wavefront_start(&planner->search.wave, kind, cell_of(planner->start), cell_of(planner->goal));
}

/** Limit the wave to where a path shorter than the best one can lie: the bounding box of the
 * ellipse with start and goal as foci and best_cells as major axis. */
__attribute__((noinline)) static void limit_wave(pathfinder_t *planner) {
  vec2_t start = lattice_to_cells(planner->start);
  vec2_t goal = lattice_to_cells(planner->goal);
  vec2_t focal = vec2_scale(vec2_sub(goal, start), 0.5f);
  float major = 0.25f * planner->best_cells * planner->best_cells;
  float minor = major - vec2_dot(focal, focal);
  float share = vec2_dot(focal, focal) > 0.0f ? 1.0f / vec2_dot(focal, focal) : 0.0f;
  float along_x = focal.x * focal.x * share;
  float along_y = focal.y * focal.y * share;
  vec2_t half = {sqrtf(major * along_x + minor * along_y),
                 sqrtf(major * along_y + minor * along_x)};
  vec2_t middle = vec2_scale(vec2_add(start, goal), 0.5f);
  vec2_t low = vec2_sub(middle, half);
  vec2_t high = vec2_add(middle, half);
  wavefront_limit(&planner->search.wave, (grid_cell_t){(int)low.x - 1, (int)low.y - 1},
                  (grid_cell_t){(int)high.x + 1, (int)high.y + 1});
}

static void reset(pathfinder_t *planner, const pathfinder_config_t *cfg, vec2_t start_cells,
                  vec2_t goal_cells, uint32_t seed) {
  planner->cfg = *cfg;
  planner->stage = PATHFINDER_END;
  planner->status = PATHFINDER_SEARCHING;
  planner->seed = seed;
  planner->samples = 0u;
  planner->first_samples = 0u;
  planner->credit = 0;
  planner->best_cells = HUGE_CELLS;
  planner->path_count = 0;
  planner->waved = false;
  planner->broken_cells = 0.0f;
  planner->grown = false;
  planner->start = settled(start_cells);
  planner->goal = settled(goal_cells);
}

/** Make a path the best one. */
static void take_path(pathfinder_t *planner, const lattice_t *way, int count, float length_cells) {
  memmove(planner->path, way, (size_t)count * sizeof *way);
  planner->path_count = (uint8_t)count;
  planner->best_cells = length_cells;
  if (planner->status == PATHFINDER_SEARCHING) {
    planner->status = PATHFINDER_FOUND;
    planner->first_samples = planner->samples;
  }
}

static int bits_in(uint32_t word) {
  int count = 0;
  for (; word != 0u; word &= word - 1u) {
    count++;
  }
  return count;
}

/** Shorter steps and more samples where much is blocked, more samples if the goal is far. */
static void adapt(pathfinder_t *planner, const clearance_t *clearance) {
  int blocked = 0;
  for (int i = 0; i < GRID_SIDE_CELLS * GRID_BIT_WORDS; i++) {
    blocked += bits_in(clearance->bits[i]);
  }
  float blocked_share = (float)blocked / (float)GRID_CELLS;
  float far = lattice_distance(planner->start, planner->goal) / (float)GRID_SIDE_CELLS;
  planner->cfg.step_cells *= 1.5f - blocked_share;
  planner->cfg.connect_samples =
      (uint16_t)((float)planner->cfg.connect_samples * (0.5f + blocked_share) * (0.5f + far));
}

static void start_tree(pathfinder_t *planner) {
  planner->stage = PATHFINDER_GROW;
  planner->grown = true;
  rrtstar_start(&planner->search.rrt, planner->start, planner->goal, planner->cfg.step_cells,
                planner->seed);
}

pathfinder_status_t pathfinder_start(pathfinder_t *planner, const pathfinder_config_t *cfg,
                                     const clearance_t *clearance, vec2_t start_cells,
                                     vec2_t goal_cells, uint32_t seed) {
  reset(planner, cfg, start_cells, goal_cells, seed);
  if (clearance_blocked_at(clearance, start_cells)) {
    planner->status = PATHFINDER_START_BLOCKED;
  } else if (clearance_blocked_at(clearance, goal_cells)) {
    planner->status = PATHFINDER_GOAL_BLOCKED;
  } else if (clearance_sees(clearance, planner->start, planner->goal)) {
    const lattice_t straight[] = {planner->start, planner->goal};
    take_path(planner, straight, 2, lattice_length(straight, 2));
  } else if (cfg->grid_only) {
    start_wave(planner, WAVEFRONT_TO_CELL);
  } else {
    if (cfg->adaptive) {
      adapt(planner, clearance);
    }
    start_tree(planner);
  }
  return planner->status;
}

pathfinder_status_t pathfinder_start_frontier(pathfinder_t *planner, const pathfinder_config_t *cfg,
                                              const clearance_t *clearance, vec2_t start_cells,
                                              frontier_mode_t mode, const frontier_vain_t *vain,
                                              vec2_t last_cells) {
  reset(planner, cfg, start_cells, start_cells, 0u);
  planner->cfg.grid_only = true;
  if (clearance_blocked_at(clearance, start_cells)) {
    planner->status = PATHFINDER_START_BLOCKED;
  } else {
    start_wave(planner, WAVEFRONT_OBSERVED);
    frontier_start(&planner->search.frontier, mode, vain,
                   (grid_cell_t){(int)last_cells.x, (int)last_cells.y});
  }
  return planner->status;
}

/** Start pulling taut the new path in taut->points, and take it as it is if it is the best yet. */
static void pull(pathfinder_t *planner, int count) {
  taut_start(&planner->taut, count);
  planner->stage = PATHFINDER_PULL;
  float length_cells = lattice_length(planner->taut.points, count);
  if (length_cells < planner->best_cells) {
    take_path(planner, planner->taut.points, count, length_cells);
  }
}

/** The wave has used the memory of the tree: start the tree again from the best path. */
static void grow_again(pathfinder_t *planner) {
  if (planner->cfg.grid_only) {
    planner->stage = PATHFINDER_END;
    return;
  }
  start_tree(planner);
  rrtstar_restart_from(&planner->search.rrt, planner->path, planner->path_count);
  planner->search.rrt.best_cells = planner->best_cells;
}

/** The tree has a shorter path: start pulling it taut. */
static void pull_from_tree(pathfinder_t *planner, const clearance_t *clearance) {
  int count = rrtstar_way(&planner->search.rrt, clearance, planner->taut.points, TAUT_POINTS);
  if (count > 0) {
    pull(planner, count);
  }
}

/** Length up to which a path is not worth a second look by the wave. */
static float good_cells(const pathfinder_t *planner) {
  float straight_cells = STRAIGHT_ENOUGH * lattice_distance(planner->start, planner->goal);
  float broken_cells = MENDED_ENOUGH * planner->broken_cells;
  return straight_cells > broken_cells ? straight_cells : broken_cells;
}

/** Samples between the first path and the second look by the wave. */
static uint32_t second_look_after(const pathfinder_t *planner) {
  uint16_t mended = planner->cfg.mend_samples;
  return planner->broken_cells > 0.0f ? mended : planner->cfg.wave_samples;
}

/** Draw one sample, or start the wave if it is due. */
static void sample(pathfinder_t *planner, const clearance_t *clearance) {
  rrtstar_t *rrt = &planner->search.rrt;
  bool found = planner->status == PATHFINDER_FOUND;
  uint32_t since_first = planner->samples - planner->first_samples;
  if (!found && (planner->samples >= planner->cfg.connect_samples || rrtstar_stuck(rrt))) {
    start_wave(planner, WAVEFRONT_TO_CELL);
  } else if (found && !planner->waved && since_first >= second_look_after(planner)) {
    planner->waved = true;
    if (planner->best_cells > good_cells(planner)) {
      start_wave(planner, WAVEFRONT_TO_CELL);
      limit_wave(planner);
    }
  } else {
    planner->samples++;
    bool better = rrtstar_sample(rrt, clearance);
    planner->credit -= found ? UNITS_OF_REWIRING : UNITS_OF_STEP * (int32_t)rrt->steps;
    if (better) {
      pull_from_tree(planner, clearance);
    }
  }
}

/** Make the best frontier the target to walk back from. @return false if there is none */
static bool aim_at_frontier(pathfinder_t *planner) {
  const frontier_t *frontier = &planner->search.frontier;
  if (!frontier_found(frontier)) {
    return false;
  }
  wavefront_aim(&planner->search.wave, frontier->best, frontier->best_waves);
  planner->stage = PATHFINDER_WALK;
  return true;
}

/** One slice of a search for frontiers: rate one that the last wave met, else spread a wave. */
static void frontier_wave(pathfinder_t *planner, const clearance_t *clearance, const grid_t *grid) {
  wavefront_t *front = &planner->search.wave;
  frontier_t *frontier = &planner->search.frontier;
  if (frontier_look(frontier, front, grid, clearance)) {
    planner->credit -= UNITS_OF_RATING;
    return;
  }
  int rows = 0;
  for (int i = 0; i < GRID_BIT_WORDS; i++) {
    rows += bits_in(front->rows[i]);
  }
  planner->credit -= 1 + rows / ROWS_A_UNIT;
  bool over = frontier_decided(frontier, front) ||
              wavefront_extend(front, clearance, grid, 1) == WAVEFRONT_EXHAUSTED;
  if (over && !aim_at_frontier(planner)) {
    planner->status = PATHFINDER_NO_WAY;
    planner->stage = PATHFINDER_END;
  }
}

/** Spread one wave towards the goal. */
static void wave(pathfinder_t *planner, const clearance_t *clearance, const grid_t *grid) {
  switch (wavefront_extend(&planner->search.wave, clearance, grid, 1)) {
  case WAVEFRONT_REACHED:
    planner->stage = PATHFINDER_WALK;
    break;
  case WAVEFRONT_EXHAUSTED:
    planner->status = PATHFINDER_NO_WAY;
    planner->stage = PATHFINDER_END;
    break;
  case WAVEFRONT_RUNNING:
    break;
  }
}

/** One slice of the walk back. At its end, put the true start and goal in place of the centres of
 * their cells, and start pulling the path taut. */
static void walk(pathfinder_t *planner, const clearance_t *clearance) {
  lattice_t *way = planner->taut.points;
  bool frontier = planner->search.wave.kind == WAVEFRONT_OBSERVED;
  int count = wavefront_path(&planner->search.wave, clearance, way, TAUT_POINTS - 2, STEPS_OF_WALK);
  if (count == WAVEFRONT_WALKING) {
    return;
  }
  if (count == 0 && planner->status == PATHFINDER_FOUND) {
    grow_again(planner);
    return;
  }
  if (count == 0) {
    planner->status = PATHFINDER_TOO_WINDING;
    planner->stage = PATHFINDER_END;
    return;
  }
  lattice_reverse(way, count);
  memmove(&way[1], way, (size_t)count++ * sizeof *way);
  way[0] = planner->start;
  if (frontier) {
    planner->goal = way[count - 1];
  } else {
    way[count++] = planner->goal;
  }
  pull(planner, count);
}

/** One step of pulling taut. Once taut, keep the path if it is the best and hand it to the tree. */
static void pull_on(pathfinder_t *planner, const clearance_t *clearance) {
  taut_t *taut = &planner->taut;
  if (!taut_step(taut, clearance)) {
    return;
  }
  float length_cells = lattice_length(taut->points, taut->count);
  if (length_cells < planner->best_cells) {
    take_path(planner, taut->points, taut->count, length_cells);
  }
  if (!planner->grown) {
    grow_again(planner);
    return;
  }
  planner->stage = PATHFINDER_GROW;
  rrtstar_graft(&planner->search.rrt, planner->path, planner->path_count);
  planner->search.rrt.best_cells = planner->best_cells;
}

/** Make the path begin at a new start, from which it goes to the last of its points in sight, or to
 * its second point if none is. */
static void begin_path_at(pathfinder_t *planner, const clearance_t *clearance, lattice_t start) {
  int seen = planner->path_count - 1;
  while (seen > 1 && !clearance_sees(clearance, start, planner->path[seen])) {
    seen--;
  }
  memmove(&planner->path[1], &planner->path[seen],
          (size_t)(planner->path_count - seen) * sizeof *planner->path);
  planner->path_count = (uint8_t)(planner->path_count - seen + 1);
  planner->path[0] = planner->start = start;
}

/** Number of pieces before the first blocked one, from `end` on; step -1 goes backwards. */
static int pieces_in_sight(const clearance_t *clearance, const lattice_t *end, int step,
                           int count) {
  int pieces = 0;
  while (pieces + 1 < count && clearance_sees(clearance, end[0], end[step])) {
    end += step;
    pieces++;
  }
  return pieces;
}

pathfinder_status_t pathfinder_repair(pathfinder_t *planner, const clearance_t *clearance,
                                      vec2_t start_cells) {
  vec2_t goal_cells = lattice_to_cells(planner->goal);
  pathfinder_config_t cfg = planner->cfg;
  if (planner->status != PATHFINDER_FOUND || cfg.grid_only ||
      clearance_blocked_at(clearance, start_cells) || clearance_blocked_at(clearance, goal_cells)) {
    return pathfinder_start(planner, &cfg, clearance, start_cells, goal_cells, planner->seed);
  }
  begin_path_at(planner, clearance, settled(start_cells));
  int count = planner->path_count;
  float broken_cells = planner->best_cells;
  int before = pieces_in_sight(clearance, planner->path, 1, count);
  int after = pieces_in_sight(clearance, &planner->path[count - 1], -1, count);
  reset(planner, &cfg, start_cells, goal_cells, planner->seed + 1u);
  start_tree(planner);
  planner->broken_cells = broken_cells;
  if (before == count - 1) {
    take_path(planner, planner->path, count, lattice_length(planner->path, count));
    grow_again(planner);
  } else {
    rrtstar_mend(&planner->search.rrt, planner->path, count, before, after);
  }
  return planner->status;
}

pathfinder_status_t pathfinder_extend(pathfinder_t *planner, const clearance_t *clearance,
                                      const grid_t *grid, int budget) {
  planner->credit += budget;
  while (planner->credit > 0 && planner->stage != PATHFINDER_END) {
    switch (planner->stage) {
    case PATHFINDER_GROW:
      sample(planner, clearance);
      break;
    case PATHFINDER_WAVE:
      if (planner->search.wave.kind == WAVEFRONT_OBSERVED) {
        frontier_wave(planner, clearance, grid);
      } else {
        planner->credit -= UNITS_OF_WAVE;
        wave(planner, clearance, grid);
      }
      break;
    case PATHFINDER_WALK:
      walk(planner, clearance);
      planner->credit -= UNITS_OF_WALK;
      break;
    case PATHFINDER_PULL:
      pull_on(planner, clearance);
      planner->credit -= UNITS_OF_PULL;
      break;
    case PATHFINDER_END:
      break;
    }
  }
  if (planner->stage == PATHFINDER_END) {
    planner->credit = 0;
  }
  return planner->status;
}

bool pathfinder_enough(const pathfinder_t *planner) {
  if (planner->status == PATHFINDER_SEARCHING || planner->stage == PATHFINDER_END) {
    return planner->stage == PATHFINDER_END;
  }
  uint32_t since_first = planner->samples - planner->first_samples;
  uint32_t least =
      planner->broken_cells > 0.0f ? planner->cfg.mend_samples : planner->cfg.least_samples;
  // If the wave found the first path, the samples drawn in vain before it are no measure.
  float first =
      planner->first_samples < planner->cfg.connect_samples ? (float)planner->first_samples : 0.0f;
  float wanted = (planner->cfg.stop_ratio - 1.0f) * first;
  return planner->stage == PATHFINDER_GROW && planner->waved && since_first >= least &&
         (float)since_first >= wanted;
}

int pathfinder_path(const pathfinder_t *planner, vec2_t *path_cells, int capacity) {
  if (planner->path_count > capacity) {
    return 0;
  }
  for (int i = 0; i < planner->path_count; i++) {
    path_cells[i] = lattice_to_cells(planner->path[i]);
  }
  return planner->path_count;
}

vec2_t pathfinder_nearest(const pathfinder_t *planner) {
  grid_cell_t cell = wavefront_nearest(&planner->search.wave, lattice_to_cells(planner->goal));
  return (vec2_t){(float)cell.ix + 0.5f, (float)cell.iy + 0.5f};
}

int pathfinder_nodes(const pathfinder_t *planner) {
  return planner->grown ? planner->search.rrt.tree.count : 0;
}
