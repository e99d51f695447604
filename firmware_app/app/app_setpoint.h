// SPDX-License-Identifier: GPL-3.0-or-later
/** @file app_setpoint.h  From nav_setpoint_t to the firmware's commander. Degrees begin again here.
 *  Sent at the priority of an external receiver: a client that closes its link sends a zero
 * setpoint at a lower one, which must not stop the motors in flight. Nobody else can steer
 * meanwhile; the emergency stop works as ever. */
#ifndef APP_SETPOINT_H
#define APP_SETPOINT_H

#include "nav.h"

/** Call it every tick. After the motors were on, zero setpoints follow until the supervisor has
 *  noticed the landing; only then the vehicle is given back. */
void app_setpoint_send(const nav_setpoint_t *wanted);

#endif
