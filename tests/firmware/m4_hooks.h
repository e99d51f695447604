// SPDX-License-Identifier: GPL-3.0-or-later
/** @file m4_hooks.h  The cycle model behind Unicorn's hooks, in C so that the emulator stays fast,
 *  and what watched functions cost: cycles with all that they call, and depth of stack. */
#ifndef M4_HOOKS_H
#define M4_HOOKS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "m4_cost.h"

enum { M4_WATCHED = 24, M4_COLUMNS = M4_WATCHED + 1 };

/** Unicorn's uc_reg_read and uc_reg_write, and its numbers of registers. */
typedef struct {
  int (*read)(void *emulator, int number, void *value);
  int (*write)(void *emulator, int number, const void *value);
  int cpsr;
  int sp;
  int lr;
} m4_registers_t;

typedef struct m4_hooks m4_hooks_t;

/** Stack: what is written from stack_low up to stack_top counts as depth.
 *  @return 0 if there is no memory */
m4_hooks_t *m4_hooks_new(const uint8_t *flash, m4_registers_t registers, uint32_t stack_low,
                         uint32_t stack_top);
void m4_hooks_free(m4_hooks_t *hooks);
/** Watch the function at this address. Each return of the one that closes a row ends a row.
 *  @return its column, -1 if there are too many */
int m4_hooks_watch(m4_hooks_t *hooks, uint32_t address, bool closes_row);

/** For UC_HOOK_BLOCK, with the hooks as user data. */
void m4_hooks_on_block(void *emulator, uint64_t address, uint32_t bytes, void *data);
/** For UC_HOOK_MEM_READ and UC_HOOK_MEM_WRITE. */
void m4_hooks_on_access(void *emulator, int type, uint64_t address, int bytes, int64_t value,
                        void *data);

uint64_t m4_hooks_cycles(const m4_hooks_t *hooks);
uint64_t m4_hooks_instructions(const m4_hooks_t *hooks);
/** Most bytes of stack below its entry that a watched function has used. */
uint32_t m4_hooks_depth(const m4_hooks_t *hooks, int function);
/** Rows of M4_COLUMNS: cycles of each watched function in the order of watching, last the cycles
 *  since the row before. @return how many rows */
size_t m4_hooks_rows(const m4_hooks_t *hooks, const uint32_t **rows);

#endif
