// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
#include "mapstream.h"

#include <string.h>

enum {
  SWEEP_EVERY = 4,
  ROTATION_STEP = 13,
  TAKEN_FREE = 4, ///< value of a cell that a piece calls free
  TAKEN_OCCUPIED = 11,
  EIGHTHS = 8, ///< of a cell
};

void mapstream_init(mapstream_t *stream) {
  memset(stream, 0, sizeof *stream);
}

/** The next changed tile after the cursor, -1 if none. */
static int changed_tile(const mapstream_t *stream, const grid_t *grid) {
  for (int i = 1; i <= GRID_TILES; i++) {
    int tile = (stream->cursor + i) % GRID_TILES;
    if ((grid->changed_tiles[tile / 32] >> (tile % 32) & 1u) != 0u) {
      return tile;
    }
  }
  return -1;
}

static int choose_tile(mapstream_t *stream, const grid_t *grid) {
  stream->turn = (uint8_t)((stream->turn + 1u) % SWEEP_EVERY);
  int tile = stream->turn != 0u ? changed_tile(stream, grid) : -1;
  if (tile < 0) {
    // A sweep is as long as the counter: without this step a tile would meet the same rotation
    // again.
    stream->rotation = (uint8_t)(stream->rotation + (stream->sweep == 0u ? ROTATION_STEP : 0u));
    return stream->sweep++;
  }
  stream->cursor = (uint8_t)tile;
  return tile;
}

static grid_cell_t cell_of(int tile, int index) {
  return (grid_cell_t){
      tile % GRID_TILES_PER_ROW * GRID_TILE_SIDE_CELLS + index % GRID_TILE_SIDE_CELLS,
      tile / GRID_TILES_PER_ROW * GRID_TILE_SIDE_CELLS + index / GRID_TILE_SIDE_CELLS};
}

/** Cells and points of a tile. Where points are more than fit, each piece begins with another one.
 */
static void fill(const mapstream_t *stream, const grid_t *grid, wire_map_piece_t *piece) {
  for (int i = 0; i < WIRE_MAP_CELLS; i++) {
    int cell = (i + stream->rotation) % WIRE_MAP_CELLS;
    grid_cell_t at = cell_of(piece->tile, cell);
    piece->states[cell] = (uint8_t)grid_state(grid, at.ix, at.iy);
    int eighths = grid_point_eighths(grid, at.ix, at.iy);
    if (eighths >= 0 && piece->point_count < WIRE_MAP_POINTS) {
      piece->point_cell[piece->point_count] = (uint8_t)cell;
      piece->point_eighths[piece->point_count] = (uint8_t)eighths;
      piece->point_count++;
    }
  }
}

void mapstream_next(mapstream_t *stream, grid_t *grid, uint8_t epoch, uint8_t *bytes) {
  int tile = choose_tile(stream, grid);
  wire_map_piece_t piece = {.tile = (uint8_t)tile, .epoch = epoch};
  stream->rotation = (uint8_t)(stream->rotation + ROTATION_STEP);
  fill(stream, grid, &piece);
  grid->changed_tiles[tile / 32] &= ~(1u << (tile % 32));
  wire_map_encode(&piece, bytes);
}

static float middle_of(int eighth) {
  return ((float)eighth + 0.5f) / (float)EIGHTHS;
}

/** A cell's obstacle point, as a piece tells it. */
static void take_point(grid_t *grid, grid_cell_t cell, int eighths) {
  if (grid_state(grid, cell.ix, cell.iy) == GRID_CELL_OCCUPIED) {
    vec2_t in_cells = {(float)cell.ix + middle_of(eighths % EIGHTHS),
                       (float)cell.iy + middle_of(eighths / EIGHTHS)};
    grid_points_add(grid, cell, grid_to_metres(grid, in_cells), false);
  }
}

bool mapstream_take(grid_t *grid, uint8_t epoch, const uint8_t *bytes) {
  static const int values[] = {GRID_UNKNOWN, TAKEN_FREE, TAKEN_OCCUPIED};
  wire_map_piece_t piece;
  if (!wire_map_decode(bytes, &piece) || piece.epoch != epoch) {
    return false;
  }
  for (int i = 0; i < WIRE_MAP_CELLS; i++) {
    grid_cell_t cell = cell_of(piece.tile, i);
    if (grid_state(grid, cell.ix, cell.iy) != piece.states[i]) {
      grid_set_value(grid, cell.ix, cell.iy, values[piece.states[i]]);
    }
  }
  for (int i = 0; i < piece.point_count; i++) {
    take_point(grid, cell_of(piece.tile, piece.point_cell[i]), piece.point_eighths[i]);
  }
  return true;
}
