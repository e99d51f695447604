// SPDX-License-Identifier: GPL-3.0-or-later
/** @file app_params.h  Parameter group `way`: tuning, and commands by parameter.
 *
 *  Parameters are written by another task at any time and applied between two ticks. A value that
 *  the core refuses is set back, which tells the client.
 */
#ifndef APP_PARAMS_H
#define APP_PARAMS_H

#include "nav.h"

/** Initialise nav with the default configuration; app_params_apply() then applies what differs.
 *  To be called again after the self-test has used nav. */
void app_params_init(nav_t *nav);
/** Give changed values to the core. */
void app_params_apply(nav_t *nav);
/** @return true if way.cmd was written; it then reads 0 again */
bool app_params_take_command(nav_command_t *command);
/** @return true if way.selftest requests a test: at the start, or since it was written */
bool app_params_take_selftest(void);

#endif
