// SPDX-License-Identifier: GPL-3.0-or-later
/** @file ray.h  The cells that a segment crosses, in order.
 *  Source: Amanatides and Woo, A Fast Voxel Traversal Algorithm (1987), with products in place of
 * divisions. Where the segment goes exactly through a corner of cells the step is diagonal, and
 * `corner` says so. */
#ifndef RAY_H
#define RAY_H

#include <stdbool.h>

#include "geometry.h"

typedef struct {
  int ix, iy;         ///< the present cell
  int step_x, step_y; ///< -1 or 1
  int left_x, left_y; ///< steps still to do
  float t_x, t_y;     ///< when the next side is met, in units of |dx| |dy|
  float dt_x, dt_y;
  bool corner; ///< the last step was diagonal
} ray_t;

/** Coordinates in cells, at most 1e6 in size. */
ray_t ray_start(vec2_t a_cells, vec2_t b_cells);
/** Go on to the next cell; false at the end. */
bool ray_next(ray_t *ray);

#endif
