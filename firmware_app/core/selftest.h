// SPDX-License-Identifier: GPL-3.0-or-later
/** @file selftest.h  A flight through a small world that exists only here, and a number for all
 * that nav decided on it. The same number on a PC and on a drone: both compute the same bits. The
 * world answers with this core's own arithmetic, so that nothing else can differ. It borrows the
 * caller's nav, which is too large to have twice, and leaves it to be initialised anew. */
#ifndef SELFTEST_H
#define SELFTEST_H

#include <stdbool.h>
#include <stdint.h>

#include "nav.h"
#include "rng.h"

enum { SELFTEST_TICKS = 1050 }; ///< 21 s of flight

typedef enum {
  SELFTEST_NOT_RUN,
  SELFTEST_RUNNING,
  SELFTEST_AGREES,
  SELFTEST_DIFFERS,
} selftest_state_t;

typedef struct {
  nav_t *nav;
  nav_input_t input;            ///< what nav is given: odometry reads a little too far
  pose2_t pose;                 ///< where the body truly is
  float measured_m[SCAN_BEAMS]; ///< not yet published
  rng_t noise;
  uint32_t hash;    ///< of every decision so far
  uint16_t ticks;   ///< done
  uint8_t revision; ///< of the route that is in the hash
  uint8_t state;    ///< selftest_state_t
} selftest_t;

/** Begin. nav belongs to the test until it is done. */
void selftest_start(selftest_t *test, nav_t *nav);
/** Fly on for some ticks, each of which costs about as much as nav_step. @return true when done:
 * then state and hash stand, and nav must be initialised anew */
bool selftest_step(selftest_t *test, int ticks);
/** The hash that a build without fault ends with. */
uint32_t selftest_golden(void);

#endif
