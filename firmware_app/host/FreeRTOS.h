// SPDX-License-Identifier: GPL-3.0-or-later
/** @file FreeRTOS.h  Host version: types of the kernel. A kernel tick is one millisecond. */
#ifndef FREERTOS_H
#define FREERTOS_H

#include <stdint.h>

typedef uint32_t TickType_t;

#define pdTRUE        1
#define errQUEUE_FULL 0
#define M2T(ms)       ((TickType_t)(ms))
#define T2M(ticks)    ((uint32_t)(ticks))

#endif
