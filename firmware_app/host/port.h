// SPDX-License-Identifier: GPL-3.0-or-later
/** @file port.h  What the files of the port tell each other. */
#ifndef PORT_H
#define PORT_H

#include <stdint.h>

uint32_t port_now_ms(void);
/** What an assertion does in the firmware: the app never runs again. */
void port_fail(const char *what);
/** A parameter was changed from within: a connected client is told. */
void port_param_changed(int id);

#endif
