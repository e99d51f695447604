// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
/* Encoding of the pieces of the map.
 *
 * The payload is a sequence of items, packed with the lowest bit first. An item begins with its
 * kind (2 bits):
 *   0 or 1: a run of tiles that are all unknown (0) or all free (1); length - 1 (4 bits);
 *   2: one mixed tile: dense (1 bit), cells, whole (1 bit), points;
 *   3: end of the piece; left out if fewer than 2 bits are left.
 *
 * Cells, sparse: each cell is predicted from its neighbours to the west and south, as in the median
 * predictor of JPEG-LS (Weinberger, Seroussi, Sapiro 2000). A nibble tells how many cells are as
 * predicted. 15 means 15 such cells, or as many as are left; a smaller number is followed by a bit
 * that tells which of the two other states the next cell has.
 * Cells, dense, where sparse ones would take more than 13 bytes: five cells a byte, in base 3.
 *
 * Points: for each occupied cell a bit that says whether it has one, and then its eighths (6 bits).
 * If whole, the points of all cells in order; else the index of a cell (6 bits) and the points from
 * that cell on, continuing with cell 0 after the last one, until fewer than 7 bits are left. */
#include <string.h>

#include "wire.h"

enum {
  TAG_WORD = 1, ///< first byte of epoch and checksum
  PAYLOAD = 3,  ///< first byte of the items
  PAYLOAD_BITS = 8 * (WIRE_MAP_BYTES - PAYLOAD),
  SIDE = 8,     ///< cells along the side of a tile
  STATES = 3,   ///< of a cell: grid_state_t
  OCCUPIED = 2, ///< GRID_CELL_OCCUPIED
  MIXED = 2,    ///< kind of item; 0 and 1 are GRID_CELL_UNKNOWN and GRID_CELL_FREE
  END = 3,      ///< kind of item
  KIND_BITS = 2,
  RUN_BITS = 4,
  RUN_MAX = 16,
  GAP_BITS = 4, ///< a gap: cells that are as predicted, up to one that is not
  GAP_MAX = 15,
  CELL_BITS = 6,
  POINT_BITS = 7, ///< with the bit that says that the cell has a point
  CELLS_A_BYTE = 5,
  DENSE_BITS = 8 * 13,
};

/** 14-bit checksum of all bits but its own: 32-bit FNV-1a, folded. */
static uint16_t check_of(const uint8_t *bytes) {
  uint32_t hash = (2166136261u ^ (bytes[TAG_WORD] & (WIRE_MAP_EPOCHS - 1u))) * 16777619u;
  hash = (hash ^ bytes[0]) * 16777619u;
  for (int i = PAYLOAD; i < WIRE_MAP_BYTES; i++) {
    hash = (hash ^ bytes[i]) * 16777619u;
  }
  return (uint16_t)((hash ^ hash >> 14 ^ hash >> 28) & 0x3FFFu);
}

/** Append up to eight bits. */
static void put(wire_map_t *map, int bits, unsigned value) {
  if (bits == 0) {
    return;
  }
  uint8_t *byte = &map->bytes[PAYLOAD + map->bit / 8];
  unsigned mask = ((1u << bits) - 1u) << map->bit % 8;
  value = value << map->bit % 8 & mask;
  byte[0] = (uint8_t)((byte[0] & ~mask) | value);
  if (mask > 0xFFu) {
    byte[1] = (uint8_t)((byte[1] & ~(mask >> 8)) | value >> 8);
  }
  map->bit += (uint8_t)bits;
}

/** Bits left in the payload. */
static int left(const wire_map_t *map) {
  return PAYLOAD_BITS - map->bit;
}

/** Read up to eight bits; zeros beyond the end. */
static unsigned get(wire_map_t *map, int bits) {
  int at = PAYLOAD + map->bit / 8;
  unsigned value = at < WIRE_MAP_BYTES ? map->bytes[at] : 0u;
  value |= at + 1 < WIRE_MAP_BYTES ? (unsigned)map->bytes[at + 1] << 8 : 0u;
  value = value >> map->bit % 8 & ((1u << bits) - 1u);
  map->bit += (uint8_t)(bits < left(map) ? bits : left(map));
  return value;
}

/** State of a cell as predicted from the cells before it. */
static uint8_t expected(const uint8_t *states, int cell) {
  if (cell % SIDE == 0) {
    return cell == 0 ? 0 : states[cell - SIDE];
  }
  uint8_t west = states[cell - 1];
  if (cell < SIDE) {
    return west;
  }
  return states[cell - SIDE - 1] == west ? states[cell - SIDE] : west;
}

