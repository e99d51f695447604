// SPDX-License-Identifier: GPL-3.0-or-later
#include "app_setpoint.h"

#include "FreeRTOS.h"
#include "commander.h"
#include "supervisor.h"
#include "task.h"

enum { ZEROS_MS = 3000 }; ///< the supervisor reports flight for 2 s after the motors stopped

static const float DEG_PER_RAD = 57.29577951f;

static bool holding;         ///< our priority is active in the commander
static TickType_t motors_on; ///< last time the motors were on

static setpoint_t hover(const nav_setpoint_t *wanted) {
  setpoint_t setpoint = {0};
  setpoint.mode.z = modeAbs;
  setpoint.position.z = wanted->height_m;
  setpoint.mode.x = modeVelocity;
  setpoint.mode.y = modeVelocity;
  setpoint.velocity.x = wanted->velocity_body_mps.x;
  setpoint.velocity.y = wanted->velocity_body_mps.y;
  setpoint.velocity_body = true;
  setpoint.mode.yaw = modeVelocity;
  setpoint.attitudeRate.yaw = DEG_PER_RAD * wanted->yaw_rate_rps;
  return setpoint;
}

void app_setpoint_send(const nav_setpoint_t *wanted) {
  const TickType_t now = xTaskGetTickCount();
  if (wanted->motors) {
    setpoint_t setpoint = hover(wanted);
    commanderSetSetpoint(&setpoint, COMMANDER_PRIORITY_EXTRX);
    holding = true;
    motors_on = now;
  } else if (holding && (now - motors_on < M2T(ZEROS_MS) || supervisorIsFlying())) {
    setpoint_t zero = {0};
    commanderSetSetpoint(&zero, COMMANDER_PRIORITY_EXTRX);
  } else if (holding) {
    commanderRelaxPriority();
    holding = false;
  }
}
