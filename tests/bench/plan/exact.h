// SPDX-License-Identifier: GPL-3.0-or-later
/** @file exact.h  Exact plane geometry over a map of blocked cells, for the planning bench.
 *  Cell (x, y) is the closed unit square [x, x + 1] x [y, y + 1]; what lies outside the map is
 * blocked. A way is free if it never enters the interior of the union of the blocked cells (it may
 * graze them) and never passes a corner at which two blocked cells touch diagonally. Points are
 * integers, EXACT_UNIT to a cell: every float32 of 2 cells and more is one of them. */
#ifndef EXACT_H
#define EXACT_H

#include <stdbool.h>
#include <stdint.h>

enum { EXACT_UNIT = 4194304 };

typedef struct {
  int64_t x, y;
} exact_point_t;

typedef enum { EXACT_PLAIN, EXACT_CONVEX, EXACT_DOUBLE } exact_corner_t;

typedef struct {
  int width, height;
  uint8_t *cells;   ///< not 0: blocked
  uint8_t *corners; ///< kind of each of the (width + 1) * (height + 1) corners
} exact_map_t;

/** cells holds width * height bytes, row by row, at most 250 x 250. 0 without memory. */
exact_map_t *exact_map_new(const uint8_t *cells, int width, int height);
void exact_map_free(exact_map_t *map);
bool exact_blocked(const exact_map_t *map, int64_t x, int64_t y);

/** The point nearest to a place in cells. */
exact_point_t exact_point(double x_cells, double y_cells);
/** Whether a segment is free, the blocked cells made smaller by `shrink` at every side. */
bool exact_segment_free(const exact_map_t *map, exact_point_t a, exact_point_t b, int64_t shrink);

/** Length in cells of a way of count points (x, y in turns), or -1 - i if its leg i is not free. */
double exact_way_length(const exact_map_t *map, const double *xy_cells, int count, int64_t shrink);
/** Least distance in cells between a way and any blocked cell; blocked are the cells of the map
 * alone. */
double exact_way_clearance(const exact_map_t *map, const double *xy_cells, int count);

/** Length in cells of the shortest way between two places, by A* over the visibility graph of the
 * convex corners; -1 if there is none. Waypoints go to xy_cells (0 if not wanted), as many as
 * capacity allows, their number to *count. */
double exact_optimum(const exact_map_t *map, exact_point_t start, exact_point_t goal,
                     double *xy_cells, int capacity, int *count);

/** Mark the cells that 4-neighbour steps reach. @return how many */
int exact_reach(const exact_map_t *map, int x, int y, uint8_t *reached);

#endif
