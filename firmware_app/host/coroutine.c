// SPDX-License-Identifier: GPL-3.0-or-later
#include "coroutine.h"

#include <ucontext.h>

enum { STACK_BYTES = 256 * 1024 };

static ucontext_t simulator;
static ucontext_t task;
static _Alignas(16) char stack[STACK_BYTES];

void coroutine_make(void (*body)(void)) {
  getcontext(&task);
  task.uc_stack.ss_sp = stack;
  task.uc_stack.ss_size = sizeof stack;
  task.uc_link = &simulator;
  makecontext(&task, body, 0);
}

void coroutine_resume(void) {
  swapcontext(&simulator, &task);
}

void coroutine_yield(void) {
  swapcontext(&task, &simulator);
}
