// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
#include "rng.h"

rng_t rng_seed(uint32_t seed) {
  uint32_t mixed = seed * 2654435761u + 0x9E3779B9u; // Knuth's multiplicative hash
  mixed ^= mixed >> 15;
  return (rng_t){.state = mixed != 0u ? mixed : 1u};
}

uint32_t rng_next(rng_t *rng) {
  uint32_t s = rng->state;
  s ^= s << 13;
  s ^= s >> 17;
  s ^= s << 5;
  rng->state = s;
  return s;
}

float rng_uniform(rng_t *rng) {
  return (float)(rng_next(rng) >> 8) * (1.0f / 16777216.0f);
}
