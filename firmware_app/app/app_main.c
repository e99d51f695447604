// SPDX-License-Identifier: GPL-3.0-or-later
/* The app's task: read sensors, run nav, send setpoint and telemetry, sleep. */
#include "FreeRTOS.h"
#include "app.h"
#include "app_command.h"
#include "app_link.h"
#include "app_map.h"
#include "app_params.h"
#include "app_positioning.h"
#include "app_selftest.h"
#include "app_sensors.h"
#include "app_setpoint.h"
#include "app_status.h"
#include "nav.h"
#include "task.h"
#include "usec_time.h"

enum {
  NAV_MAX_BYTES = 21504, ///< share of nav_t in the 22,528 bytes of static RAM for core and app
  PERIOD_MS = 20,        ///< of a tick
  REST_MS = 2, ///< sleep, even after a tick that took too long: the idle task feeds the watchdog
};

static nav_t nav;

_Static_assert(sizeof(nav_t) <= NAV_MAX_BYTES, "nav_t takes more memory than it may");

static void take_command(void) {
  nav_command_t command;
  if (app_params_take_command(&command)) {
    app_command(&nav, &command);
  }
}

static void tick(void) {
  const uint64_t start_us = usecTimestamp();
  nav_input_t input;
  app_sensors_read(&input);
  app_params_apply(&nav);
  const nav_setpoint_t setpoint = nav_step(&nav, &input);
  app_setpoint_send(&setpoint);
  app_positioning_tell(&nav);
  const bool planning = nav.status.state == MISSION_PLAN;
  take_command();
  app_link_receive(&nav);
  app_link_send(&nav);
  app_map_refill(&nav);
  app_status_show(&nav.status, nav_source(&nav));
  app_status_time((uint32_t)(usecTimestamp() - start_us), planning);
}

/** Tick of the self-test, which borrows nav; commands are refused meanwhile. */
static void test_tick(void) {
  nav_input_t unused;
  app_sensors_read(&unused); // keeps watching whether the estimator has settled
  take_command();
  app_link_receive(&nav);
  if (app_selftest_step()) {
    app_params_init(&nav);
  }
}

/** Sleep until one period after the last wake-up, but REST_MS at least. */
static void wait(TickType_t *wake, TickType_t period_ms) {
  const TickType_t latest = xTaskGetTickCount() + M2T(REST_MS) - M2T(period_ms);
  if ((int32_t)(latest - *wake) > 0) {
    *wake = latest;
  }
  vTaskDelayUntil(wake, M2T(period_ms));
}

void appMain(void) {
  app_params_init(&nav);
  app_sensors_init();
  TickType_t wake = xTaskGetTickCount();
  while (true) {
    app_selftest_begin(&nav);
    if (app_selftest_running()) {
      wait(&wake, REST_MS);
      test_tick();
    } else {
      wait(&wake, PERIOD_MS);
      tick();
    }
  }
}
