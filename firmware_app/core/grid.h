// SPDX-License-Identifier: GPL-3.0-or-later
/** @file grid.h  Occupancy grid of 128 x 128 four-bit log-odds cells, with one obstacle point per
 * occupied cell. Source: Thrun, Burgard, Fox, Probabilistic Robotics (2005), table 9.1, with the
 * cone of a time-of-flight sensor as a fan of rays (Amanatides and Woo 1987 traversal). Not
 * implemented: the beam-width model of table 9.2. Cell values: 0 never observed, 1..7 believed
 * free, 8..15 believed occupied; bit 3 alone says "occupied", so that 32 cells are classified in a
 * few word operations. Points: at most one per cell, on a lattice of 1/8 cell. A repeated hit
 * refines it; it goes when its cell is no longer believed occupied. Kept in a 4-way set-associative
 * table; when a set is full the weakest point yields (its cell stays occupied). Frame: the map's.
 * Cell (ix, iy) covers origin + [ix, ix + 1) x [iy, iy + 1) cells; 10,240 bytes and a little. */
#ifndef GRID_H
#define GRID_H

#include <stdbool.h>
#include <stdint.h>

#include "geometry.h"
#include "scan.h"

enum {
  GRID_SIDE_CELLS = 128,
  GRID_CELLS = GRID_SIDE_CELLS * GRID_SIDE_CELLS,
  GRID_ROW_WORDS = GRID_SIDE_CELLS / 8, ///< 8 four-bit cells a word
  GRID_BIT_WORDS = GRID_SIDE_CELLS / 32,
  GRID_UNKNOWN = 0,
  GRID_FREE_MIN = 1,
  GRID_FADED = 4, ///< of a cell through which somebody passed
  GRID_OCCUPIED_MIN = 8,
  GRID_VALUE_MAX = 15,
  GRID_POINT_WAYS = 4,
  GRID_POINTS = 1024,
  GRID_POINT_SETS = GRID_POINTS / GRID_POINT_WAYS,
  GRID_FADE_MS = 32, ///< a step of fading; a round takes 8.2 s
  GRID_TILE_SIDE_CELLS = 8,
  GRID_TILES_PER_ROW = GRID_SIDE_CELLS / GRID_TILE_SIDE_CELLS,
  GRID_TILES = GRID_TILES_PER_ROW * GRID_TILES_PER_ROW,
  GRID_TILE_WORDS = GRID_TILES / 32,
};

typedef enum { GRID_CELL_UNKNOWN, GRID_CELL_FREE, GRID_CELL_OCCUPIED } grid_state_t;

typedef enum {
  GRID_ECHO_FAMILIAR, ///< something that lasts is near
  GRID_ECHO_UNTOLD,   ///< it may be what was not observed yet
  GRID_ECHO_STRANGE,  ///< all around was observed, and free
} grid_echo_t;

typedef struct {
  int ix;
  int iy;
} grid_cell_t;

typedef struct {
  uint8_t hit;        ///< added to the cell in which a beam ended
  uint8_t miss;       ///< taken from each cell that a beam passed
  float fan_half_rad; ///< free space is drawn this far to both sides of a beam: it is a cone
  float fan_margin_m; ///< rays off the axis stop this much before the echo: the cone's edge may see
                      ///< past it
} grid_config_t;

typedef struct {
  uint32_t cells[GRID_CELLS / 8]; ///< cell ix of a row: bits 4 (ix % 8) of word ix / 8
  uint16_t points[GRID_POINTS];   ///< see grid_points.c
  uint32_t
      changed_rows[GRID_SIDE_CELLS / 32];  ///< rows in which a cell became or ceased to be occupied
  uint32_t changed_tiles[GRID_TILE_WORDS]; ///< tiles whose picture changed
  grid_config_t cfg;
  vec2_t origin_m; ///< lower left corner of cell (0, 0)
  float cell_m;
  float cells_per_m;
  uint16_t known;    ///< cells observed at least once
  uint8_t faded_set; ///< of the points, in the last step of fading
  bool sweeping;     ///< beams sweep about: what they miss counts beside their axes, and far away
} grid_t;

