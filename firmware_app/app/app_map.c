// SPDX-License-Identifier: GPL-3.0-or-later
#include "app_map.h"

#include <stdatomic.h>
#include <string.h>

#include "log.h"

enum {
  RING_PIECES = 4,
  REFILL_PIECES = 2, ///< per call: as many as the fastest log block takes in 20 ms
  VARIABLES = 7,
};

static uint8_t ring[RING_PIECES][WIRE_MAP_BYTES];
static _Atomic uint8_t written; ///< total of pieces, modulo 256; only the app's loop changes it
static _Atomic uint8_t taken;   ///< likewise; only the getters change it
static uint8_t taken_before;    ///< value of `taken` at the last refill

static uint8_t current[WIRE_MAP_BYTES];          ///< the piece that is being sampled
static uint32_t current_ms;                      ///< time stamp of its first sample
static uint8_t sampled = (1u << VARIABLES) - 1u; ///< bit mask of its variables that were sampled

_Static_assert(256 % RING_PIECES == 0, "the counters wrap with the ring");

/** Keep one piece more in the ring than was taken since the last call: enough for the block's rate,
 *  and with a slow block no piece is older than the block's period. */
void app_map_refill(nav_t *nav) {
  const uint8_t now = taken;
  const int wanted = (uint8_t)(now - taken_before) + 1;
  taken_before = now;
  for (int i = 0; i < REFILL_PIECES; i++) {
    const int waiting = (uint8_t)(written - taken);
    if (waiting >= wanted || waiting == RING_PIECES) {
      return;
    }
    nav_next_map_piece(nav, ring[written % RING_PIECES]);
    written++;
  }
}

/** Bytes of the piece that a sample belongs to. All variables of one sample of a block have the
 *  same time stamp. A variable that was already sampled from the current piece asks for the next
 *  one; so a piece stays whole even if its variables are spread over several blocks, which are
 *  sampled one after the other. If no piece is ready, the current one is sent again. */
static const uint8_t *piece_at(uint32_t timestamp, unsigned byte) {
  const uint8_t variable = (uint8_t)(1u << byte / 4u);
  if ((sampled & variable) != 0 && timestamp != current_ms && written != taken) {
    memcpy(current, ring[taken % RING_PIECES], sizeof current);
    taken++;
    current_ms = timestamp;
    sampled = 0;
  }
  sampled |= variable;
  return current + byte;
}

/** Getters. Their data is the byte offset in the piece instead of a pointer. */
static uint32_t word32(uint32_t timestamp, void *offset) {
  const uint8_t *byte = piece_at(timestamp, (unsigned)(uintptr_t)offset);
  return byte[0] | (uint32_t)byte[1] << 8 | (uint32_t)byte[2] << 16 | (uint32_t)byte[3] << 24;
}

static uint16_t word16(uint32_t timestamp, void *offset) {
  const uint8_t *byte = piece_at(timestamp, (unsigned)(uintptr_t)offset);
  return (uint16_t)(byte[0] | byte[1] << 8);
}

static logByFunction_t m0 = {.acquireUInt32 = word32, .data = (void *)0};
static logByFunction_t m1 = {.acquireUInt32 = word32, .data = (void *)4};
static logByFunction_t m2 = {.acquireUInt32 = word32, .data = (void *)8};
static logByFunction_t m3 = {.acquireUInt32 = word32, .data = (void *)12};
static logByFunction_t m4 = {.acquireUInt32 = word32, .data = (void *)16};
static logByFunction_t m5 = {.acquireUInt32 = word32, .data = (void *)20};
static logByFunction_t m6 = {.acquireUInt16 = word16, .data = (void *)24};

/**
 * The map as a stream of pieces. All seven variables belong into one log block: each sample of the
 * block carries the next piece, 26 bytes in the order m0 to m6, least significant byte first.
 * Blocks of one period that share the variables carry one piece too. Contents: core/wire.h.
 */
LOG_GROUP_START(waymap)
/**
 * @brief Bytes 0 to 3 of the piece
 */
LOG_ADD_BY_FUNCTION(LOG_UINT32, m0, &m0)
/**
 * @brief Bytes 4 to 7 of the piece
 */
LOG_ADD_BY_FUNCTION(LOG_UINT32, m1, &m1)
/**
 * @brief Bytes 8 to 11 of the piece
 */
LOG_ADD_BY_FUNCTION(LOG_UINT32, m2, &m2)
/**
 * @brief Bytes 12 to 15 of the piece
 */
LOG_ADD_BY_FUNCTION(LOG_UINT32, m3, &m3)
/**
 * @brief Bytes 16 to 19 of the piece
 */
LOG_ADD_BY_FUNCTION(LOG_UINT32, m4, &m4)
/**
 * @brief Bytes 20 to 23 of the piece
 */
LOG_ADD_BY_FUNCTION(LOG_UINT32, m5, &m5)
/**
 * @brief Bytes 24 and 25 of the piece
 */
LOG_ADD_BY_FUNCTION(LOG_UINT16, m6, &m6)
LOG_GROUP_STOP(waymap)
