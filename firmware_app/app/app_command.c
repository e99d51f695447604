// SPDX-License-Identifier: GPL-3.0-or-later
#include "app_command.h"

#include "app_selftest.h"
#include "app_status.h"
#include "app_text.h"

#define DEBUG_MODULE "WAYFLIE"
#include "debug.h"

mission_reason_t app_command(nav_t *nav, const nav_command_t *command) {
  const mission_reason_t reason =
      app_selftest_running() ? MISSION_SELF_TEST : nav_command(nav, command);
  app_status_answer(reason);
  if (reason != MISSION_OK) {
    DEBUG_PRINT("command %d refused: %s\n", (int)command->cmd, app_reason_text(reason));
  }
  return reason;
}