grid_config_t grid_config_default(void);

/** Empty grid whose middle is at centre_m. cell_m in [0.02, 0.5]. */
void grid_init(grid_t *grid, const grid_config_t *cfg, vec2_t centre_m, float cell_m);

/** Cell that contains the point; false (and *cell unchanged) outside the grid or if not finite. */
bool grid_locate(const grid_t *grid, vec2_t point_m, grid_cell_t *cell);
/** Map position in cells, not rounded; may lie outside. */
vec2_t grid_to_cells(const grid_t *grid, vec2_t point_m);
vec2_t grid_to_metres(const grid_t *grid, vec2_t point_cells);
vec2_t grid_centre_m(const grid_t *grid, grid_cell_t cell);

/** Number of the tile that a cell of the grid lies in. */
int grid_tile(int ix, int iy);
/** 0..15; outside the grid 0. */
int grid_value(const grid_t *grid, int ix, int iy);
grid_state_t grid_state(const grid_t *grid, int ix, int iy);
/** Set one value (import, tests). */
void grid_set_value(grid_t *grid, int ix, int iy, int value);

/** Let occupied cells of at most this value be unknown again: too little speaks for them. */
void grid_doubt(grid_t *grid, int value_max);

/** Fold one measured set, its body at map_pose, into the grid. Beams are clipped at the border.
 *  A beam whose range is no distance, or one that no sensor measures, draws nothing.
 *  A cell that a beam of this set ended in is not cleared by the set's other rays.
 *  @return cells whose state (unknown, free, occupied) changed */
int grid_insert(grid_t *grid, const scan_frame_t *frame, pose2_t map_pose);

/** Occupied cells of row iy as bits, ix = 0 at bit 0 of bits[0]. A row outside the grid is empty.
 */
void grid_occupied_row(const grid_t *grid, int iy, uint32_t bits[GRID_BIT_WORDS]);
/** The columns first..last of a row, likewise; what lies outside the grid is left out. */
void grid_columns(int first, int last, uint32_t bits[GRID_BIT_WORDS]);
/** Set bits of a row also one place to the left and right of each. */
void grid_widen_row(uint32_t bits[GRID_BIT_WORDS]);
/** Cells of row iy that were observed, likewise. */
void grid_known_row(const grid_t *grid, int iy, uint32_t bits[GRID_BIT_WORDS]);

/** True if every cell that the segment, widened to both sides by half_width_m, touches has been
 * observed. */
bool grid_segment_known(const grid_t *grid, vec2_t a_m, vec2_t b_m, float half_width_m);

/** How the end of a beam fits what is known for so many cells around. */
grid_echo_t grid_judge(const grid_t *grid, vec2_t end_m, int reach_cells);

/** What stands in this occupied cell came where there was nothing, and may be gone soon. */
bool grid_firm(const grid_t *grid, int ix, int iy);
/** One step of the rounds over all that may be passing, to be taken each tick: what was not met for
 * a whole round is gone, its cell is free. @return true if something was */
bool grid_fade(grid_t *grid, uint32_t time_ms);

/** The obstacle point of a cell; false if it has none. */
bool grid_point(const grid_t *grid, int ix, int iy, vec2_t *point_m);
/** Its place in the cell in eighths, x in bits 0-2, y in bits 3-5; -1 if it has none. */
int grid_point_eighths(const grid_t *grid, int ix, int iy);
/** Likewise of an occupied cell, its middle where it has no point; -1 if what stands there may be
 * passing. */
int grid_lasting_eighths(const grid_t *grid, int ix, int iy);
/** Refine (or make) the point of the cell by a hit at point_m.
 *  @param passing  if it is made: what stands there may be passing */
void grid_points_add(grid_t *grid, grid_cell_t cell, vec2_t point_m, bool passing);
void grid_points_remove(grid_t *grid, grid_cell_t cell);

#endif
