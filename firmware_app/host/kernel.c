// SPDX-License-Identifier: GPL-3.0-or-later
/* Time, and the app's task. The task is a coroutine: it runs until it sleeps, then the simulator
 * continues. Only sim_port_run() advances the time. */
#include <stdbool.h>

#include "FreeRTOS.h"
#include "app.h"
#include "coroutine.h"
#include "debug.h"
#include "port.h"
#include "sim_port.h"
#include "task.h"
#include "usec_time.h"

static uint32_t now_ms;
static uint32_t wake_ms;
static bool booted;
static bool failed;
static bool in_task;

static void run_app(void) {
  appMain();
  port_fail("appMain returned");
}

static void enter_task(void) {
  in_task = true;
  coroutine_resume();
  in_task = false;
}

void port_fail(const char *what) {
  consolePrintf("ASSERT: %s\n", what);
  failed = true;
  while (in_task) {
    coroutine_yield();
  }
}

uint32_t port_now_ms(void) {
  return now_ms;
}

TickType_t xTaskGetTickCount(void) {
  return now_ms;
}

uint64_t usecTimestamp(void) {
  return 1000ull * now_ms;
}

void vTaskDelayUntil(TickType_t *previous_wake, TickType_t increment) {
  *previous_wake += increment;
  if ((int32_t)(*previous_wake - now_ms) > 0) {
    wake_ms = *previous_wake;
    coroutine_yield();
  }
}

void sim_port_boot(void) {
  if (booted) {
    return;
  }
  booted = true;
  coroutine_make(run_app);
  enter_task();
}

void sim_port_run(uint32_t ms) {
  const uint32_t end_ms = now_ms + ms;
  while (sim_port_alive() && (int32_t)(end_ms - wake_ms) >= 0) {
    now_ms = wake_ms;
    enter_task();
  }
  now_ms = end_ms;
}

void sim_port_stall(uint32_t ms) {
  wake_ms += ms;
}

uint32_t sim_port_now_ms(void) {
  return now_ms;
}

bool sim_port_alive(void) {
  return booted && !failed;
}
