// SPDX-License-Identifier: GPL-3.0-or-later
/** @file app_link.h  The app channel: commands and requests in; answers, route and events out.
 *
 *  Nothing blocks. What finds no room in the transmit queue is counted as dropped; it is sent later
 *  unless the ground station can ask for it again.
 */
#ifndef APP_LINK_H
#define APP_LINK_H

#include <stdbool.h>

#include "nav.h"

/** Handle all packets that wait. */
void app_link_receive(nav_t *nav);
/** Is a ground station connected? One that has sent heartbeats in this flight must go on doing so;
 *  otherwise any client counts, such as cfclient or a plain cflib script. */
bool app_link_ground_alive(void);
/** Send what is due, a few packets at most. */
void app_link_send(nav_t *nav);

#endif
