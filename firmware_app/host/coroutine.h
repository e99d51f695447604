// SPDX-License-Identifier: GPL-3.0-or-later
/** @file coroutine.h  The app's task beside whoever simulates: one runs while the other waits.
 *  The only part of the port that depends on the machine. */
#ifndef COROUTINE_H
#define COROUTINE_H

/** Make the task; it does not run yet. Its body never returns. */
void coroutine_make(void (*body)(void));
/** Let the task run until it yields. */
void coroutine_resume(void);
/** Called in the task: go on where it was resumed. */
void coroutine_yield(void);

#endif
