// SPDX-License-Identifier: GPL-3.0-or-later
/** @file taut.h  Pull a way taut: the shortest way that passes the obstacles on the same sides.
 *  A string round posts: way points that a line of sight makes needless go, each other one is
 * replaced by the convex hull of the obstacle corners in the triangle of it and its neighbours
 * (Hershberger and Snoeyink, Computing minimum length paths of a given homotopy class, 1994, for
 * the idea; their funnel over a triangulation is not used: corners are read from the clearance bits
 * as needed). Sliced by way points. */
#ifndef TAUT_H
#define TAUT_H

#include <stdbool.h>
#include <stdint.h>

#include "clearance.h"
#include "lattice.h"

enum { TAUT_POINTS = 64 };

typedef enum { TAUT_SHORTCUT, TAUT_SHORTCUT_BACK, TAUT_HULLS, TAUT_DONE } taut_stage_t;

typedef struct {
  lattice_t points[TAUT_POINTS]; ///< each in sight of the next, at every stage
  uint8_t count;
  uint8_t at;     ///< the point in turn
  uint8_t passes; ///< of hulls
  bool changed;   ///< in this pass
  taut_stage_t stage;
} taut_t;

/** Begin with the points that stand in taut->points. */
void taut_start(taut_t *taut, int count);
/** Treat one way point. @return true when the way is taut */
bool taut_step(taut_t *taut, const clearance_t *clearance);

#endif
