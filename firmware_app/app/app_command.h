// SPDX-License-Identifier: GPL-3.0-or-later
/** @file app_command.h  The one door for commands, whichever way they came. */
#ifndef APP_COMMAND_H
#define APP_COMMAND_H

#include "nav.h"

/** Give it to the core, and tell log and console the answer. */
mission_reason_t app_command(nav_t *nav, const nav_command_t *command);

#endif
