// SPDX-License-Identifier: GPL-3.0-or-later
/** @file lattice.h  Integer positions in steps of 1/256 cell, as the planners use them.
 *
 * With integers, tests of order and of side are exact, and a position takes four bytes. Only
 * lengths are float. */
#ifndef LATTICE_H
#define LATTICE_H

#include <stdbool.h>
#include <stdint.h>

#include "geometry.h"

enum { LATTICE_BITS = 8, LATTICE_PER_CELL = 1 << LATTICE_BITS, LATTICE_MAX = 32767 };

typedef struct {
  int16_t x, y; ///< 1/256 cell, 0..LATTICE_MAX
} lattice_t;

/** The lattice point at a position in cells, rounded down so that it stays in the same cell and
 * clamped to the grid. NaN gives 0. */
lattice_t lattice_from_cells(vec2_t cells);
vec2_t lattice_to_cells(lattice_t p);
bool lattice_equal(lattice_t a, lattice_t b);
/** Euclidean distance [cells]. */
float lattice_distance(lattice_t a, lattice_t b);
/** Twice the signed area of the triangle o, a, b; positive if it runs counter-clockwise. Exact. */
int32_t lattice_cross(lattice_t o, lattice_t a, lattice_t b);
/** Reverse the order of the points, in place. */
void lattice_reverse(lattice_t *points, int count);
/** Length of the polyline [cells]. */
float lattice_length(const lattice_t *points, int count);

#endif
