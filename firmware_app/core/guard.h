// SPDX-License-Identifier: GPL-3.0-or-later
/** @file guard.h  Collision guard: limits the wanted velocity by the raw ranges, every tick.
 *
 *  Braking needs neither map nor SLAM. It slows with the distance ahead, stops, and backs away from
 *  the weighted centre of what is near (nearer weighs more), never towards a side without room.
 *  It keeps a larger distance from an intruder, an approaching obstacle and usually a person: it
 *  retreats at the speed of the approach, sideways where there is no room behind, and remembers
 *  the intruder for a while when no beam hits it.
 */
#ifndef GUARD_H
#define GUARD_H

#include <stdbool.h>
#include <stdint.h>

#include "geometry.h"
#include "grid.h"
#include "scan.h"

#define GUARD_REMEMBERED_S 1.5f ///< memory of an approaching obstacle that no beam hits
#define GUARD_SLIP_MPS     1.0f ///< largest velocity error that guard_slip() compensates
enum { GUARD_RESTLESS = 20 /* value of guard_t.restless at which a beam counts as broken */ };

typedef enum { GUARD_CLEAR, GUARD_SLOW, GUARD_STOP, GUARD_RETREAT } guard_status_t;

typedef struct {
  float slow_m;      ///< anything nearer than this is reported as GUARD_SLOW
  float stop_m;      ///< braking ends this far from an obstacle: no velocity towards it
  float retreat_m;   ///< back away from anything nearer than this
  float release_m;   ///< backing away ends at this distance
  float yield_m;     ///< distance kept from an approaching obstacle; 0: treat it as a wall
  float retreat_mps; ///< speed of backing away from a static obstacle
  float yield_mps;   ///< maximum speed of backing away from an approaching one
  float reaction_s;  ///< age of the ranges plus the vehicle's response, for the stopping distance
  float brake_mps2;  ///< deceleration, for the stopping distance
} guard_config_t;

typedef struct {
  guard_status_t status;
  float nearest_m; ///< nearest level range, or a large number
  vec2_t away;     ///< unit vector of the retreat, body frame; zero if there is none
  // the previous measured set
  float seen_m[SCAN_BEAMS];     ///< level ranges; 0 where nothing was near
  pose2_t seen_from;            ///< pose of the body, odometry frame
  uint32_t seen_ms;             ///< time of the set
  uint8_t coming[SCAN_BEAMS];   ///< sets in a row in which a beam's echo approached by itself
  uint8_t restless[SCAN_BEAMS]; ///< score of a beam's recent jumps between near echoes
  vec2_t slip_mps;              ///< velocity of odometry minus that by echoes, odometry frame
  vec2_t hint_m;                ///< unconfirmed approaching obstacle, odometry frame
  uint32_t hint_ms;             ///< time of that echo
  uint8_t doubtful;             ///< bit mask of beams whose last fall in range was implausible
  // the approaching obstacle
  bool met;             ///< there has been one
  bool unexplained;     ///< it may be a wall that is not mapped yet: kept off, not retreated from
  int8_t way;           ///< beam along which the drone retreats, or -1
  uint32_t met_ms;      ///< when it was first met, or last moved on
  vec2_t met_m;         ///< its position then, odometry frame
  uint32_t intruder_ms; ///< time of its last echo
  vec2_t intruder_m;    ///< its last position, odometry frame
  float intruder_mps;   ///< its speed towards the drone
} guard_t;

guard_config_t guard_config_default(void);
void guard_init(guard_t *guard);
/** Search a measured set for approaching obstacles. Each needs a second set to confirm it.
 *  @param judged  grid_echo_t of each beam's end. Strange: an approaching obstacle. Familiar: none.
 *  Unexplained: one if it came nearer in three sets in a row; else, if near, perhaps an unmapped
 *  wall */
void guard_watch(guard_t *guard, const guard_config_t *cfg, const scan_frame_t *frame,
                 const uint8_t *judged);
/** Velocity error of the firmware's estimate by the echoes, to be added to a velocity setpoint.
 *  @return body frame */
vec2_t guard_slip(const guard_t *guard, float yaw_rad);
/** Position of the approaching obstacle, body frame. @return false if there is none */
bool guard_intruder(const guard_t *guard, const scan_odometry_t *body, vec2_t *offset_m);
/** Limit a velocity, or replace it by a retreat.
 *  @param range_m  SCAN_RANGES distances as published; negative: no return
 *  @param body  present odometry
 *  @param wanted_mps  body frame
 *  @return allowed velocity, body frame, never faster than wanted, retreat_mps or yield_mps */
vec2_t guard_step(guard_t *guard, const guard_config_t *cfg, const float *range_m,
                  const scan_odometry_t *body, vec2_t wanted_mps);

#endif
