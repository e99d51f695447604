// SPDX-License-Identifier: GPL-3.0-or-later
/** @file app_channel.h  Host version: raw packets between the app and the ground station. */
#ifndef APP_CHANNEL_H
#define APP_CHANNEL_H

#include <stdbool.h>
#include <stddef.h>

#define APPCHANNEL_MTU 30

/** Never blocks. @return pdTRUE, or errQUEUE_FULL: the packet is lost */
int appchannelSendDataPacket(void *data, size_t length);
/** timeout_ms must be 0. @return bytes received; 0 if no packet waits, or an empty one */
size_t appchannelReceiveDataPacket(void *buffer, size_t max_length, int timeout_ms);
/** @return true if a packet was lost since the last call because the receive queue was full */
bool appchannelHasOverflowOccurred(void);

#endif
