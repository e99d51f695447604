// SPDX-License-Identifier: GPL-3.0-or-later
/** @file follower.h  Flies along a route: velocity and yaw rate from pose and route.
 *
 *  Pure pursuit (Coulter 1992) of a carrot that moves along the route at the lookahead distance.
 *  Speed is limited by the bend ahead, the room beside the route and the distance to the stop
 *  point. A quadrotor flies in any direction with any heading, so the yaw is free for three modes.
 */
#ifndef FOLLOWER_H
#define FOLLOWER_H

#include <stdbool.h>
#include <stdint.h>

#include "geometry.h"
#include "route.h"

typedef enum {
  FOLLOWER_YAW_FORWARD, ///< face the direction of flight
  FOLLOWER_YAW_KEEP,    ///< keep the heading that the drone had at the start of the route
  FOLLOWER_YAW_TURN,    ///< turn steadily, so that the four beams sweep all directions
  FOLLOWER_YAW_MODES,
} follower_yaw_mode_t;

typedef struct {
  float speed_mps;
  float accel_mps2;          ///< for speeding up, braking and bends
  float lookahead_m;         ///< of the carrot, along the route
  float arrive_m;            ///< distance from the stop point that counts as arrived
  float position_gain_per_s; ///< velocity per metre of error, while holding a pose
  float yaw_gain_per_s;      ///< yaw rate per radian of error
  float yaw_rate_max_rps;
  float turn_rate_rps; ///< of FOLLOWER_YAW_TURN
  float stray_s;       ///< expected cross-track error per speed: the age of the ranges
  follower_yaw_mode_t yaw_mode;
} follower_config_t;

/** Limits by the present map. */
typedef struct {
  float until_m; ///< arc length up to which the route may be flown
  float room_m;  ///< cross-track error that the room just ahead allows
} follower_limits_t;

typedef struct {
  float progress_m;    ///< arc length of the point of the route nearest to the drone
  float keep_yaw_rad;  ///< heading of FOLLOWER_YAW_KEEP
  float cross_track_m; ///< distance from the route
} follower_t;

typedef struct {
  vec2_t velocity_mps; ///< map frame
  float yaw_rate_rps;
} follower_command_t;

typedef enum {
  FOLLOWER_MOVING,
  FOLLOWER_AT_LIMIT, ///< at limits.until_m; in face-forward mode also facing along the route
  FOLLOWER_ARRIVED,  ///< at the end of the route
} follower_status_t;

follower_config_t follower_config_default(void);
/** Start a new route. */
void follower_start(follower_t *follower, float yaw_rad);
/** One tick along the route. @param velocity_mps  present velocity, map frame */
follower_status_t follower_step(follower_t *follower, const follower_config_t *cfg,
                                const route_t *route, pose2_t pose, vec2_t velocity_mps,
                                follower_limits_t limits, follower_command_t *command);
/** Velocity and yaw rate that hold a pose. */
follower_command_t follower_hold(const follower_config_t *cfg, pose2_t pose, pose2_t post);

#endif
