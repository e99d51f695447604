// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
#include "mapstream.h"

#include <string.h>

static const uint32_t EACH = 0x11111111u; ///< the lowest bit of each of a word's eight cells

enum {
  SWEEP_EVERY = 4,
  WORK_MAX = 64,       ///< work spent on a piece, in plain tiles; bounds its computing time
  MIXED_WORK = 16,     ///< work of a tile that is not plain
  DICE_FACTOR = 25173, ///< linear congruential generator; its lowest two bits have period 4
  DICE_STEP = 13849,
  TAKEN_FREE = 4,      ///< value for a free cell of a saved map
  TAKEN_OCCUPIED = 11, ///< value for an occupied cell of a saved map
  EIGHTHS = 8,
};

void mapstream_init(mapstream_t *stream) {
  memset(stream, 0, sizeof *stream);
}

/** The next changed tile after the cursor, -1 if none. */
static int changed_tile(const mapstream_t *stream, const grid_t *grid) {
  uint8_t tile = stream->cursor;
  do {
    tile++;
    if ((grid->changed_tiles[tile / 32] >> (tile % 32) & 1u) != 0u) {
      return tile;
    }
  } while (tile != stream->cursor);
  return -1;
}

/** First tile of the next piece. @param sweeps  set if the piece belongs to the sweep */
static int choose_tile(mapstream_t *stream, const grid_t *grid, bool *sweeps) {
  stream->dice = (uint16_t)(stream->dice * DICE_FACTOR + DICE_STEP);
  int tile = stream->dice % SWEEP_EVERY != 0u ? changed_tile(stream, grid) : -1;
  *sweeps = tile < 0;
  return *sweeps ? stream->sweep : tile;
}

/** The cell with this row-major index in a tile. */
static grid_cell_t cell_of(int tile, int index) {
  return (grid_cell_t){
      tile % GRID_TILES_PER_ROW * GRID_TILE_SIDE_CELLS + index % GRID_TILE_SIDE_CELLS,
      tile / GRID_TILES_PER_ROW * GRID_TILE_SIDE_CELLS + index / GRID_TILE_SIDE_CELLS};
}

/** One row of a tile: eight cells, four bits each. */
static uint32_t row_of(const grid_t *grid, int tile, int row) {
  int iy = tile / GRID_TILES_PER_ROW * GRID_TILE_SIDE_CELLS + row;
  return grid->cells[iy * GRID_ROW_WORDS + tile % GRID_TILES_PER_ROW];
}

_Static_assert(GRID_TILE_SIDE_CELLS == 8, "a row of a tile is a word of the grid");
_Static_assert(GRID_TILES == 256, "the number of a tile is a byte and wraps with the grid");

/** State of a tile whose cells are all unknown or all free; -1 of any other tile. */
static int plain(const grid_t *grid, int tile) {
  uint32_t any = 0;
  uint32_t all = EACH;
  for (int row = 0; row < GRID_TILE_SIDE_CELLS; row++) {
    uint32_t cells = row_of(grid, tile, row);
    any |= cells;
    all &= cells | cells >> 1 | cells >> 2;
  }
  if (any == 0u) {
    return GRID_CELL_UNKNOWN;
  }
  return all == EACH && (any & EACH << 3) == 0u ? GRID_CELL_FREE : -1;
}

/** Read states and obstacle points of a tile from the grid. */
static void fill(const grid_t *grid, wire_tile_t *tile) {
  memset(tile->eighths, WIRE_NO_POINT, sizeof tile->eighths);
  uint32_t row = 0;
  for (int i = 0; i < WIRE_MAP_CELLS; i++, row >>= 4) {
    if (i % GRID_TILE_SIDE_CELLS == 0) {
      row = row_of(grid, tile->tile, i / GRID_TILE_SIDE_CELLS);
    }
    uint32_t value = row & 15u;
    tile->states[i] = value >= GRID_OCCUPIED_MIN ? GRID_CELL_OCCUPIED : value > 0u;
    if (value >= GRID_OCCUPIED_MIN) {
      grid_cell_t at = cell_of(tile->tile, i);
      int eighths = grid_point_eighths(grid, at.ix, at.iy);
      tile->eighths[i] = (uint8_t)(eighths < 0 ? WIRE_NO_POINT : eighths);
    }
  }
}

/** Add the next tile to the piece. @return the work that it took, 0 if the tile does not fit */
static int add(const grid_t *grid, wire_map_t *map, uint8_t first_point) {
  int state = plain(grid, map->tile);
  if (state >= 0) {
    return wire_map_add_plain(map, (uint8_t)state) ? 1 : 0;
  }
  wire_tile_t tile;
  tile.tile = map->tile;
  tile.first_point = first_point;
  fill(grid, &tile);
  return wire_map_add(map, &tile) ? MIXED_WORK : 0;
}

void mapstream_next(mapstream_t *stream, grid_t *grid, uint8_t epoch, uint8_t *bytes) {
  bool sweeps;
  wire_map_t map;
  uint8_t first = (uint8_t)choose_tile(stream, grid, &sweeps);
  wire_map_begin(&map, first, epoch);
  for (int done = 0, work = 0; done < WORK_MAX; done += work) {
    uint8_t tile = map.tile;
    work = add(grid, &map, (uint8_t)(stream->dice >> 8));
    if (work == 0) {
      break;
    }
    grid->changed_tiles[tile / 32] &= ~(1u << (tile % 32));
  }
  wire_map_end(&map);
  if (sweeps) {
    bool again = stream->sweep == 0u && stream->dice >= 0x8000u;
    stream->sweep = again ? 0u : map.tile;
  } else {
    stream->cursor = (uint8_t)(map.tile - 1u);
  }
  memcpy(bytes, map.bytes, WIRE_MAP_BYTES);
}

/** Middle of an eighth, in cells. */
static float middle_of(int eighth) {
  return ((float)eighth + 0.5f) / (float)EIGHTHS;
}

/** Add the obstacle point that a piece gives for a cell. */
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
