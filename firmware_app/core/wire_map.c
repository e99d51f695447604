// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
#include <string.h>

#include "wire.h"

enum {
  CELL_BYTES = WIRE_MAP_CELLS / 4,
  POINT_BYTES = 8,
  POINT_BITS = 12,
  COUNT_BITS = 4,
  STATES = 3,
  TAIL = CELL_BYTES + POINT_BYTES, ///< where tile, epoch and check stand
};

/** Six bits over all bytes but the check itself (FNV-1a, folded). */
static uint8_t check_of(const uint8_t *bytes) {
  uint32_t hash = 2166136261u;
  for (int i = 0; i < TAIL + 1; i++) {
    hash = (hash ^ bytes[i]) * 16777619u;
  }
  hash = (hash ^ (bytes[TAIL + 1] & (WIRE_MAP_EPOCHS - 1u))) * 16777619u;
  hash ^= hash >> 16;
  return (uint8_t)((hash ^ hash >> 6) & 0x3Fu);
}

void wire_map_encode(const wire_map_piece_t *piece, uint8_t *bytes) {
  memset(bytes, 0, WIRE_MAP_BYTES);
  for (int i = 0; i < WIRE_MAP_CELLS; i++) {
    bytes[i / 4] |= (uint8_t)((piece->states[i] & 3u) << (i % 4 * 2));
  }
  int count = piece->point_count < WIRE_MAP_POINTS ? piece->point_count : WIRE_MAP_POINTS;
  uint64_t points = (uint64_t)count;
  for (int i = 0; i < count; i++) {
    uint64_t point = (piece->point_cell[i] & 63u) | (uint64_t)(piece->point_eighths[i] & 63u) << 6;
    points |= point << (COUNT_BITS + POINT_BITS * i);
  }
  for (int i = 0; i < POINT_BYTES; i++) {
    bytes[CELL_BYTES + i] = (uint8_t)(points >> (8 * i) & 0xFFu);
  }
  bytes[TAIL] = piece->tile;
  bytes[TAIL + 1] = piece->epoch & (WIRE_MAP_EPOCHS - 1u);
  bytes[TAIL + 1] |= (uint8_t)(check_of(bytes) << 2);
}

bool wire_map_decode(const uint8_t *bytes, wire_map_piece_t *piece) {
  memset(piece, 0, sizeof *piece);
  if (bytes[TAIL + 1] >> 2 != check_of(bytes)) {
    return false;
  }
  piece->tile = bytes[TAIL];
  piece->epoch = bytes[TAIL + 1] & (WIRE_MAP_EPOCHS - 1u);
  for (int i = 0; i < WIRE_MAP_CELLS; i++) {
    piece->states[i] = bytes[i / 4] >> (i % 4 * 2) & 3u;
    if (piece->states[i] >= STATES) {
      return false;
    }
  }
  uint64_t points = 0;
  for (int i = 0; i < POINT_BYTES; i++) {
    points |= (uint64_t)bytes[CELL_BYTES + i] << (8 * i);
  }
  piece->point_count = points & ((1u << COUNT_BITS) - 1u);
  if (piece->point_count > WIRE_MAP_POINTS) {
    return false;
  }
  for (int i = 0; i < piece->point_count; i++) {
    uint32_t point = (uint32_t)(points >> (COUNT_BITS + POINT_BITS * i));
    piece->point_cell[i] = point & 63u;
    piece->point_eighths[i] = point >> 6 & 63u;
  }
  return true;
}
