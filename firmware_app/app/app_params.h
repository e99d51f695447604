// SPDX-License-Identifier: GPL-3.0-or-later
/** @file app_params.h  Parameter group `way`: what the user tunes, and one way to command.
 *  Parameters are written by another task at any time. Here they are looked at between two ticks: a
 *  value that the core refuses is put back, and the client is told the old value. */
#ifndef APP_PARAMS_H
#define APP_PARAMS_H

#include "nav.h"

/** Begin with the default configuration; values that differ are offered by app_params_apply. Again
 * whenever somebody else has used nav. */
void app_params_init(nav_t *nav);
/** Hand changed values to the core. */
void app_params_apply(nav_t *nav);
/** @return true if way.cmd was written; it reads 0 again then */
bool app_params_take_command(nav_command_t *command);
/** @return true if way.selftest asks for one: after the start, or since it was written */
bool app_params_take_selftest(void);

#endif
