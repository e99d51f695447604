// SPDX-License-Identifier: GPL-3.0-or-later
/** @file guard.h  The reflex: raw ranges against the wanted velocity, every tick, without map or
 * SLAM. Slows with the distance ahead, stops, and backs away from the weighted centre of what is
 * near (nearer weighs more), never towards a side that has no room. Of what comes nearer by itself
 * it keeps a larger distance: it gives way at the speed at which that comes, aside where there is
 * no room behind, and remembers it for a while when no beam meets it. */
#ifndef GUARD_H
#define GUARD_H

#include <stdbool.h>
#include <stdint.h>

#include "geometry.h"
#include "grid.h"
#include "scan.h"

#define GUARD_REMEMBERED_S 1.5f ///< a comer that no beam meets
#define GUARD_SLIP_MPS     1.0f ///< more is not made up for
enum { GUARD_RESTLESS = 20 /* of jumps, and the beam is not believed */ };

typedef enum { GUARD_CLEAR, GUARD_SLOW, GUARD_STOP, GUARD_RETREAT } guard_status_t;

typedef struct {
  float slow_m;    ///< nearer than this in the direction of flight: slow down
  float stop_m;    ///< nearer than this: no velocity towards it
  float retreat_m; ///< nearer than this: back away
  float release_m; ///< backing away ends at this distance
  float yield_m;   ///< kept from what comes by itself; 0: it is as any wall
  float retreat_mps;
  float yield_mps;  ///< at most, backing away from what comes
  float reaction_s; ///< age of the ranges and of the vehicle's answer, for the stopping distance
  float brake_mps2;
} guard_config_t;

typedef struct {
  guard_status_t status;
  float nearest_m; ///< nearest level range, or a large number
  vec2_t away;     ///< unit vector (body frame) in which it backs away, else zero
  // the set before, odometry frame
  float seen_m[SCAN_BEAMS]; ///< level ranges, 0 where nothing near
  pose2_t seen_from;
  uint32_t seen_ms;
  uint8_t coming[SCAN_BEAMS];   ///< sets in a row in which a beam's echo came by itself
  uint8_t restless[SCAN_BEAMS]; ///< how often a beam's near echo has jumped lately
  vec2_t slip_mps; ///< odometry is so much faster than the body by its echoes, odometry frame
  vec2_t hint_m;   ///< what may be a comer, odometry frame
  uint32_t hint_ms;
  uint8_t doubtful; ///< beams of the last set that fell too far at once
  // the comer
  bool met;
  bool untold;       ///< it may be a wall that is not drawn yet: kept off, not given way to
  int8_t way;        ///< beam along which it gives way, or -1
  uint32_t met_ms;   ///< when it was met first, or has moved on
  vec2_t met_m;      ///< where that was
  uint32_t comer_ms; ///< and last
  vec2_t comer_m;    ///< where, odometry frame
  float comer_mps;   ///< how fast it comes
} guard_t;

guard_config_t guard_config_default(void);
void guard_init(guard_t *guard);
/** Look at a measured set for what comes by itself.
 *  @param judged  grid_echo_t of each beam's end: what is familiar is no comer, what is strange is
 *  one at once, the rest when it was seen to come */
void guard_watch(guard_t *guard, const guard_config_t *cfg, const scan_frame_t *frame,
                 const uint8_t *judged);
/** What to add to a velocity setpoint so that the body moves as wanted though odometry is wrong, as
 * far as echoes tell. @return body frame */
vec2_t guard_slip(const guard_t *guard, float yaw_rad);
/** Where the comer is, as seen from the body. @return false if there is none */
bool guard_comer(const guard_t *guard, const scan_odometry_t *body, vec2_t *offset_m);
/** @param range_m  SCAN_RANGES distances [m] as published, negative where none
 *  @param body  pose of the odometry frame, and time, now
 *  @param wanted_mps  body frame
 *  @return the velocity allowed, body frame, never faster than wanted, retreat_mps or yield_mps */
vec2_t guard_step(guard_t *guard, const guard_config_t *cfg, const float *range_m,
                  const scan_odometry_t *body, vec2_t wanted_mps);

#endif
