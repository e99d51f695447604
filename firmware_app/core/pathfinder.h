// SPDX-License-Identifier: GPL-3.0-or-later
/** @file pathfinder.h  Anytime path planner on the clearance bits, in slices and in fixed memory.
 *
 * Two random trees look for a first path (rrtstar.h). It is pulled taut (taut.h) and then shortened
 * by RRT*; every shorter path is pulled taut in turn and grafted into the tree.
 *
 * A wave over the whole grid (wavefront.h) runs once. If the trees find no path within their
 * samples, the wave finds it or proves that there is none; otherwise the wave checks whether a path
 * on other sides of the obstacles is shorter. Wave and tree share their memory, so that the tree
 * starts again from the best path afterwards.
 *
 * The result depends on seed and total budget alone, not on how the budget was sliced. Coordinates
 * are cells. */
#ifndef PATHFINDER_H
#define PATHFINDER_H

#include <stdbool.h>
#include <stdint.h>

#include "clearance.h"
#include "frontier.h"
#include "geometry.h"
#include "grid.h"
#include "rrtstar.h"
#include "taut.h"
#include "wavefront.h"

enum { PATHFINDER_POINTS = TAUT_POINTS };

typedef enum {
  PATHFINDER_SEARCHING,     ///< no path yet
  PATHFINDER_FOUND,         ///< a path is known; more budget may shorten it
  PATHFINDER_NO_WAY,        ///< proven that there is no path; see pathfinder_nearest()
  PATHFINDER_TOO_WINDING,   ///< the path has more corners than PATHFINDER_POINTS
  PATHFINDER_START_BLOCKED, ///< the start lies in a blocked cell
  PATHFINDER_GOAL_BLOCKED,  ///< the goal lies in a blocked cell
} pathfinder_status_t;

typedef struct {
  float step_cells;         ///< longest new edge of the trees until a path is known
  uint16_t connect_samples; ///< without a path after this many samples the wave is started
  uint16_t wave_samples;    ///< samples after the first path until the wave looks for a shorter one
  uint16_t least_samples;   ///< least samples after the first path before pathfinder_enough()
  uint16_t mend_samples;    ///< takes the place of the two above after pathfinder_repair()
  float stop_ratio;         ///< enough: this many times the samples that the first path took
  bool adaptive;            ///< scale step_cells and connect_samples by obstacles and distance
  bool grid_only;           ///< use the wave alone, and its path pulled taut
} pathfinder_config_t;

typedef enum {
  PATHFINDER_GROW, ///< sampling: for a first path, then for a shorter one
  PATHFINDER_WAVE, ///< the wave spreads
  PATHFINDER_WALK, ///< the wave has reached its target: walking back to the root
  PATHFINDER_PULL, ///< pulling a new path taut
  PATHFINDER_END,  ///< nothing left to do
} pathfinder_stage_t;

typedef struct {
  pathfinder_config_t cfg;
  pathfinder_stage_t stage;
  pathfinder_status_t status;
  uint32_t seed;
  uint32_t samples;       ///< drawn so far
  uint32_t first_samples; ///< drawn when the first path was found
  int32_t credit;         ///< budget not used yet
  float broken_cells;     ///< after pathfinder_repair(): length of the broken path; else 0
  float best_cells;       ///< length of the best path; huge if there is none
  lattice_t start;
  lattice_t goal;
  lattice_t path[PATHFINDER_POINTS]; ///< the best path
  uint8_t path_count;
  bool waved;  ///< the wave has run, or is not needed
  bool grown;  ///< `search` holds the tree, not the wave
  taut_t taut; ///< the new path that is being pulled taut
  union {
    rrtstar_t rrt;
    struct {
      wavefront_t wave;
      frontier_t frontier; ///< only with a wave of WAVEFRONT_OBSERVED
    };
  } search; ///< tree and wave take turns
} pathfinder_t;

pathfinder_config_t pathfinder_config_default(void);
/** Begin a search. If the goal is in sight of the start, the straight line is found at once. */
pathfinder_status_t pathfinder_start(pathfinder_t *planner, const pathfinder_config_t *cfg,
                                     const clearance_t *clearance, vec2_t start_cells,
                                     vec2_t goal_cells, uint32_t seed);
/** Search for the path to the best frontier (frontier.h). PATHFINDER_NO_WAY means that no frontier
 * worth a flight is left. @param last_cells  the frontier chosen last time */
pathfinder_status_t pathfinder_start_frontier(pathfinder_t *planner, const pathfinder_config_t *cfg,
                                              const clearance_t *clearance, vec2_t start_cells,
                                              frontier_mode_t mode, const frontier_vain_t *vain,
                                              vec2_t last_cells);
/** Plan again after a change of the map or the start: keep the pieces of the last path that are
 * still free at both its ends, and sample near the break first. The same as pathfinder_start if no
 * path was known, or with grid_only. */
pathfinder_status_t pathfinder_repair(pathfinder_t *planner, const clearance_t *clearance,
                                      vec2_t start_cells);
/** Work for `budget` units; a step of a tree costs one. Only the search for frontiers reads the
 * grid. */
pathfinder_status_t pathfinder_extend(pathfinder_t *planner, const clearance_t *clearance,
                                      const grid_t *grid, int budget);
/** True if more samples are not expected to be worth their time, or nothing is left to do. */
bool pathfinder_enough(const pathfinder_t *planner);
/** The best path from start to goal. @return points written; 0 if there is no path or it needs more
 * than capacity */
int pathfinder_path(const pathfinder_t *planner, vec2_t *path_cells, int capacity);
/** The reachable position nearest to the goal; only after PATHFINDER_NO_WAY. */
vec2_t pathfinder_nearest(const pathfinder_t *planner);
/** Nodes in the tree; 0 while the wave has its memory. */
int pathfinder_nodes(const pathfinder_t *planner);

#endif
