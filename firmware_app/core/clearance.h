// SPDX-License-Identifier: GPL-3.0-or-later
/** @file clearance.h  The cells in which the drone's centre may not be: a bit a cell, 2,048 bytes.
 *  Blocked = within the clearance radius of an occupied cell, or outside the fence or the grid.
 * Planners, route and exploration share it. Unknown cells are not blocked here: a plan may be
 * optimistic, flying is not (route.h). It follows the grid row by row: a changed cell makes the
 * rows it can reach stale, clearance_refresh() rebuilds stale rows from the occupied bits, so that
 * the layer always equals one built from scratch. Convention: the distance is from cell square to
 * cell square (a blocked cell may be touched nowhere), and a segment may not squeeze between two
 * blocked cells that touch at a corner. */
#ifndef CLEARANCE_H
#define CLEARANCE_H

#include <stdbool.h>
#include <stdint.h>

#include "geometry.h"
#include "grid.h"
#include "lattice.h"

enum {
  CLEARANCE_REACH_MAX = 12,
  CLEARANCE_MARGIN_STEPS = 2, ///< sideways, that a line of sight keeps from blocked cells
  CLEARANCE_CORNER_STEPS = 8, ///< in x and y, by which a way passes outside a corner
};

/** Of the four cells that meet in a convex corner one is blocked; which one. */
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
  uint8_t half_width[CLEARANCE_REACH_MAX + 1];    ///< of the disc, in cells, by row distance
  uint8_t reach;                                  ///< of the disc, in rows
  int16_t fence_x0, fence_y0, fence_x1, fence_y1; ///< cells inside, both ends included
  bool observed_only;                             ///< what was never observed is blocked, too
} clearance_t;

/** Everything stale. radius_m is clipped to CLEARANCE_REACH_MAX cells; the fence is given by two
 * map corners. */
void clearance_init(clearance_t *clearance, const grid_t *grid, float radius_m, vec2_t fence_min_m,
                    vec2_t fence_max_m);
/** Another radius or fence. A row is as it was until it is refreshed. */
void clearance_configure(clearance_t *clearance, const grid_t *grid, float radius_m,
                         vec2_t fence_min_m, vec2_t fence_max_m);

/** Block what was never observed too, or no longer; what is observed later stays blocked until its
 * row is rebuilt. */
void clearance_observed_only(clearance_t *clearance, bool on);
/** Take over which rows of the grid changed (and clear that list there). */
void clearance_mark(clearance_t *clearance, grid_t *grid);
/** Rebuild up to max_rows stale rows. @return rows still stale */
int clearance_refresh(clearance_t *clearance, const grid_t *grid, int max_rows);

/** Outside the grid is blocked. */
bool clearance_blocked(const clearance_t *clearance, int ix, int iy);
/** Same for a position in cells. */
bool clearance_blocked_at(const clearance_t *clearance, vec2_t point_cells);
/** True if no cell is blocked that is at most reach cells away from the point's. */
bool clearance_square_free(const clearance_t *clearance, vec2_t point_cells, int reach);
/** True if the segment (in cells) stays in free cells. Exact traversal; cost grows with the cells
 * crossed. */
bool clearance_segment_free(const clearance_t *clearance, vec2_t a_cells, vec2_t b_cells);
/** The same for planners, on the lattice and many times as fast: it follows rows of bits, not
 * cells. It keeps a margin of CLEARANCE_MARGIN_STEPS, so that a way that was found with it stays
 * free when its points are rounded; it may say no where the segment passes a blocked cell nearer
 * than that.
 */
bool clearance_sees(const clearance_t *clearance, lattice_t a, lattice_t b);
/** Convex corners of the blocked region among the vertices (32 word + i, iy), i = bit, where rows
 *  iy - 1 and iy meet, iy >= 1, by kind. @return all kinds together */
uint32_t clearance_corners(const clearance_t *clearance, int iy, int word,
                           uint32_t kinds[CLEARANCE_CORNER_KINDS]);
/** Where a shortest way passes a corner: a little outside of it. */
lattice_t clearance_past_corner(int ix, int iy, clearance_corner_t kind);
/** Centre of the free cell nearest to the point, within max_cells; false if there is none. */
bool clearance_nearest_free(const clearance_t *clearance, vec2_t point_cells, int max_cells,
                            vec2_t *free_cells);

#endif
