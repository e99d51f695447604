// SPDX-License-Identifier: GPL-3.0-or-later
/** @file app_positioning.h  Who measures the position: Lighthouse, Loco, the ground, or this app,
 * which tells the firmware's estimator where SLAM says it is (way.slam 2). */
#ifndef APP_POSITIONING_H
#define APP_POSITIONING_H

#include "nav.h"

/** Look everything up once. What is not in this firmware is not there. */
void app_positioning_init(void);
/** What has measured the position within the last moments; the estimator must have believed it. */
nav_positioning_t app_positioning_now(void);
/** Tell the estimator, if nav has something to tell. Call it in the tick, after nav_step. */
void app_positioning_tell(nav_t *nav);

#endif
