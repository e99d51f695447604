// SPDX-License-Identifier: GPL-3.0-or-later
/** @file app_map.h  The map stream: log group `waymap`.
 *  Log variables are sampled in another task. The app's loop prepares pieces in a ring, the getters
 *  take them out: one producer, one consumer, and the grid is touched by the app alone. */
#ifndef APP_MAP_H
#define APP_MAP_H

#include "nav.h"

/** Put the next pieces into the ring. */
void app_map_refill(nav_t *nav);

#endif
