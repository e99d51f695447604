// SPDX-License-Identifier: GPL-3.0-or-later
/** @file ray.h  The cells that a segment crosses, in order.
 *
 * Source: Amanatides and Woo, A Fast Voxel Traversal Algorithm (1987), with the ray parameter
 * scaled by |dx| |dy| so that no division is needed. Where the segment passes exactly through a
 * corner of cells, the step is diagonal and `corner` is set. */
#ifndef RAY_H
#define RAY_H

#include <stdbool.h>

#include "geometry.h"

typedef struct {
  int ix, iy;         ///< the current cell
  int step_x, step_y; ///< -1 or 1
  int left_x, left_y; ///< steps still to take
  float t_x, t_y;     ///< ray parameter, times |dx| |dy|, at the next cell side in x and in y
  float dt_x, dt_y;   ///< its increment from one cell side to the next
  bool corner;        ///< the last step was diagonal
} ray_t;

/** The ray from a to b, in the cell of a. Coordinates in cells, magnitude at most 1e6. */
ray_t ray_start(vec2_t a_cells, vec2_t b_cells);
/** Advance to the next cell. @return false if the ray was already in its last cell */
bool ray_next(ray_t *ray);

#endif
