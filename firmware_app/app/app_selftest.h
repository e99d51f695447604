// SPDX-License-Identifier: GPL-3.0-or-later
/** @file app_selftest.h  Self-test: does this chip compute the same bits as a PC?
 *
 *  Requested by parameter way.selftest; the result is in the log variables way.selfState and
 *  way.selfHash, and on the console.
 */
#ifndef APP_SELFTEST_H
#define APP_SELFTEST_H

#include <stdbool.h>

#include "nav.h"

/** Start the test if it is requested. Refused in the air and once there is a map: it uses nav. */
void app_selftest_begin(nav_t *nav);
/** Is the test running? Nothing else may use nav meanwhile. */
bool app_selftest_running(void);
/** Run one tick of the test. @return true when it is done: nav must then be initialised again */
bool app_selftest_step(void);

#endif
