// SPDX-License-Identifier: GPL-3.0-or-later
/* The setpoint of the highest priority wins; it holds the vehicle until the priority is relaxed. */
#include "commander.h"

#include "port.h"
#include "sim_port.h"

static setpoint_t current;
static int current_setter;
static int active_priority;

static bool take(const setpoint_t *setpoint, int priority) {
  if (priority < active_priority) {
    return false;
  }
  current = *setpoint;
  current.timestamp = port_now_ms();
  current_setter = priority;
  active_priority = priority;
  return true;
}

void commanderSetSetpoint(setpoint_t *setpoint, int priority) {
  setpoint->timestamp = port_now_ms();
  take(setpoint, priority);
}

void commanderRelaxPriority(void) {
  active_priority = COMMANDER_PRIORITY_LOWEST;
}

void sim_port_relax_priority(void) {
  commanderRelaxPriority();
}

int sim_port_active_priority(void) {
  return active_priority;
}

void sim_port_get_setpoint(sim_port_setpoint_t *setpoint) {
  const setpoint_t *from = &current;
  *setpoint = (sim_port_setpoint_t){
      .mode_x = (uint8_t)from->mode.x,
      .mode_y = (uint8_t)from->mode.y,
      .mode_z = (uint8_t)from->mode.z,
      .mode_roll = (uint8_t)from->mode.roll,
      .mode_pitch = (uint8_t)from->mode.pitch,
      .mode_yaw = (uint8_t)from->mode.yaw,
      .velocity_body = from->velocity_body,
      .x_m = from->position.x,
      .y_m = from->position.y,
      .z_m = from->position.z,
      .vx_mps = from->velocity.x,
      .vy_mps = from->velocity.y,
      .vz_mps = from->velocity.z,
      .roll_deg = from->attitude.roll,
      .pitch_deg = from->attitude.pitch,
      .yaw_deg = from->attitude.yaw,
      .yaw_rate_dps = from->attitudeRate.yaw,
      .thrust = from->thrust,
      .age_ms = port_now_ms() - from->timestamp,
      .priority = (uint8_t)current_setter,
  };
}

bool sim_port_put_setpoint(const sim_port_setpoint_t *setpoint, int priority) {
  const setpoint_t taken = {
      .mode = {.x = (stab_mode_t)setpoint->mode_x,
               .y = (stab_mode_t)setpoint->mode_y,
               .z = (stab_mode_t)setpoint->mode_z,
               .roll = (stab_mode_t)setpoint->mode_roll,
               .pitch = (stab_mode_t)setpoint->mode_pitch,
               .yaw = (stab_mode_t)setpoint->mode_yaw},
      .velocity_body = setpoint->velocity_body,
      .position = {setpoint->x_m, setpoint->y_m, setpoint->z_m},
      .velocity = {setpoint->vx_mps, setpoint->vy_mps, setpoint->vz_mps},
      .attitude = {setpoint->roll_deg, setpoint->pitch_deg, setpoint->yaw_deg},
      .attitudeRate = {.yaw = setpoint->yaw_rate_dps},
      .thrust = setpoint->thrust,
  };
  return take(&taken, priority);
}
