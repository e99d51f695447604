// SPDX-License-Identifier: GPL-3.0-or-later
/** @file task.h  Host version: a delay hands the processor back to the simulator. */
#ifndef TASK_H
#define TASK_H

#include "FreeRTOS.h"

TickType_t xTaskGetTickCount(void);
void vTaskDelay(TickType_t ticks);
/** Sleep until *previous_wake + increment, and store that there; returns at once if it is past. */
void vTaskDelayUntil(TickType_t *previous_wake, TickType_t increment);

#endif
