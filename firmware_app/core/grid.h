// SPDX-License-Identifier: GPL-3.0-or-later
/** @file grid.h  Occupancy grid of 128 x 128 four-bit log-odds cells, with obstacle points.
 *
 * Source: Thrun, Burgard, Fox, Probabilistic Robotics (2005), table 9.1. The cone of a
 * time-of-flight sensor is drawn as a fan of rays (traversal by Amanatides and Woo, 1987); the
 * beam-width model of table 9.2 is not implemented.
 *
 * Cell values: 0 unknown (never observed), 1..7 free, 8..15 occupied. Bit 3 alone says "occupied",
 * so that 32 cells are classified in a few word operations.
 *
 * Obstacle points: at most one per occupied cell, on a lattice of 1/8 cell. Each further hit
 * refines the point; it is removed when its cell is no longer occupied. The points are kept in a
 * 4-way set-associative table. When a set is full, the point with the fewest hits is displaced:
 * its cell stays occupied, or becomes free if its obstacle may be passing (grid_points.c).
 *
 * Frame: map. Cell (ix, iy) covers origin + [ix, ix + 1) x [iy, iy + 1) cells. Cells and points
 * take 10,240 bytes. */
#ifndef GRID_H
#define GRID_H

#include <stdbool.h>
#include <stdint.h>

#include "geometry.h"
#include "scan.h"

enum {
  GRID_SIDE_CELLS = 128,
  GRID_CELLS = GRID_SIDE_CELLS * GRID_SIDE_CELLS,
  GRID_ROW_WORDS = GRID_SIDE_CELLS / 8,  ///< words of a row of four-bit cells
  GRID_BIT_WORDS = GRID_SIDE_CELLS / 32, ///< words of a row with one bit per cell
  GRID_UNKNOWN = 0,
  GRID_FREE_MIN = 1,
  GRID_FADED = 4, ///< value of a cell after the passing obstacle in it has faded
  GRID_OCCUPIED_MIN = 8,
  GRID_VALUE_MAX = 15,
  GRID_POINT_WAYS = 4, ///< points per set of the table
  GRID_POINTS = 1024,
  GRID_POINT_SETS = GRID_POINTS / GRID_POINT_WAYS,
  GRID_FADE_MS = 32, ///< between two steps of fading; a round over all sets takes 8.2 s
  GRID_TILE_SIDE_CELLS = 8,
  GRID_TILES_PER_ROW = GRID_SIDE_CELLS / GRID_TILE_SIDE_CELLS,
  GRID_TILES = GRID_TILES_PER_ROW * GRID_TILES_PER_ROW,
  GRID_TILE_WORDS = GRID_TILES / 32,
};

typedef enum { GRID_CELL_UNKNOWN, GRID_CELL_FREE, GRID_CELL_OCCUPIED } grid_state_t;

/** How the end of a beam fits the map. "Firm": see grid_firm. */
typedef enum {
  GRID_ECHO_FAMILIAR,    ///< a firm obstacle is near, which explains the echo
  GRID_ECHO_UNEXPLAINED, ///< no firm obstacle is near, but unknown cells that may hold one
  GRID_ECHO_STRANGE,     ///< everything near was observed, and nothing firm is there
} grid_echo_t;

typedef struct {
  int ix;
  int iy;
} grid_cell_t;

typedef struct {
  uint8_t hit;        ///< added to the value of the cell in which a beam ended
  uint8_t miss;       ///< subtracted from the value of each cell that a beam passed
  float fan_half_rad; ///< half angle of the fan of rays that clears the cone of a beam
  float fan_margin_m; ///< rays off the axis stop this far short of the echo: the cone's edge may
                      ///< see past the obstacle
} grid_config_t;

typedef struct {
  uint32_t cells[GRID_CELLS / 8]; ///< cell ix of a row: bits 4 (ix % 8) of word ix / 8
  uint16_t points[GRID_POINTS];   ///< see grid_points.c
  /** Rows in which a cell became or ceased to be occupied; clearance_mark() reads and clears it. */
  uint32_t changed_rows[GRID_SIDE_CELLS / 32];
  /** Tiles whose states or points changed; mapstream_next() reads and clears it. */
  uint32_t changed_tiles[GRID_TILE_WORDS];
  grid_config_t cfg;
  vec2_t origin_m; ///< lower left corner of cell (0, 0)
  float cell_m;
  float cells_per_m;
  uint16_t known;    ///< number of cells that are not unknown
  uint8_t faded_set; ///< set of points that the last step of fading treated
  bool sweeping;     ///< the drone hovers and looks to and fro: beams also clear isolated, weakly
                     ///< supported obstacles, beside their axes and beyond no_return_clear_m
} grid_t;

