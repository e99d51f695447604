// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
#include "mapstream.h"

#include <string.h>

enum { SWEEP_EVERY = 4, ROTATION_STEP = 13 };

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

/** Cells and points of a tile. Where points are more than fit, each piece begins with another one.
 */
static void fill(const mapstream_t *stream, const grid_t *grid, wire_map_piece_t *piece) {
  int ix0 = piece->tile % GRID_TILES_PER_ROW * GRID_TILE_SIDE_CELLS;
  int iy0 = piece->tile / GRID_TILES_PER_ROW * GRID_TILE_SIDE_CELLS;
  for (int i = 0; i < WIRE_MAP_CELLS; i++) {
    int cell = (i + stream->rotation) % WIRE_MAP_CELLS;
    int ix = ix0 + cell % GRID_TILE_SIDE_CELLS;
    int iy = iy0 + cell / GRID_TILE_SIDE_CELLS;
    piece->states[cell] = (uint8_t)grid_state(grid, ix, iy);
    int eighths = grid_point_eighths(grid, ix, iy);
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
