// SPDX-License-Identifier: GPL-3.0-or-later
/** @file rrtstar.h  RRT-Connect for a first path, then informed RRT*, in a fixed pool of nodes.
 *
 * First path: two trees grow towards each other (Kuffner and LaValle, RRT-Connect, ICRA 2000).
 *
 * Shortening: they become one tree, rooted at the goal, which RRT* improves (Karaman and Frazzoli,
 * Sampling-based Algorithms for Optimal Motion Planning, IJRR 2011, algorithm 6, with a fixed
 * radius in place of the shrinking one of eq. (11): the pool bounds the neighbours). Samples come
 * from the ellipse that a shorter path must lie in (Gammell et al., Informed RRT*, IROS 2014).
 *
 * Full pool: each new node replaces the worst of a few childless nodes (Adiyatov and Varol, RRT*FN,
 * ICMA 2013).
 *
 * Broken path (rrtstar_mend): what is left of it on both sides grows together again, first near the
 * break. Adiyatov and Varol's RRT*FND (2017) keeps the whole tree instead; here a new search is
 * quicker than checking a whole tree.
 *
 * The result depends on seed and number of samples alone. */
#ifndef RRTSTAR_H
#define RRTSTAR_H

#include <stdbool.h>
#include <stdint.h>

#include "clearance.h"
#include "lattice.h"
#include "rng.h"
#include "tree.h"

typedef struct {
  tree_t tree;
  rng_t rng;
  lattice_t start;
  lattice_t goal;
  int16_t start_node;
  uint16_t steps;    ///< steps of the trees in the last sample, a measure of its cost
  bool connected;    ///< the two trees have met
  float step_cells;  ///< longest new edge until there is a path
  lattice_t focus;   ///< middle of the square that is sampled first after rrtstar_mend
  float focus_cells; ///< half the side of that square; from GRID_SIDE_CELLS on, the whole grid is
                     ///< sampled
  float best_cells;  ///< length of the best path, set by the caller; huge if there is none
} rrtstar_t;

/** Start and goal must be free, and in x more than CLEARANCE_MARGIN_STEPS from the sides of their
 * cells, or nothing may be in sight of them. */
void rrtstar_start(rrtstar_t *rrt, lattice_t start, lattice_t goal, float step_cells,
                   uint32_t seed);
/** Draw one sample. @return true if it made the first path or shortened the tree's path */
bool rrtstar_sample(rrtstar_t *rrt, const clearance_t *clearance);
/** True if the trees have not met and the pool is full. */
bool rrtstar_stuck(const rrtstar_t *rrt);
/** The tree's path from start to goal, without points whose neighbours see each other.
 * @return points written; 0 if there is no path or it needs more than capacity */
int rrtstar_way(const rrtstar_t *rrt, const clearance_t *clearance, lattice_t *way, int capacity);
/** Add a path from start to goal to the tree; each point must see the next. */
void rrtstar_graft(rrtstar_t *rrt, const lattice_t *way, int count);
/** Replace the whole tree by a path from start to goal. */
void rrtstar_restart_from(rrtstar_t *rrt, const lattice_t *way, int count);
/** After rrtstar_start: begin with what is left of a broken path, the first `before` pieces on the
 * side of the start and the last `after` on the side of the goal, and sample between them first. */
void rrtstar_mend(rrtstar_t *rrt, const lattice_t *way, int count, int before, int after);

#endif
