// SPDX-License-Identifier: GPL-3.0-or-later
/** @file commander.h  Host version: who may steer. */
#ifndef COMMANDER_H
#define COMMANDER_H

#include "stabilizer_types.h"

#define COMMANDER_PRIORITY_DISABLE   0
#define COMMANDER_PRIORITY_LOWEST    1
#define COMMANDER_PRIORITY_HIGHLEVEL 1
#define COMMANDER_PRIORITY_CRTP      2
#define COMMANDER_PRIORITY_EXTRX     3

/** Taken if priority is not below the active one, which it then becomes; stamps the setpoint. */
void commanderSetSetpoint(setpoint_t *setpoint, int priority);
int commanderGetActivePriority(void);
/** From now on any setpoint is taken. */
void commanderRelaxPriority(void);

#endif
