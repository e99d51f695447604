// SPDX-License-Identifier: GPL-3.0-or-later
/** @file rrtstar.h  RRT* over the clearance bits in a fixed pool of nodes, sliced over ticks.
 *  Source: Karaman and Frazzoli, Sampling-based Algorithms for Optimal Motion Planning (IJRR 2011),
 * algorithm 6, with the radius of eq. (11); informed sampling of the ellipse once a way is known
 * (Gammell et al., IROS 2014). Neighbours come from a 16 x 16 table of buckets. The result depends
 * on seed and total budget alone, not on how the budget was sliced. When the pool is full the
 * search ends. Coordinates are cells. */
#ifndef RRTSTAR_H
#define RRTSTAR_H

#include <stdbool.h>
#include <stdint.h>

#include "clearance.h"
#include "geometry.h"
#include "rng.h"

enum { RRTSTAR_NODES = 342, RRTSTAR_NEAR = 24, RRTSTAR_BUCKET_SIDE = 16, RRTSTAR_NONE = -1 };

typedef enum {
  RRTSTAR_SEARCHING,     ///< no way yet
  RRTSTAR_FOUND,         ///< a way is known; more budget shortens it
  RRTSTAR_POOL_FULL,     ///< no node is left; the best way so far, if any, stands
  RRTSTAR_START_BLOCKED, ///< the start lies in a blocked cell
  RRTSTAR_GOAL_BLOCKED,  ///< the goal lies in a blocked cell
} rrtstar_status_t;

typedef struct {
  float step_cells; ///< longest new edge
  float goal_bias;  ///< share of samples that are the goal, until a way is found
} rrtstar_config_t;

typedef struct {
  uint16_t x, y; ///< 1/512 cell
  int16_t parent;
  int16_t child;    ///< first of its children
  int16_t sibling;  ///< next child of its parent
  int16_t next;     ///< next node in its bucket
  float cost_cells; ///< length of the way from the start
} rrtstar_node_t;

typedef struct {
  rrtstar_node_t nodes[RRTSTAR_NODES];
  int16_t buckets[RRTSTAR_BUCKET_SIDE * RRTSTAR_BUCKET_SIDE];
  rrtstar_config_t cfg;
  rng_t rng;
  vec2_t start_cells;
  vec2_t goal_cells;
  float best_cells; ///< length of the best way, or a huge number
  uint32_t iterations;
  int16_t near[RRTSTAR_NEAR]; ///< neighbours of the new node: considered as parent, then rewired
  int16_t near_count;
  int16_t count;
  int16_t goal_parent; ///< last node of the best way
  rrtstar_status_t status;
} rrtstar_t;

rrtstar_config_t rrtstar_config_default(void);
rrtstar_status_t rrtstar_start(rrtstar_t *rrt, const rrtstar_config_t *cfg,
                               const clearance_t *clearance, vec2_t start_cells, vec2_t goal_cells,
                               uint32_t seed);
/** Draw up to `budget` samples. */
rrtstar_status_t rrtstar_extend(rrtstar_t *rrt, const clearance_t *clearance, int budget);
/** The best way from start to goal. @return points written, 0 if there is none or it needs more
 * than capacity */
int rrtstar_path(const rrtstar_t *rrt, vec2_t *path_cells, int capacity);

#endif
