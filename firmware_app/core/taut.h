// SPDX-License-Identifier: GPL-3.0-or-later
/** @file taut.h  Pull a path taut: the shortest path that passes the obstacles on the same sides.
 *
 * Works like a string pulled round posts. Points that a line of sight makes needless are removed;
 * each of the others is replaced by the convex hull of the obstacle corners inside the triangle of
 * the point and its neighbours. Idea: Hershberger and Snoeyink, Computing minimum length paths of a
 * given homotopy class, 1994. Their funnel over a triangulation is not used: corners are read from
 * the clearance bits as needed. One point is treated per step. */
#ifndef TAUT_H
#define TAUT_H

#include <stdbool.h>
#include <stdint.h>

#include "clearance.h"
#include "lattice.h"

enum { TAUT_POINTS = 64 };

/** Passes over the path: shortcuts, the first time also from the goal backwards; then hulls. */
typedef enum { TAUT_SHORTCUT, TAUT_SHORTCUT_BACK, TAUT_HULLS, TAUT_DONE } taut_stage_t;

typedef struct {
  lattice_t points[TAUT_POINTS]; ///< each in sight of the next, after every step
  uint8_t count;
  uint8_t at;     ///< index of the point to be treated next
  uint8_t passes; ///< number of finished passes of TAUT_HULLS
  bool changed;   ///< this pass has moved a point
  taut_stage_t stage;
} taut_t;

/** Begin with the path in taut->points. */
void taut_start(taut_t *taut, int count);
/** Treat one point. @return true once the path is taut */
bool taut_step(taut_t *taut, const clearance_t *clearance);

#endif
