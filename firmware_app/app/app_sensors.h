// SPDX-License-Identifier: GPL-3.0-or-later
/** @file app_sensors.h  From the firmware's log variables, parameters and supervisor to
 * nav_input_t. Millimetres and degrees end here. */
#ifndef APP_SENSORS_H
#define APP_SENSORS_H

#include "nav.h"

/** Look everything up once. What is missing is named on the console, and flying is refused. */
void app_sensors_init(void);
void app_sensors_read(nav_input_t *input);

#endif
