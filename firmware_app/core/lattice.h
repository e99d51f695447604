// SPDX-License-Identifier: GPL-3.0-or-later
/** @file lattice.h  Positions on a lattice of 1/256 cell, on which planners work.
 *  Whole numbers: a test of order or side is exact, and a node takes four bytes. Only lengths are
 * float. */
#ifndef LATTICE_H
#define LATTICE_H

#include <stdbool.h>
#include <stdint.h>

#include "geometry.h"

enum { LATTICE_BITS = 8, LATTICE_PER_CELL = 1 << LATTICE_BITS, LATTICE_MAX = 32767 };

typedef struct {
  int16_t x, y; ///< 1/256 cell, 0..LATTICE_MAX
} lattice_t;

/** The lattice point at a position in cells, rounded down so that it lies in the same cell; outside
 * the grid, the nearest inside. NaN is 0. */
lattice_t lattice_from_cells(vec2_t cells);
vec2_t lattice_to_cells(lattice_t p);
bool lattice_equal(lattice_t a, lattice_t b);
/** [cells] */
float lattice_distance(lattice_t a, lattice_t b);
/** Twice the area of the triangle o, a, b, positive if it runs counter-clockwise. Exact. */
int32_t lattice_cross(lattice_t o, lattice_t a, lattice_t b);
/** The points in opposite order. */
void lattice_reverse(lattice_t *points, int count);
/** [cells] */
float lattice_length(const lattice_t *points, int count);

#endif