grid_config_t grid_config_default(void);

/** Empty grid centred at centre_m (map frame). cell_m is clamped to [0.02, 0.5]. */
void grid_init(grid_t *grid, const grid_config_t *cfg, vec2_t centre_m, float cell_m);

/** The cell that contains the point. @return false, with *cell unchanged, if the point lies outside
 * the grid or is not finite */
bool grid_locate(const grid_t *grid, vec2_t point_m, grid_cell_t *cell);
/** A map position in cells from the grid's lower left corner, not rounded; may lie outside. */
vec2_t grid_to_cells(const grid_t *grid, vec2_t point_m);
vec2_t grid_to_metres(const grid_t *grid, vec2_t point_cells);
vec2_t grid_centre_m(const grid_t *grid, grid_cell_t cell);

/** Index of the tile that contains a cell of the grid. */
int grid_tile(int ix, int iy);
/** Value of a cell, 0..15; 0 outside the grid. */
int grid_value(const grid_t *grid, int ix, int iy);
grid_state_t grid_state(const grid_t *grid, int ix, int iy);
/** Overwrite the value of one cell (map import, fading, tests). */
void grid_set_value(grid_t *grid, int ix, int iy, int value);

/** Make occupied cells of at most this value unknown again: too few hits support them. */
void grid_doubt(grid_t *grid, int value_max);

/** Draw one set of ranges, measured with the body at map_pose, into the grid. Beams are clipped at
 * the border. A beam whose range is not a number, negative or longer than any sensor's draws
 * nothing. The fans that clear free space spare the cells in which a beam of the same set ended.
 * @return number of cells whose state (unknown, free, occupied) changed */
int grid_insert(grid_t *grid, const scan_frame_t *frame, pose2_t map_pose);

/** Occupied cells of row iy as bits: cell ix is bit ix % 32 of bits[ix / 32]. A row outside the
 * grid is empty. */
void grid_occupied_row(const grid_t *grid, int iy, uint32_t bits[GRID_BIT_WORDS]);
/** The columns first..last as such bits; columns outside the grid are left out. */
void grid_columns(int first, int last, uint32_t bits[GRID_BIT_WORDS]);
/** Grow the set bits of a row by one cell to the left and to the right. */
void grid_widen_row(uint32_t bits[GRID_BIT_WORDS]);
/** Observed cells of row iy, in the form of grid_occupied_row. */
void grid_known_row(const grid_t *grid, int iy, uint32_t bits[GRID_BIT_WORDS]);

/** True if the segment, widened by half_width_m to both sides, crosses observed cells only. Checked
 * along parallel lines less than a cell apart, so a cell that it merely grazes may be missed. */
bool grid_segment_known(const grid_t *grid, vec2_t a_m, vec2_t b_m, float half_width_m);

/** How the end of a beam fits the cells within reach_cells of it, to all sides. */
grid_echo_t grid_classify_echo(const grid_t *grid, vec2_t end_m, int reach_cells);

/** True if the obstacle in this occupied cell is well supported: it had three hits or more, or has
 * no point in the table that counts them. */
bool grid_firm(const grid_t *grid, int ix, int iy);
/** One step of fading, to be called each tick. The steps go round the sets of the point table; a
 * passing obstacle that was not hit for a whole round is removed and its cell becomes free.
 * @return true if one was removed */
bool grid_fade(grid_t *grid, uint32_t time_ms);

/** Obstacle point of a cell, map frame. @return false if it has none */
bool grid_point(const grid_t *grid, int ix, int iy, vec2_t *point_m);
/** Position of the point in its cell in eighths: x in bits 0-2, y in bits 3-5; -1 without a point.
 */
int grid_point_eighths(const grid_t *grid, int ix, int iy);
/** The same of an occupied cell whose obstacle stays, or its middle where there is no point; -1 if
 * the obstacle may be passing. */
int grid_lasting_eighths(const grid_t *grid, int ix, int iy);
/** Refine the point of the cell, or create it, by a hit at point_m.
 * @param passing  for a new point: its obstacle may be passing */
void grid_points_add(grid_t *grid, grid_cell_t cell, vec2_t point_m, bool passing);
void grid_points_remove(grid_t *grid, grid_cell_t cell);

#endif
