// SPDX-License-Identifier: GPL-3.0-or-later
/* Rays between any points that the contract of ray_start allows. */
#include "any.h"
#include "ray.h"

static vec2_t any_cells(void) {
  return (vec2_t){any_between(-1.0e6f, 1.0e6f), any_between(-1.0e6f, 1.0e6f)};
}

int main(void) {
  ray_t ray = ray_start(any_cells(), any_cells());
  while (ray_next(&ray)) {
  }
  return 0;
}
