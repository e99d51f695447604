// SPDX-License-Identifier: GPL-3.0-or-later
/** @file supervisor.h  Host version: what the supervisor lets the vehicle do. */
#ifndef SUPERVISOR_H
#define SUPERVISOR_H

#include <stdbool.h>

bool supervisorCanFly(void);
bool supervisorIsFlying(void);
bool supervisorIsTumbled(void);
bool supervisorIsArmed(void);
bool supervisorIsLocked(void);
bool supervisorIsCrashed(void);
/** Only noted for the simulator. @return false: nothing is granted at once */
bool supervisorRequestArming(bool arm);

#endif
