// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
#include "lattice.h"

#include <math.h>

static const float CELLS_PER_STEP = 1.0f / LATTICE_PER_CELL;

static int16_t rounded_down(float cells) {
  return (int16_t)geometry_clamp(cells * LATTICE_PER_CELL, 0.0f, (float)LATTICE_MAX);
}

lattice_t lattice_from_cells(vec2_t cells) {
  return (lattice_t){rounded_down(cells.x), rounded_down(cells.y)};
}

vec2_t lattice_to_cells(lattice_t p) {
  return (vec2_t){(float)p.x * CELLS_PER_STEP, (float)p.y * CELLS_PER_STEP};
}

bool lattice_equal(lattice_t a, lattice_t b) {
  return a.x == b.x && a.y == b.y;
}

float lattice_distance(lattice_t a, lattice_t b) {
  float dx = (float)(b.x - a.x);
  float dy = (float)(b.y - a.y);
  return sqrtf(dx * dx + dy * dy) * CELLS_PER_STEP;
}

int32_t lattice_cross(lattice_t o, lattice_t a, lattice_t b) {
  return (a.x - o.x) * (b.y - o.y) - (a.y - o.y) * (b.x - o.x);
}

void lattice_reverse(lattice_t *points, int count) {
  for (int i = 0, j = count - 1; i < j; i++, j--) {
    lattice_t kept = points[i];
    points[i] = points[j];
    points[j] = kept;
  }
}

float lattice_length(const lattice_t *points, int count) {
  float length_cells = 0.0f;
  for (int i = 1; i < count; i++) {
    length_cells += lattice_distance(points[i - 1], points[i]);
  }
  return length_cells;
}
