// SPDX-License-Identifier: GPL-3.0-or-later
/** @file debug.h  Host version: DEBUG_PRINT goes to the console that a client sees. */
#ifndef DEBUG_H
#define DEBUG_H

#ifdef DEBUG_MODULE
#define DEBUG_PRINT(fmt, ...) consolePrintf(DEBUG_MODULE ": " fmt, ##__VA_ARGS__)
#else
#define DEBUG_PRINT(fmt, ...) consolePrintf(fmt, ##__VA_ARGS__)
#endif

__attribute__((format(printf, 1, 2))) void consolePrintf(const char *format, ...);

#endif
