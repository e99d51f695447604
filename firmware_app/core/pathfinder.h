// SPDX-License-Identifier: GPL-3.0-or-later
/** @file pathfinder.h  From a grid's clearance to the shortest way, in slices and in fixed memory.
 *  Two random trees look for a first way (rrtstar.h). It is pulled taut (taut.h), and RRT* goes on
 * from there, every shorter way being pulled taut and grafted into the tree. A wave over the whole
 * grid (wavefront.h) joins in once: to find the way, or to prove that there is none, when the trees
 * did not within their samples; else to see that no way on other sides of the obstacles is shorter.
 * Its bits take the place of the tree, which begins anew from the best way. The result depends on
 * seed and total budget alone, not on how the budget was sliced. Coordinates are cells. */
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
  PATHFINDER_SEARCHING,     ///< no way yet
  PATHFINDER_FOUND,         ///< a way is known; more budget shortens it
  PATHFINDER_NO_WAY,        ///< proven: pathfinder_nearest() is as near as one can come
  PATHFINDER_TOO_WINDING,   ///< the way has more turns than a path has points
  PATHFINDER_START_BLOCKED, ///< the start lies in a blocked cell
  PATHFINDER_GOAL_BLOCKED,  ///< the goal lies in a blocked cell
} pathfinder_status_t;

typedef struct {
  float step_cells;         ///< longest new edge until a way is known
  uint16_t connect_samples; ///< without a way after these, the wave is asked
  uint16_t wave_samples;    ///< after the first way, until the wave is asked for a shorter one
  uint16_t least_samples;   ///< after the first way, before it is called enough
  uint16_t mend_samples;    ///< the same after pathfinder_repair
  float stop_ratio;         ///< enough are this many times the samples that the first way took
  bool adaptive;            ///< let step and connect_samples follow obstacles and distance
  bool grid_only;           ///< ask the wave alone, at once, and be content with its way
} pathfinder_config_t;

typedef enum {
  PATHFINDER_GROW, ///< samples: until a way is known, and then to shorten it
  PATHFINDER_WAVE, ///< the wave is on its way
  PATHFINDER_WALK, ///< the wave has met its target: walking back along it
  PATHFINDER_PULL, ///< pulling a new way taut
  PATHFINDER_END,  ///< nothing left to do
} pathfinder_stage_t;

typedef struct {
  pathfinder_config_t cfg;
  pathfinder_stage_t stage;
  pathfinder_status_t status;
  uint32_t seed;
  uint32_t samples;
  uint32_t first_samples; ///< that the first way took
  int32_t credit;         ///< budget not used yet
  float broken_cells;     ///< length of the way that broke, if this search goes on from one; else 0
  float best_cells;       ///< length of the best way, or a huge number
  lattice_t start;
  lattice_t goal;
  lattice_t path[PATHFINDER_POINTS]; ///< the best way
  uint8_t path_count;
  bool waved;  ///< the wave was asked, or need not be
  bool grown;  ///< search holds the tree, not the wave
  taut_t taut; ///< a new way
  union {
    rrtstar_t rrt;
    struct {
      wavefront_t wave;
      frontier_t frontier; ///< beside a wave of WAVEFRONT_OBSERVED
    };
  } search; ///< the two take turns
} pathfinder_t;

pathfinder_config_t pathfinder_config_default(void);
pathfinder_status_t pathfinder_start(pathfinder_t *planner, const pathfinder_config_t *cfg,
                                     const clearance_t *clearance, vec2_t start_cells,
                                     vec2_t goal_cells, uint32_t seed);
/** Look for the way to the frontier that is worth most (frontier.h); no way means that none is
 * left.
 */
pathfinder_status_t pathfinder_start_frontier(pathfinder_t *planner, const pathfinder_config_t *cfg,
                                              const clearance_t *clearance, vec2_t start_cells,
                                              frontier_mode_t mode, const frontier_vain_t *vain,
                                              vec2_t last_cells);
/** The map or the start has changed since a way was known: keep what still holds of the way and
 * look first where it broke. Same as pathfinder_start where no way was known. */
pathfinder_status_t pathfinder_repair(pathfinder_t *planner, const clearance_t *clearance,
                                      vec2_t start_cells);
/** Work for up to `budget` units; a step of a tree is one. The grid is read for frontiers alone. */
pathfinder_status_t pathfinder_extend(pathfinder_t *planner, const clearance_t *clearance,
                                      const grid_t *grid, int budget);
/** True when more samples are not worth their time. */
bool pathfinder_enough(const pathfinder_t *planner);
/** The best way from start to goal. @return points written, 0 if there is none or it needs more
 * than capacity */
int pathfinder_path(const pathfinder_t *planner, vec2_t *path_cells, int capacity);
/** The reachable place nearest to the goal, once there is no way. */
vec2_t pathfinder_nearest(const pathfinder_t *planner);
/** Nodes in use. */
int pathfinder_nodes(const pathfinder_t *planner);

#endif
