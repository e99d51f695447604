// SPDX-License-Identifier: GPL-3.0-or-later
/** @file commander.h  Host version: setpoints and their priorities. */
#ifndef COMMANDER_H
#define COMMANDER_H

#include "stabilizer_types.h"

#define COMMANDER_PRIORITY_LOWEST 1
#define COMMANDER_PRIORITY_EXTRX  3

/** Time-stamp the setpoint and take it unless its priority is below the active one; its priority
 *  is then the active one. */
void commanderSetSetpoint(setpoint_t *setpoint, int priority);
/** Accept any setpoint from now on. */
void commanderRelaxPriority(void);

#endif
