// SPDX-License-Identifier: GPL-3.0-or-later
/** @file app_positioning.h  Finds out which system measures the position, and feeds the estimator.
 *
 *  Positioning systems: Lighthouse, Loco, and positions sent from the ground. With way.slam 2 this
 *  app feeds the SLAM pose to the firmware's estimator.
 */
#ifndef APP_POSITIONING_H
#define APP_POSITIONING_H

#include "nav.h"

/** Look up log variables and parameters once. What this firmware lacks counts as absent. */
void app_positioning_init(void);
/** System that has measured the position lately and that the estimator follows. */
nav_positioning_t app_positioning_now(void);
/** Feed the estimator if nav has a correction. Call it in each tick, after nav_step(). */
void app_positioning_tell(nav_t *nav);

#endif