/** For each cell the difference to its predicted state, modulo STATES. @return bits that the cells
 * take as sparse ones */
static int differences(const uint8_t *states, uint8_t *off) {
  int bits = 0;
  int gap = 0;
  for (int cell = 0; cell < WIRE_MAP_CELLS; cell++) {
    int difference = states[cell] - expected(states, cell);
    off[cell] = (uint8_t)(difference < 0 ? difference + STATES : difference);
    gap++;
    if (difference != 0 || gap == GAP_MAX) {
      bits += GAP_BITS + (difference != 0 ? 1 : 0);
      gap = 0;
    }
  }
  return bits + (gap > 0 ? GAP_BITS : 0);
}

static void put_sparse(wire_map_t *map, const uint8_t *off) {
  unsigned gap = 0;
  for (int cell = 0; cell < WIRE_MAP_CELLS; cell++) {
    if (off[cell] != 0u) {
      put(map, GAP_BITS + 1, gap | (off[cell] - 1u) << GAP_BITS);
      gap = 0;
    } else if (++gap == GAP_MAX) {
      put(map, GAP_BITS, gap);
      gap = 0;
    }
  }
  if (gap > 0) {
    put(map, GAP_BITS, GAP_MAX);
  }
}

static void get_sparse(wire_map_t *map, uint8_t *states) {
  for (int cell = 0; cell < WIRE_MAP_CELLS;) {
    unsigned gap = get(map, GAP_BITS);
    for (unsigned i = 0; i < gap && cell < WIRE_MAP_CELLS; i++, cell++) {
      states[cell] = expected(states, cell);
    }
    if (gap < GAP_MAX && cell < WIRE_MAP_CELLS) {
      states[cell] = (uint8_t)((expected(states, cell) + 1u + get(map, 1)) % STATES);
      cell++;
    }
  }
}

static void put_dense(wire_map_t *map, const uint8_t *states) {
  for (int first = 0; first < WIRE_MAP_CELLS; first += CELLS_A_BYTE) {
    unsigned byte = 0;
    for (int i = CELLS_A_BYTE - 1; i >= 0; i--) {
      byte = STATES * byte + (first + i < WIRE_MAP_CELLS ? states[first + i] : 0u);
    }
    put(map, 8, byte);
  }
}

static void get_dense(wire_map_t *map, uint8_t *states) {
  unsigned byte = 0;
  for (int cell = 0; cell < WIRE_MAP_CELLS; cell++, byte /= STATES) {
    byte = cell % CELLS_A_BYTE == 0 ? get(map, 8) : byte;
    states[cell] = (uint8_t)(byte % STATES);
  }
}

/** Bits that all points of the tile take. */
static int point_bits(const wire_tile_t *tile) {
  int bits = 0;
  for (int cell = 0; cell < WIRE_MAP_CELLS; cell++) {
    if (tile->states[cell] == OCCUPIED) {
      bits += tile->eighths[cell] != WIRE_NO_POINT ? POINT_BITS : 1;
    }
  }
  return bits;
}

/** Write points from cell `first` on, round, while at least `reserve` bits are left. */
static void put_points(wire_map_t *map, const wire_tile_t *tile, unsigned first, int reserve) {
  for (unsigned i = 0; i < WIRE_MAP_CELLS && left(map) >= reserve; i++) {
    unsigned cell = (first + i) % WIRE_MAP_CELLS;
    if (tile->states[cell] == OCCUPIED) {
      bool has = tile->eighths[cell] != WIRE_NO_POINT;
      put(map, has ? POINT_BITS : 1, has ? 1u | (unsigned)tile->eighths[cell] << 1 : 0u);
    }
  }
}

static void get_points(wire_map_t *map, wire_tile_t *tile, unsigned first, int reserve) {
  for (unsigned i = 0; i < WIRE_MAP_CELLS && left(map) >= reserve; i++) {
    unsigned cell = (first + i) % WIRE_MAP_CELLS;
    if (tile->states[cell] == OCCUPIED && get(map, 1) != 0u) {
      tile->eighths[cell] = (uint8_t)get(map, CELL_BITS);
    }
  }
}

void wire_map_begin(wire_map_t *map, uint8_t tile, uint8_t epoch) {
  memset(map, 0, sizeof *map);
  map->bytes[0] = map->tile = tile;
  map->bytes[TAG_WORD] = epoch & (WIRE_MAP_EPOCHS - 1u);
}

/** Go on to the next tile; behind the last one of the grid the piece is full. */
static void step(wire_map_t *map) {
  map->tile++;
  map->full = map->full || map->tile == 0;
}

