// SPDX-License-Identifier: GPL-3.0-or-later
/** @file app_selftest.h  Does this chip compute what a PC computes? Asked by parameter
 * way.selftest, answered by the log variables way.selfState and way.selfHash, and in words. */
#ifndef APP_SELFTEST_H
#define APP_SELFTEST_H

#include <stdbool.h>

#include "nav.h"

/** Begin if it is asked for. Refused in the air and once there is a map, because it borrows nav. */
void app_selftest_begin(nav_t *nav);
/** Nobody else may use nav meanwhile. */
bool app_selftest_running(void);
/** One tick of the test. @return true when it is done: nav must be initialised anew */
bool app_selftest_step(void);

#endif
