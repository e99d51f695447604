// SPDX-License-Identifier: GPL-3.0-or-later
/** @file task.h  Host version: a delay returns control to the simulator. */
#ifndef TASK_H
#define TASK_H

#include "FreeRTOS.h"

TickType_t xTaskGetTickCount(void);
/** Add increment to *previous_wake and sleep until then; return at once if that is in the past. */
void vTaskDelayUntil(TickType_t *previous_wake, TickType_t increment);

#endif
