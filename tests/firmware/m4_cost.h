// SPDX-License-Identifier: GPL-3.0-or-later
/** @file m4_cost.h  Cycles of a Cortex-M4F from a stream of executed blocks. Knows no emulator.
 *
 *  A block is a straight run of instructions, decoded once. To its cycles come:
 *  - a taken branch: a refill of 2 (the TRM: 1 to 3), one more if the target is a 4-byte
 * instruction across a word,
 *  - an access that is not aligned: 1, or 2 if a word stands at an odd address,
 *  - the flash of the STM32F405 (RM0090): lines of 16 bytes, 5 wait states at 168 MHz, the next
 * line is prefetched, 64 lines of instructions and 8 of data are kept (least recently used).
 *
 *  Not modelled: interrupts, other tasks, DMA, saving of floating-point registers. */
#ifndef M4_COST_H
#define M4_COST_H

#include <stdbool.h>
#include <stdint.h>

enum {
  M4_FLASH_BASE = 0x08000000,
  M4_FLASH_BYTES = 1 << 20,
  M4_CODE_LINES = 64,
  M4_DATA_LINES = 8,
};

typedef struct m4_block m4_block_t;

typedef struct {
  uint32_t line[M4_CODE_LINES];
  uint64_t used[M4_CODE_LINES]; ///< when last, 0 never
  int size;
} m4_cache_t;

typedef struct {
  const uint8_t *flash;
  m4_block_t *blocks[M4_FLASH_BYTES / 2]; ///< by start
  m4_cache_t code;
  m4_cache_t data;
  uint64_t now; ///< cycles so far
  uint64_t instructions;
  uint64_t flash_free; ///< when the flash is idle again
  uint32_t line;       ///< being executed
  uint32_t prefetched; ///< on its way
  uint32_t last_end;   ///< of the block before
  bool conditional;    ///< the running block has an IT instruction
} m4_cost_t;

/** @param flash M4_FLASH_BYTES of memory as seen at M4_FLASH_BASE
 *  @return 0 if there is no memory */
m4_cost_t *m4_cost_new(const uint8_t *flash);
void m4_cost_free(m4_cost_t *cost);
/** A block is about to run. Code outside of the flash costs nothing: there is none. */
void m4_cost_block(m4_cost_t *cost, uint32_t address, uint32_t bytes);
/** The running block accesses data. */
void m4_cost_access(m4_cost_t *cost, uint32_t address, uint32_t bytes, bool is_store);

#endif
