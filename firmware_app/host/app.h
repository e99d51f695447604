// SPDX-License-Identifier: GPL-3.0-or-later
/** @file app.h  Host version: entry point of the app. */
#ifndef APP_H
#define APP_H

/** Runs in a task of its own once the system has started; does not return. */
void appMain(void);

#endif
