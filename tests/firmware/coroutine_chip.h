// SPDX-License-Identifier: GPL-3.0-or-later
/** @file coroutine_chip.h  coroutine.h for the chip. The stack is as large as the firmware makes
 *  the app's, and lies where nothing lies below: what overflows it ends the run. */
#ifndef COROUTINE_CHIP_H
#define COROUTINE_CHIP_H

#include <stdint.h>

#include "coroutine.h"

/** Most bytes of its stack that the task has used so far. */
uint32_t coroutine_stack_used(void);

#endif
