// SPDX-License-Identifier: GPL-3.0-or-later
#include <stdio.h>

#include "port.h"

bool port_read(void *bytes, size_t size) {
  return fread(bytes, 1, size, stdin) == size;
}

void port_write(const void *bytes, size_t size) {
  fwrite(bytes, 1, size, stdout);
}

int main(void) {
  port_main();
  return 0;
}
