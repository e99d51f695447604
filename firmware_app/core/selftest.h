// SPDX-License-Identifier: GPL-3.0-or-later
/** @file selftest.h  Self-test: a flight in a built-in world, and a hash of all decisions in it.
 *
 *  The hash proves that a drone computes the same bits as a PC. The world uses the core's own
 *  arithmetic, so that nothing else can differ. The test borrows the caller's nav_t, which is too
 *  large to exist twice; afterwards it must be initialised again.
 */
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
  SELFTEST_AGREES, ///< the hash is selftest_golden()
  SELFTEST_DIFFERS,
} selftest_state_t;

typedef struct {
  nav_t *nav;
  nav_input_t input;            ///< of nav; its odometry reads 4 % too far
  pose2_t pose;                 ///< true pose of the body
  float measured_m[SCAN_BEAMS]; ///< ranges that are not published yet
  rng_t noise;                  ///< of the ranges
  uint32_t hash;                ///< of every decision so far
  uint16_t ticks;               ///< done
  uint8_t revision;             ///< of the route that was last hashed
  uint8_t state;                ///< selftest_state_t
} selftest_t;

/** Start the test. nav belongs to it until it is done. */
void selftest_start(selftest_t *test, nav_t *nav);
/** Run some ticks, each about as costly as nav_step(). @return true when done: then state and hash
 *  are final, and nav must be initialised again */
bool selftest_step(selftest_t *test, int ticks);
/** Hash of a build that works. */
uint32_t selftest_golden(void);

#endif
