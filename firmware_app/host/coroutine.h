// SPDX-License-Identifier: GPL-3.0-or-later
/** @file coroutine.h  The app's task as a coroutine: either it runs, or the simulator.
 *
 *  The only part of the port that depends on the machine.
 */
#ifndef COROUTINE_H
#define COROUTINE_H

/** Create the task without running it. Its body must never return. */
void coroutine_make(void (*body)(void));
/** Run the task until it yields. */
void coroutine_resume(void);
/** Called in the task: return to the caller of coroutine_resume(). */
void coroutine_yield(void);

#endif
