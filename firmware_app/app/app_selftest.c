// SPDX-License-Identifier: GPL-3.0-or-later
#include "app_selftest.h"

#include "app_params.h"
#include "app_status.h"
#include "selftest.h"

#define DEBUG_MODULE "WAYFLIE"
#include "debug.h"

static selftest_t test;

static void show(void) {
  app_status_selftest(test.state, test.hash);
}

void app_selftest_begin(nav_t *nav) {
  if (!app_params_take_selftest()) {
    return;
  }
  if (nav->mapped || nav->mission.state != MISSION_IDLE || nav->mission.task != MISSION_TASK_NONE) {
    DEBUG_PRINT("self-test refused: only on the ground, without a map\n");
    return;
  }
  DEBUG_PRINT("self-test: flies in a world of its own\n");
  selftest_start(&test, nav);
  show();
}

bool app_selftest_running(void) {
  return test.state == SELFTEST_RUNNING;
}

bool app_selftest_step(void) {
  const bool done = selftest_step(&test, 1);
  if (done) {
    const bool agrees = test.state == SELFTEST_AGREES;
    DEBUG_PRINT("self-test: computes %s a PC does\n", agrees ? "what" : "something else than");
    show();
  }
  return done;
}
