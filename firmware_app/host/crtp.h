// SPDX-License-Identifier: GPL-3.0-or-later
/** @file crtp.h  Host version: state of the link to the client. */
#ifndef CRTP_H
#define CRTP_H

#include <stdbool.h>

bool crtpIsConnected(void);
int crtpGetFreeTxQueuePackets(void);

#endif
