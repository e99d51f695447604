// SPDX-License-Identifier: GPL-3.0-or-later
/** @file app_status.h  What the app tells about itself: log group `way`. */
#ifndef APP_STATUS_H
#define APP_STATUS_H

#include <stdint.h>

#include "nav.h"

/** Copy what the core knows into the log variables. */
void app_status_show(const nav_status_t *status, nav_source_t source);
/** Remember how long a tick took; planning: it served to find a route. */
void app_status_time(uint32_t tick_us, bool planning);
/** Remember the answer to the last command. */
void app_status_answer(mission_reason_t reason);
/** Show how the self-test stands, a selftest_state_t, and what it computed. */
void app_status_selftest(uint8_t state, uint32_t hash);
/** A packet to or from the ground found no room. */
void app_status_count_drop(void);
/** A packet from the ground made no sense. */
void app_status_count_bad(void);

#endif
