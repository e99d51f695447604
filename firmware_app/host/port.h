// SPDX-License-Identifier: GPL-3.0-or-later
/** @file port.h  Shared by the source files of the host port only. */
#ifndef PORT_H
#define PORT_H

#include <stdint.h>

uint32_t port_now_ms(void);
/** Like a failed assertion in the firmware: the app never runs again. */
void port_fail(const char *what);
/** Notify a connected client that the firmware itself changed a parameter. */
void port_param_changed(int id);

#endif