/** True if all cells are unknown or all are free. */
static bool uniform(const wire_tile_t *tile) {
  return tile->states[0] < MIXED && memcmp(tile->states, tile->states + 1, WIRE_MAP_CELLS - 1) == 0;
}

bool wire_map_add_plain(wire_map_t *map, uint8_t kind) {
  if (map->full) {
    return false;
  }
  if (map->run == 0 || map->run == RUN_MAX || map->run_kind != kind) {
    if (left(map) < KIND_BITS + RUN_BITS) {
      return false;
    }
    put(map, KIND_BITS, kind);
    map->run_kind = kind;
    map->run_bit = map->bit;
    map->bit += RUN_BITS;
    map->run = 0;
  }
  // Rewrite the length of the run.
  uint8_t end = map->bit;
  map->bit = map->run_bit;
  put(map, RUN_BITS, map->run);
  map->run++;
  map->bit = end;
  step(map);
  return true;
}

/** Add a mixed tile. One whose points do not all fit must be the first of its piece. */
static bool add_mixed(wire_map_t *map, const wire_tile_t *tile) {
  uint8_t off[WIRE_MAP_CELLS];
  int sparse = differences(tile->states, off);
  bool dense = sparse > DENSE_BITS;
  int bits = KIND_BITS + 2 + (dense ? DENSE_BITS : sparse) + point_bits(tile);
  bool whole = bits <= left(map);
  if (!whole && map->bit > 0) {
    return false;
  }
  put(map, KIND_BITS, MIXED);
  put(map, 1, dense ? 1u : 0u);
  if (dense) {
    put_dense(map, tile->states);
  } else {
    put_sparse(map, off);
  }
  put(map, 1, whole ? 1u : 0u);
  put(map, whole ? 0 : CELL_BITS, tile->first_point);
  put_points(map, tile, whole ? 0u : tile->first_point % WIRE_MAP_CELLS, whole ? 1 : POINT_BITS);
  map->full = !whole;
  map->run = 0;
  step(map);
  return true;
}

bool wire_map_add(wire_map_t *map, const wire_tile_t *tile) {
  if (map->full || tile->tile != map->tile) {
    return false;
  }
  return uniform(tile) ? wire_map_add_plain(map, tile->states[0]) : add_mixed(map, tile);
}

void wire_map_end(wire_map_t *map) {
  if (left(map) >= KIND_BITS) {
    put(map, KIND_BITS, END);
  }
  uint16_t check = check_of(map->bytes);
  map->bytes[TAG_WORD] |= (uint8_t)((unsigned)check << 2);
  map->bytes[TAG_WORD + 1] = (uint8_t)(check >> 6);
}

bool wire_map_open(wire_map_t *map, const uint8_t *bytes, uint8_t *epoch) {
  memset(map, 0, sizeof *map);
  memcpy(map->bytes, bytes, WIRE_MAP_BYTES);
  map->tile = bytes[0];
  *epoch = bytes[TAG_WORD] & (WIRE_MAP_EPOCHS - 1u);
  return (bytes[TAG_WORD] >> 2 | bytes[TAG_WORD + 1] << 6) == check_of(bytes);
}

static void get_mixed(wire_map_t *map, wire_tile_t *tile) {
  if (get(map, 1) != 0u) {
    get_dense(map, tile->states);
  } else {
    get_sparse(map, tile->states);
  }
  tile->whole = get(map, 1) != 0u;
  unsigned first = tile->whole ? 0u : get(map, CELL_BITS);
  get_points(map, tile, first, tile->whole ? 1 : POINT_BITS);
  map->full = !tile->whole;
}

bool wire_map_read(wire_map_t *map, wire_tile_t *tile) {
  if (map->run == 0) {
    if (map->full || left(map) < KIND_BITS) {
      return false;
    }
    map->run_kind = (uint8_t)get(map, KIND_BITS);
    if (map->run_kind == END) {
      map->full = true;
      return false;
    }
    map->run = map->run_kind == MIXED ? 1 : (uint8_t)(1u + get(map, RUN_BITS));
  }
  memset(tile, 0, sizeof *tile);
  memset(tile->eighths, WIRE_NO_POINT, sizeof tile->eighths);
  memset(tile->states, map->run_kind, sizeof tile->states);
  tile->tile = map->tile;
  tile->whole = true;
  if (map->run_kind == MIXED) {
    get_mixed(map, tile);
  }
  map->run--;
  step(map);
  if (map->full) {
    map->run = 0;
  }
  return true;
}
