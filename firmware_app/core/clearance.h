// SPDX-License-Identifier: GPL-3.0-or-later
/** @file clearance.h  Obstacles inflated by the drone's clearance: one bit per cell, 2,048 bytes.
 *
 * The drone's centre may not be in a blocked cell. Blocked = within the clearance radius of an
 * occupied cell, or outside the geofence or the grid. Planners, route and exploration share this
 * layer. Unknown cells are not blocked, except on the way home (clearance_observed_only): a plan
 * may be optimistic, flying is not (route.h).
 *
 * The layer follows the grid row by row. A changed cell makes the rows within the radius stale, and
 * clearance_refresh() rebuilds stale rows from the occupied bits, so that the result always equals
 * a layer built from scratch.
 *
 * Conventions: distances are from cell square to cell square, and a segment may not squeeze between
 * two blocked cells that touch at a corner. */
#ifndef CLEARANCE_H
#define CLEARANCE_H

#include <stdbool.h>
#include <stdint.h>

#include "geometry.h"
#include "grid.h"
#include "lattice.h"

enum {
  CLEARANCE_REACH_MAX = 12,   ///< largest clearance radius [cells]
  CLEARANCE_MARGIN_STEPS = 2, ///< margin in x of a line of sight to blocked cells [1/256 cell]
  CLEARANCE_CORNER_STEPS = 8, ///< how far outside a corner a path passes, in x and y [1/256 cell]
};

/** Which of the four cells that meet in a convex corner is the blocked one. */
typedef enum {
  CLEARANCE_CORNER_LOWER_LEFT,
  CLEARANCE_CORNER_LOWER_RIGHT,
  CLEARANCE_CORNER_UPPER_LEFT,
  CLEARANCE_CORNER_UPPER_RIGHT,
  CLEARANCE_CORNER_KINDS,
} clearance_corner_t;

typedef struct {
  uint32_t bits[GRID_SIDE_CELLS * GRID_BIT_WORDS];
  uint32_t stale_rows[GRID_SIDE_CELLS / 32];
  uint8_t half_width[CLEARANCE_REACH_MAX + 1];    ///< of the disc [cells], by distance in rows
  uint8_t reach;                                  ///< of the disc [rows]
  int16_t fence_x0, fence_y0, fence_x1, fence_y1; ///< cells inside the geofence, ends included
  bool observed_only;                             ///< unknown cells are blocked too
} clearance_t;

/** All rows stale. radius_m is clamped to CLEARANCE_REACH_MAX cells; the geofence is given by its
 * smallest and largest corner in the map frame. */
void clearance_init(clearance_t *clearance, const grid_t *grid, float radius_m, vec2_t fence_min_m,
                    vec2_t fence_max_m);
/** Change radius and geofence. All rows become stale and keep their old bits until refreshed. */
void clearance_configure(clearance_t *clearance, const grid_t *grid, float radius_m,
                         vec2_t fence_min_m, vec2_t fence_max_m);

/** Switch whether unknown cells are blocked too. A cell that is observed later stays blocked until
 * its row is rebuilt for another reason. */
void clearance_observed_only(clearance_t *clearance, bool on);
/** Make the rows stale that the grid's changed rows reach, and clear grid->changed_rows. */
void clearance_mark(clearance_t *clearance, grid_t *grid);
/** Rebuild up to max_rows stale rows. @return rows still stale */
int clearance_refresh(clearance_t *clearance, const grid_t *grid, int max_rows);

/** True if the cell is blocked; cells outside the grid are. */
bool clearance_blocked(const clearance_t *clearance, int ix, int iy);
/** The same for a position in cells. */
bool clearance_blocked_at(const clearance_t *clearance, vec2_t point_cells);
/** True if no cell of the square that reaches `reach` cells from the point's cell is blocked. */
bool clearance_square_free(const clearance_t *clearance, vec2_t point_cells, int reach);
/** True if the segment stays in free cells. Exact; the cost grows with the cells crossed. */
bool clearance_segment_free(const clearance_t *clearance, vec2_t a_cells, vec2_t b_cells);
/** Line of sight between two lattice points, for planners: many times as fast, because it tests
 * whole rows of bits. It keeps CLEARANCE_MARGIN_STEPS in x from blocked cells, so that a path found
 * with it stays free when its points are rounded; a segment that passes nearer is refused. */
bool clearance_sees(const clearance_t *clearance, lattice_t a, lattice_t b);
/** Convex corners of the blocked region among the 32 vertices (32 word + bit, iy) on the line
 * between rows iy - 1 and iy; iy >= 1. kinds[k] gets those of kind k, one bit per vertex.
 * @return the corners of all kinds */
uint32_t clearance_corners(const clearance_t *clearance, int iy, int word,
                           uint32_t kinds[CLEARANCE_CORNER_KINDS]);
/** Where a shortest path passes a corner: CLEARANCE_CORNER_STEPS outside of it in x and y. */
lattice_t clearance_past_corner(int ix, int iy, clearance_corner_t kind);
/** Centre of the free cell nearest to the point, if it is within max_cells. @return false if there
 * is none */
bool clearance_nearest_free(const clearance_t *clearance, vec2_t point_cells, int max_cells,
                            vec2_t *free_cells);

#endif
