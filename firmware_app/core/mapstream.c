// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
#include "mapstream.h"

#include <string.h>

enum {
  SWEEP_EVERY = 4,
  DICE_FACTOR = 25173, ///< of a linear congruential generator: the lowest two bits count to 4
  DICE_STEP = 13849,
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

static int choose_tile(mapstream_t *stream, const grid_t *grid, bool *sweeps) {
  stream->dice = (uint16_t)(stream->dice * DICE_FACTOR + DICE_STEP);
  int tile = stream->dice % SWEEP_EVERY != 0u ? changed_tile(stream, grid) : -1;
  *sweeps = tile < 0;
  return *sweeps ? stream->sweep : tile;
}

static grid_cell_t cell_of(int tile, int index) {
  return (grid_cell_t){
      tile % GRID_TILES_PER_ROW * GRID_TILE_SIDE_CELLS + index % GRID_TILE_SIDE_CELLS,
      tile / GRID_TILES_PER_ROW * GRID_TILE_SIDE_CELLS + index / GRID_TILE_SIDE_CELLS};
}

static void fill(const grid_t *grid, wire_tile_t *tile) {
  for (int i = 0; i < WIRE_MAP_CELLS; i++) {
    grid_cell_t at = cell_of(tile->tile, i);
    tile->states[i] = (uint8_t)grid_state(grid, at.ix, at.iy);
    int eighths =
        tile->states[i] == GRID_CELL_OCCUPIED ? grid_point_eighths(grid, at.ix, at.iy) : -1;
    tile->eighths[i] = (uint8_t)(eighths < 0 ? WIRE_NO_POINT : eighths);
  }
}

void mapstream_next(mapstream_t *stream, grid_t *grid, uint8_t epoch, uint8_t *bytes) {
  bool sweeps;
  wire_map_t map;
  wire_tile_t tile;
  tile.tile = (uint8_t)choose_tile(stream, grid, &sweeps);
  tile.first_point = (uint8_t)(stream->dice >> 8);
  wire_map_begin(&map, tile.tile, epoch);
  for (fill(grid, &tile); wire_map_add(&map, &tile); fill(grid, &tile)) {
    grid->changed_tiles[tile.tile / 32] &= ~(1u << (tile.tile % 32));
    tile.tile++;
  }
  wire_map_end(&map);
  if (sweeps) {
    bool again = stream->sweep == 0u && stream->dice >= 0x8000u;
    stream->sweep = again ? 0u : tile.tile;
  } else {
    stream->cursor = (uint8_t)(tile.tile - 1u);
  }
  memcpy(bytes, map.bytes, WIRE_MAP_BYTES);
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

static void take_tile(grid_t *grid, const wire_tile_t *tile) {
  static const int values[] = {GRID_UNKNOWN, TAKEN_FREE, TAKEN_OCCUPIED};
  for (int i = 0; i < WIRE_MAP_CELLS; i++) {
    grid_cell_t cell = cell_of(tile->tile, i);
    if (grid_state(grid, cell.ix, cell.iy) != tile->states[i]) {
      grid_set_value(grid, cell.ix, cell.iy, values[tile->states[i]]);
    }
    if (tile->eighths[i] != WIRE_NO_POINT) {
      take_point(grid, cell, tile->eighths[i]);
    }
  }
}

bool mapstream_take(grid_t *grid, uint8_t epoch, const uint8_t *bytes) {
  wire_map_t map;
  wire_tile_t tile;
  uint8_t told;
  if (!wire_map_open(&map, bytes, &told) || told != epoch) {
    return false;
  }
  while (wire_map_read(&map, &tile)) {
    take_tile(grid, &tile);
  }
  return true;
}
