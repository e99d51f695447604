// SPDX-License-Identifier: GPL-3.0-or-later
/** @file bytes.h  A fuzz target's input, read one value after the other; zeros once it has ended.
 */
#ifndef BYTES_H
#define BYTES_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
  const uint8_t *next;
  size_t left;
} bytes_t;

/** What must hold: libFuzzer keeps the input that breaks it. */
#define REQUIRE(condition)                                                                         \
  do {                                                                                             \
    if (!(condition)) {                                                                            \
      fprintf(stderr, "%s:%d: not true: %s\n", __FILE__, __LINE__, #condition);                    \
      abort();                                                                                     \
    }                                                                                              \
  } while (0)

static inline void take(bytes_t *bytes, void *to, size_t size) {
  size_t there = size < bytes->left ? size : bytes->left;
  memset(to, 0, size);
  if (there > 0) {
    memcpy(to, bytes->next, there);
  }
  bytes->next += there;
  bytes->left -= there;
}

static inline uint8_t take_u8(bytes_t *bytes) {
  uint8_t value;
  take(bytes, &value, sizeof value);
  return value;
}

static inline uint32_t take_u32(bytes_t *bytes) {
  uint32_t value;
  take(bytes, &value, sizeof value);
  return value;
}

/** 0 to count - 1. */
static inline int take_below(bytes_t *bytes, int count) {
  return take_u8(bytes) % count;
}

/** In 65,536 steps from low to high, both included. */
static inline float take_between(bytes_t *bytes, float low, float high) {
  uint16_t steps;
  take(bytes, &steps, sizeof steps);
  return low + (high - low) * ((float)steps / 65535.0f);
}

/** Any bit pattern: NaN, infinities, denormals. */
static inline float take_bits(bytes_t *bytes) {
  float value;
  take(bytes, &value, sizeof value);
  return value;
}

/** In range as a rule; with one first byte of sixteen any bit pattern, with another absurd. */
static inline float take_float(bytes_t *bytes, float low, float high) {
  static const float absurd[] = {NAN,   INFINITY, -INFINITY, 1e30f,  -1e30f, 3.4e38f, 1e-40f,
                                 -0.0f, 1e10f,    -3e9f,     999.0f, -1e5f,  65536.0f};
  int kind = take_below(bytes, 16);
  if (kind == 14) {
    return absurd[take_below(bytes, (int)(sizeof absurd / sizeof absurd[0]))];
  }
  return kind == 15 ? take_bits(bytes) : take_between(bytes, low, high);
}

#endif
