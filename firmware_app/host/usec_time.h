// SPDX-License-Identifier: GPL-3.0-or-later
/** @file usec_time.h  Host version: simulated time, which stands still while the app computes. */
#ifndef USEC_TIME_H
#define USEC_TIME_H

#include <stdint.h>

uint64_t usecTimestamp(void);

#endif
