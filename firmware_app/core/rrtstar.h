// SPDX-License-Identifier: GPL-3.0-or-later
/** @file rrtstar.h  Bidirectional, then optimal and informed random trees in a fixed pool.
 *  Until there is a way two trees grow towards each other (Kuffner and LaValle, RRT-Connect, ICRA
 * 2000). They become one tree on the goal, which RRT* improves (Karaman and Frazzoli,
 * Sampling-based Algorithms for Optimal Motion Planning, IJRR 2011, algorithm 6, with a fixed
 * radius in place of the shrinking one of eq. (11): the pool bounds the neighbours), sampling the
 * ellipse that a shorter way must lie in (Gammell et al., Informed RRT*, IROS 2014). When the pool
 * is full a childless node off the way goes for each new one, the worst of a few (Adiyatov and
 * Varol, RRT*FN, ICMA 2013). Where a way has broken, what is left of it on both sides grows
 * together again, first near the break (rrtstar_mend; after their RRT*FND, 2017, which keeps the
 * whole tree: here a search anew is done before a whole tree is checked). The result depends on
 * seed and number of samples alone. */
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
  uint16_t steps; ///< of the trees in the last sample: what it cost
  bool connected;
  float step_cells;  ///< longest new edge until there is a way
  lattice_t focus;   ///< until there is a way samples come from about here,
  float focus_cells; ///< within this, which grows
  float best_cells;  ///< length of the best way known, here or to the caller; huge without one
} rrtstar_t;

/** Start and goal must be free and keep away from blocked cells (clearance_settle). */
void rrtstar_start(rrtstar_t *rrt, lattice_t start, lattice_t goal, float step_cells,
                   uint32_t seed);
/** Draw one sample. @return true if there is a way now and it is shorter than before */
bool rrtstar_sample(rrtstar_t *rrt, const clearance_t *clearance);
/** True when no way was found and the pool has no room to look on. */
bool rrtstar_stuck(const rrtstar_t *rrt);
/** The way from start to goal, points in sight of the one before the last left out.
 *  @return points written, 0 if there is none or it needs more than capacity */
int rrtstar_way(const rrtstar_t *rrt, const clearance_t *clearance, lattice_t *way, int capacity);
/** Take in a way from start to goal, each point in sight of the next. */
void rrtstar_graft(rrtstar_t *rrt, const lattice_t *way, int count);
/** Forget all but a way from start to goal. */
void rrtstar_restart_from(rrtstar_t *rrt, const lattice_t *way, int count);
/** After rrtstar_start: let both sides begin with what is left of a broken way, `before` pieces
 * from the start on and `after` up to the goal, and look between them first. */
void rrtstar_mend(rrtstar_t *rrt, const lattice_t *way, int count, int before, int after);

#endif
