// SPDX-License-Identifier: GPL-3.0-or-later
/* APP_STACK_BYTES comes from firmware_app/app-config. */
#include "coroutine_chip.h"

#include <string.h>

enum { SAVED_WORDS = 16 + 9, STACK_WORDS = APP_STACK_BYTES / 4 };

static const uint32_t UNUSED = 0xA5A5A5A5u;

/** At the lowest address of its memory. */
__attribute__((section(".ccm.lowest"))) static _Alignas(8) uint32_t stack[STACK_WORDS];
static uint32_t *task_sp;
static uint32_t *simulator_sp;

/** Keep what a function must keep on this stack, go on where the other one was left. */
__attribute__((naked, noinline)) static void change(uint32_t **kept, uint32_t *other) {
  __asm__ volatile("push {r4-r11, lr}\n"
                   "vpush {s16-s31}\n"
                   "str sp, [r0]\n"
                   "mov sp, r1\n"
                   "vpop {s16-s31}\n"
                   "pop {r4-r11, pc}\n");
}

void coroutine_make(void (*body)(void)) {
  for (int i = 0; i < STACK_WORDS; i++) {
    stack[i] = UNUSED;
  }
  task_sp = &stack[STACK_WORDS - SAVED_WORDS];
  memset(task_sp, 0, SAVED_WORDS * sizeof *task_sp);
  stack[STACK_WORDS - 1] = (uint32_t)body;
}

void coroutine_resume(void) {
  change(&simulator_sp, task_sp);
}

void coroutine_yield(void) {
  change(&task_sp, simulator_sp);
}

uint32_t coroutine_stack_used(void) {
  int unused = 0;
  while (unused < STACK_WORDS && stack[unused] == UNUSED) {
    unused++;
  }
  return (uint32_t)(STACK_WORDS - unused) * 4u;
}
