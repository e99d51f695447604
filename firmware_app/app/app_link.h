// SPDX-License-Identifier: GPL-3.0-or-later
/** @file app_link.h  The app channel: commands and questions in, answers, route and events out.
 *  Nothing blocks. What finds no room in the transmit queue is counted, and sent later where the
 *  ground cannot ask for it again. */
#ifndef APP_LINK_H
#define APP_LINK_H

#include <stdbool.h>

#include "nav.h"

/** Take all packets that wait. */
void app_link_receive(nav_t *nav);
/** Somebody is there. A ground that has sent heartbeats in this flight is there while it beats:
 *  without them any client counts, cfclient and plain scripts too. */
bool app_link_ground_alive(void);
/** Send what is due: at most a few packets. */
void app_link_send(nav_t *nav);

#endif
