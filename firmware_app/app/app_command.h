// SPDX-License-Identifier: GPL-3.0-or-later
/** @file app_command.h  Single entry for commands, from parameters and from the app channel. */
#ifndef APP_COMMAND_H
#define APP_COMMAND_H

#include "nav.h"

/** Give a command to the core; log the answer, and print a refusal on the console. */
mission_reason_t app_command(nav_t *nav, const nav_command_t *command);

#endif
