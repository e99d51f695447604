// SPDX-License-Identifier: GPL-3.0-or-later
#include "m4_cost.h"

#include <stdlib.h>
#include <string.h>

#include "m4_decode.h"

enum { WAIT_STATES = 5, REFILL_CYCLES = 2, LINE_BYTES = 16 };

static const uint32_t NO_LINE = ~0u;

/** The part of a block that lies in one line of flash. */
typedef struct {
  uint32_t line;
  uint32_t cycles;
} segment_t;

struct m4_block {
  m4_block_t *other; ///< with the same start
  uint32_t bytes;
  uint32_t instructions;
  uint32_t refill_cycles; ///< when it is branched to
  uint32_t segment_count;
  bool conditional;
  segment_t segments[];
};

static uint32_t line_of(uint32_t address) {
  return (address - M4_FLASH_BASE) / LINE_BYTES;
}

static bool in_flash(uint32_t address) {
  return address - M4_FLASH_BASE < M4_FLASH_BYTES;
}

m4_cost_t *m4_cost_new(const uint8_t *flash) {
  m4_cost_t *cost = calloc(1, sizeof *cost);
  if (cost) {
    cost->flash = flash;
    cost->code.size = M4_CODE_LINES;
    cost->data.size = M4_DATA_LINES;
    cost->line = cost->prefetched = NO_LINE;
  }
  return cost;
}

void m4_cost_free(m4_cost_t *cost) {
  for (int i = 0; i < M4_FLASH_BYTES / 2; i++) {
    while (cost->blocks[i]) {
      m4_block_t *block = cost->blocks[i];
      cost->blocks[i] = block->other;
      free(block);
    }
  }
  free(cost);
}

static uint16_t half_word(const m4_cost_t *cost, uint32_t address) {
  uint16_t value;
  memcpy(&value, &cost->flash[address - M4_FLASH_BASE], sizeof value);
  return value;
}

static void add_cycles(m4_block_t *block, uint32_t line, uint32_t cycles) {
  if (block->segment_count == 0 || block->segments[block->segment_count - 1].line != line) {
    block->segments[block->segment_count++] = (segment_t){line, 0};
  }
  block->segments[block->segment_count - 1].cycles += cycles;
  block->instructions++;
}

static m4_block_t *make_block(const m4_cost_t *cost, uint32_t address, uint32_t bytes) {
  m4_block_t *block = calloc(1, sizeof *block + (bytes / 2 + 1) * sizeof(segment_t));
  if (!block) {
    abort();
  }
  block->bytes = bytes;
  block->refill_cycles = REFILL_CYCLES;
  m4_instruction_t before = {0};
  for (uint32_t at = address; at < address + bytes;) {
    uint16_t first = half_word(cost, at);
    uint32_t length = (uint32_t)m4_length(first);
    m4_instruction_t found = m4_decode(first, length == 4 ? half_word(cost, at + 2) : 0);
    if (at == address) {
      block->refill_cycles += length == 4 && (at & 2u) != 0u;
    }
    int cycles = at == address ? found.cycles : m4_pair_cycles(&before, &found);
    add_cycles(block, line_of(at), (uint32_t)cycles);
    block->conditional = block->conditional || m4_is_it(first);
    before = found;
    at += length;
  }
  return block;
}

static m4_block_t *block_at(m4_cost_t *cost, uint32_t address, uint32_t bytes) {
  m4_block_t **first = &cost->blocks[(address - M4_FLASH_BASE) / 2];
  m4_block_t *block = *first;
  while (block && block->bytes != bytes) {
    block = block->other;
  }
  if (!block) {
    block = make_block(cost, address, bytes);
    block->other = *first;
    *first = block;
  }
  return block;
}

static bool holds(m4_cache_t *cache, uint32_t line, uint64_t now) {
  for (int i = 0; i < cache->size; i++) {
    if (cache->line[i] == line && cache->used[i] != 0) {
      cache->used[i] = now + 1;
      return true;
    }
  }
  return false;
}

/** Wait for the flash, read a line, keep it. */
static void read_line(m4_cost_t *cost, m4_cache_t *cache, uint32_t line) {
  if (cost->flash_free > cost->now) {
    cost->now = cost->flash_free;
  }
  cost->now += WAIT_STATES;
  cost->flash_free = cost->now;
  int oldest = 0;
  for (int i = 1; i < cache->size; i++) {
    oldest = cache->used[i] < cache->used[oldest] ? i : oldest;
  }
  cache->line[oldest] = line;
  cache->used[oldest] = cost->now + 1;
}

/** The next line is read ahead, which nothing waits for until it is needed. */
static void prefetch(m4_cost_t *cost, uint32_t line) {
  if (cost->prefetched == line || holds(&cost->code, line, cost->now)) {
    return;
  }
  uint64_t start = cost->flash_free > cost->now ? cost->flash_free : cost->now;
  cost->prefetched = line;
  cost->flash_free = start + WAIT_STATES + 1;
}

static void fetch(m4_cost_t *cost, uint32_t line) {
  if (line == cost->line) {
    return;
  }
  if (line == cost->prefetched) {
    cost->now = cost->flash_free > cost->now ? cost->flash_free : cost->now;
  } else if (!holds(&cost->code, line, cost->now)) {
    read_line(cost, &cost->code, line);
  }
  cost->line = line;
  prefetch(cost, line + 1);
}

void m4_cost_block(m4_cost_t *cost, uint32_t address, uint32_t bytes) {
  if (!in_flash(address)) {
    return;
  }
  const m4_block_t *block = block_at(cost, address, bytes);
  if (address != cost->last_end) {
    cost->now += block->refill_cycles;
  }
  cost->last_end = address + bytes;
  cost->conditional = block->conditional;
  cost->instructions += block->instructions;
  for (uint32_t i = 0; i < block->segment_count; i++) {
    fetch(cost, block->segments[i].line);
    cost->now += block->segments[i].cycles;
  }
}

void m4_cost_access(m4_cost_t *cost, uint32_t address, uint32_t bytes, bool is_store) {
  if ((address & (bytes - 1u) & 3u) != 0u) {
    cost->now += bytes >= 4u && (address & 1u) != 0u ? 2 : 1;
  }
  if (!is_store && in_flash(address) && !holds(&cost->data, line_of(address), cost->now)) {
    read_line(cost, &cost->data, line_of(address));
  }
}
