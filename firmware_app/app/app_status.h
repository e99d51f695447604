// SPDX-License-Identifier: GPL-3.0-or-later
/** @file app_status.h  Log group `way`: state of the mission and of the app. */
#ifndef APP_STATUS_H
#define APP_STATUS_H

#include <stdint.h>

#include "nav.h"

/** Copy the core's status into the log variables. */
void app_status_show(const nav_status_t *status, nav_source_t source);
/** Log the duration of a tick. @param planning  it was spent on a plan */
void app_status_time(uint32_t tick_us, bool planning);
/** Log the answer to the last command. */
void app_status_answer(mission_reason_t reason);
/** Log the self-test's state, a selftest_state_t, and its hash. */
void app_status_selftest(uint8_t state, uint32_t hash);
/** Count a packet to or from the ground station that found no room. */
void app_status_count_drop(void);
/** Count a packet from the ground station that was invalid or refused. */
void app_status_count_bad(void);

#endif
