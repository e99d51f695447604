// SPDX-License-Identifier: GPL-3.0-or-later
/** @file app_channel.h  Host version: raw packets between the app and its ground station. */
#ifndef APP_CHANNEL_H
#define APP_CHANNEL_H

#include <stdbool.h>
#include <stddef.h>

#define APPCHANNEL_MTU 30

/** Never blocks. @return pdTRUE, or errQUEUE_FULL: the packet is lost */
int appchannelSendDataPacket(void *data, size_t length);
/** Here only with timeout_ms 0. @return bytes received, 0 if none wait; an empty packet is none */
size_t appchannelReceiveDataPacket(void *buffer, size_t max_length, int timeout_ms);
/** A packet was lost because the receive queue was full; forgets it. */
bool appchannelHasOverflowOccurred(void);

#endif
