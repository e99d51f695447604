// SPDX-License-Identifier: GPL-3.0-or-later
/** @file app_sensors.h  Fills nav_input_t from log variables, parameters and the supervisor.
 *
 *  Millimetres and degrees are converted to SI units here.
 */
#ifndef APP_SENSORS_H
#define APP_SENSORS_H

#include "nav.h"

/** Look up all sources once. Missing ones are named on the console, and flying is refused. */
void app_sensors_init(void);
/** Read the input of this tick. */
void app_sensors_read(nav_input_t *input);

#endif
