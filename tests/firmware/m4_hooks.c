// SPDX-License-Identifier: GPL-3.0-or-later
#include "m4_hooks.h"

#include <stdlib.h>
#include <string.h>

enum { FRAMES = 32, MEMORY_WRITE = 17 /* UC_MEM_WRITE */ };

static const uint32_t IT_BITS = 0x0600FC00u; ///< of the CPSR

/** A watched function that has been entered and not left. */
typedef struct {
  int function;
  uint32_t back; ///< where it returns to
  uint32_t sp;   ///< on entry, and again on return
  uint32_t low;  ///< lowest address written on the stack
  uint64_t start;
} frame_t;

struct m4_hooks {
  m4_cost_t *cost;
  m4_registers_t registers;
  uint32_t stack_low, stack_top;
  uint32_t addresses[M4_WATCHED];
  uint32_t depth[M4_WATCHED];
  int count;
  int closing; ///< the function whose return ends a row
  frame_t frames[FRAMES];
  int depth_now;
  uint32_t row[M4_COLUMNS];
  uint64_t row_start;
  uint32_t *rows;
  size_t row_count, row_room;
};

m4_hooks_t *m4_hooks_new(const uint8_t *flash, m4_registers_t registers, uint32_t stack_low,
                         uint32_t stack_top) {
  m4_hooks_t *hooks = calloc(1, sizeof *hooks);
  if (hooks && !(hooks->cost = m4_cost_new(flash))) {
    free(hooks);
    return 0;
  }
  if (hooks) {
    hooks->registers = registers;
    hooks->stack_low = stack_low;
    hooks->stack_top = stack_top;
  }
  return hooks;
}

void m4_hooks_free(m4_hooks_t *hooks) {
  m4_cost_free(hooks->cost);
  free(hooks->rows);
  free(hooks);
}

int m4_hooks_watch(m4_hooks_t *hooks, uint32_t address, bool closes_row) {
  if (hooks->count == M4_WATCHED) {
    return -1;
  }
  if (closes_row) {
    hooks->closing = hooks->count;
  }
  hooks->addresses[hooks->count] = address;
  return hooks->count++;
}

static void close_row(m4_hooks_t *hooks) {
  if (hooks->row_count == hooks->row_room) {
    hooks->row_room = hooks->row_room ? 2 * hooks->row_room : 1024;
    hooks->rows = realloc(hooks->rows, hooks->row_room * sizeof hooks->row);
    if (!hooks->rows) {
      abort();
    }
  }
  hooks->row[M4_WATCHED] = (uint32_t)(hooks->cost->now - hooks->row_start);
  memcpy(&hooks->rows[hooks->row_count++ * M4_COLUMNS], hooks->row, sizeof hooks->row);
  memset(hooks->row, 0, sizeof hooks->row);
  hooks->row_start = hooks->cost->now;
}

static bool active(const m4_hooks_t *hooks, int function) {
  for (int i = 0; i < hooks->depth_now; i++) {
    if (hooks->frames[i].function == function) {
      return true;
    }
  }
  return false;
}

static uint32_t stack_pointer(const m4_hooks_t *hooks, void *emulator) {
  uint32_t sp = 0;
  hooks->registers.read(emulator, hooks->registers.sp, &sp);
  return sp;
}

static void leave(m4_hooks_t *hooks) {
  const frame_t *left = &hooks->frames[--hooks->depth_now];
  uint32_t depth = left->sp - left->low;
  if (depth > hooks->depth[left->function]) {
    hooks->depth[left->function] = depth;
  }
  if (hooks->depth_now > 0 && left->low < hooks->frames[hooks->depth_now - 1].low) {
    hooks->frames[hooks->depth_now - 1].low = left->low;
  }
  if (!active(hooks, left->function)) {
    hooks->row[left->function] += (uint32_t)(hooks->cost->now - left->start);
  }
  if (left->function == hooks->closing) {
    close_row(hooks);
  }
}

static void enter(m4_hooks_t *hooks, void *emulator, int function) {
  uint32_t sp = stack_pointer(hooks, emulator);
  uint32_t lr = 0;
  hooks->registers.read(emulator, hooks->registers.lr, &lr);
  uint32_t back = lr & ~1u;
  if (hooks->depth_now > 0) { // a loop back to the function's first instruction
    const frame_t *top = &hooks->frames[hooks->depth_now - 1];
    if (top->function == function && top->back == back && top->sp == sp) {
      return;
    }
  }
  if (hooks->depth_now == FRAMES) {
    abort();
  }
  hooks->frames[hooks->depth_now++] = (frame_t){function, back, sp, sp, hooks->cost->now};
}

/** A function called in the last place of another returns to where that one would have. */
static void leave_what_ended(m4_hooks_t *hooks, void *emulator, uint32_t address) {
  while (hooks->depth_now > 0) {
    const frame_t *top = &hooks->frames[hooks->depth_now - 1];
    if (top->back != address || top->sp != stack_pointer(hooks, emulator)) {
      return;
    }
    leave(hooks);
  }
}

void m4_hooks_on_block(void *emulator, uint64_t address, uint32_t bytes, void *data) {
  m4_hooks_t *hooks = data;
  leave_what_ended(hooks, emulator, (uint32_t)address);
  for (int i = 0; i < hooks->count; i++) {
    if (hooks->addresses[i] == address) {
      enter(hooks, emulator, i);
    }
  }
  m4_cost_block(hooks->cost, (uint32_t)address, bytes);
}

/** Unicorn 2.1 restores the state of IT before it calls a memory hook, and leaves it so: the next
 * block would begin as if inside of the IT block. */
static void end_it(const m4_hooks_t *hooks, void *emulator) {
  uint32_t cpsr = 0;
  hooks->registers.read(emulator, hooks->registers.cpsr, &cpsr);
  if ((cpsr & IT_BITS) != 0u) {
    cpsr &= ~IT_BITS;
    hooks->registers.write(emulator, hooks->registers.cpsr, &cpsr);
  }
}

void m4_hooks_on_access(void *emulator, int type, uint64_t address, int bytes, int64_t value,
                        void *data) {
  (void)value;
  m4_hooks_t *hooks = data;
  uint32_t at = (uint32_t)address;
  bool is_store = type == MEMORY_WRITE;
  if (is_store && hooks->depth_now > 0 && at >= hooks->stack_low && at < hooks->stack_top) {
    frame_t *top = &hooks->frames[hooks->depth_now - 1];
    top->low = at < top->low ? at : top->low;
  }
  if (hooks->cost->conditional) {
    end_it(hooks, emulator);
  }
  m4_cost_access(hooks->cost, at, (uint32_t)bytes, is_store);
}

uint64_t m4_hooks_cycles(const m4_hooks_t *hooks) {
  return hooks->cost->now;
}

uint64_t m4_hooks_instructions(const m4_hooks_t *hooks) {
  return hooks->cost->instructions;
}

uint32_t m4_hooks_depth(const m4_hooks_t *hooks, int function) {
  return hooks->depth[function];
}

size_t m4_hooks_rows(const m4_hooks_t *hooks, const uint32_t **rows) {
  *rows = hooks->rows;
  return hooks->row_count;
}
