// SPDX-License-Identifier: GPL-3.0-or-later
/** @file app_map.h  The map stream: log group `waymap`.
 *
 *  Log variables are sampled in another task. The app's loop puts pieces into a ring and the
 *  variables' getters take them out: one producer, one consumer. Only the app touches the grid.
 */
#ifndef APP_MAP_H
#define APP_MAP_H

#include "nav.h"

/** Put the next pieces into the ring. */
void app_map_refill(nav_t *nav);

#endif
