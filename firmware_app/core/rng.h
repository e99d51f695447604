// SPDX-License-Identifier: GPL-3.0-or-later
/** @file rng.h  Small seeded pseudo-random number generator; the caller owns its state.
 *
 * Source: Marsaglia, Xorshift RNGs, J. Stat. Software 8(14), 2003, the (13, 17, 5) generator.
 * Not for secrets. */
#ifndef RNG_H
#define RNG_H

#include <stdint.h>

typedef struct {
  uint32_t state; ///< never 0
} rng_t;

/** Any seed will do, even 0: it is mixed first. */
rng_t rng_seed(uint32_t seed);
uint32_t rng_next(rng_t *rng);
/** Uniform in [0, 1), a multiple of 2^-24. */
float rng_uniform(rng_t *rng);

#endif
