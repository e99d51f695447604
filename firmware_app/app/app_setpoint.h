// SPDX-License-Identifier: GPL-3.0-or-later
/** @file app_setpoint.h  Sends nav_setpoint_t to the firmware's commander, in degrees again.
 *
 *  Setpoints have the priority of an external receiver. A client that closes its link sends a zero
 *  setpoint at a lower priority, which must not stop the motors in flight. So no other client can
 *  steer meanwhile; the emergency stop works as always.
 */
#ifndef APP_SETPOINT_H
#define APP_SETPOINT_H

#include "nav.h"

/** Send the setpoint of this tick. After a flight zero setpoints follow until the supervisor has
 *  noticed the landing; only then is the commander released. */
void app_setpoint_send(const nav_setpoint_t *wanted);

#endif
