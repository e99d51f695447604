// SPDX-License-Identifier: GPL-3.0-or-later
/** @file supervisor.h  Host version: the supervisor's state. */
#ifndef SUPERVISOR_H
#define SUPERVISOR_H

#include <stdbool.h>

bool supervisorCanFly(void);
bool supervisorIsFlying(void);
bool supervisorIsTumbled(void);
bool supervisorIsArmed(void);
bool supervisorIsLocked(void);
bool supervisorIsCrashed(void);
/** Pass a request on to the simulator. @return false: arming takes effect later, if at all */
bool supervisorRequestArming(bool arm);

#endif
