// SPDX-License-Identifier: GPL-3.0-or-later
/** @file any.h  Values about which Frama-C knows nothing: all that a type can hold, for floats NaN
 * and infinities too. */
#ifndef ANY_H
#define ANY_H

#include <stdint.h>

#include "geometry.h"

extern volatile float any_float;
extern volatile int any_int;
extern volatile uint32_t any_u32;
extern volatile uint8_t any_u8;

static inline vec2_t any_vec2(void) {
  return (vec2_t){any_float, any_float};
}

static inline pose2_t any_pose2(void) {
  return (pose2_t){any_float, any_float, any_float};
}

static inline float any_between(float low, float high) {
  float value = any_float;
  return value >= low && value <= high ? value : low;
}

#endif
