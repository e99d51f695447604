// SPDX-License-Identifier: GPL-3.0-or-later
/** @file port.h  Bytes in and bytes out, for programs that run on this machine and on the chip. */
#ifndef PORT_H
#define PORT_H

#include <stdbool.h>
#include <stddef.h>

/** The next size bytes of the input; false at its end. */
bool port_read(void *bytes, size_t size);
void port_write(const void *bytes, size_t size);

/** What a program does. */
void port_main(void);

#endif
