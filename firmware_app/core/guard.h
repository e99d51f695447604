// SPDX-License-Identifier: GPL-3.0-or-later
/** @file guard.h  The reflex: raw ranges against the wanted velocity, every tick, without map or
 * SLAM. Slows with the distance ahead, stops, and backs away from the weighted centre of what is
 * near (nearer weighs more), never towards a side that has no room. */
#ifndef GUARD_H
#define GUARD_H

#include <stdint.h>

#include "geometry.h"
#include "scan.h"

typedef enum { GUARD_CLEAR, GUARD_SLOW, GUARD_STOP, GUARD_RETREAT } guard_status_t;

typedef struct {
  float slow_m;    ///< nearer than this in the direction of flight: slow down
  float stop_m;    ///< nearer than this: no velocity towards it
  float retreat_m; ///< nearer than this: back away
  float release_m; ///< backing away ends at this distance
  float retreat_mps;
  float reaction_s; ///< age of the ranges and of the vehicle's answer, for the stopping distance
  float brake_mps2;
} guard_config_t;

typedef struct {
  guard_status_t status;
  float nearest_m; ///< nearest level range, or a large number
  vec2_t away;     ///< unit vector (body frame) in which it backs away, else zero
} guard_t;

guard_config_t guard_config_default(void);
void guard_init(guard_t *guard);
/** @param range_m  SCAN_RANGES distances [m] as published, negative where none
 *  @param wanted_mps  body frame
 *  @return the velocity allowed, body frame, never faster than wanted or retreat_mps */
vec2_t guard_step(guard_t *guard, const guard_config_t *cfg, const float *range_m,
                  vec2_t wanted_mps);

#endif
