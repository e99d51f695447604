// SPDX-License-Identifier: GPL-3.0-or-later
/* Reads ('R') or writes ('W') one word at the address that it is given. */
#include <stdint.h>

#include "port.h"

void port_main(void) {
  uint8_t what;
  uint32_t address;
  while (port_read(&what, sizeof what) && port_read(&address, sizeof address)) {
    volatile uint32_t *word = (volatile uint32_t *)(uintptr_t)address;
    uint32_t value = what == 'R' ? *word : (*word = 0x5A5A5A5A);
    port_write(&value, sizeof value);
  }
}
