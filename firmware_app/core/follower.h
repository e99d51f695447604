// SPDX-License-Identifier: GPL-3.0-or-later
/** @file follower.h  Flies along a route: velocity and yaw rate from pose and route. Stage after
 * planning. Pure pursuit (Coulter 1992) with a carrot that moves along the route; speed limited by
 * the bend ahead, the room beside the route and the distance to the stop point. A quadrotor needs
 * no heading to move: yaw is free, and three modes use it. */
#ifndef FOLLOWER_H
#define FOLLOWER_H

#include <stdbool.h>
#include <stdint.h>

#include "geometry.h"
#include "route.h"

typedef enum {
  FOLLOWER_YAW_FORWARD, ///< face the way it flies
  FOLLOWER_YAW_KEEP,    ///< keep the heading it had
  FOLLOWER_YAW_TURN,    ///< turn steadily: the four beams sweep everything
  FOLLOWER_YAW_MODES,
} follower_yaw_mode_t;

typedef struct {
  float speed_mps;
  float accel_mps2; ///< speeding up and braking
  float lookahead_m;
  float arrive_m; ///< nearer than this is there
  float position_gain_per_s;
  float yaw_gain_per_s;
  float yaw_rate_max_rps;
  float turn_rate_rps; ///< of FOLLOWER_YAW_TURN
  float
      stray_s; ///< by this times its speed it may be beside the route, for the age of what it sees
  follower_yaw_mode_t yaw_mode;
} follower_config_t;

/** What the map allows just now. */
typedef struct {
  float until_m; ///< arc length up to which the route may be flown
  float room_m;  ///< how far it may be beside the route soon
} follower_limits_t;

typedef struct {
  float progress_m;   ///< arc length of the nearest point passed
  float keep_yaw_rad; ///< heading of FOLLOWER_YAW_KEEP
  float cross_track_m;
} follower_t;

typedef struct {
  vec2_t velocity_mps; ///< map frame
  float yaw_rate_rps;
} follower_command_t;

typedef enum {
  FOLLOWER_MOVING,
  FOLLOWER_AT_LIMIT, ///< stopped where the allowed part of the route ends, and looks along it
  FOLLOWER_ARRIVED,  ///< at the end of the route
} follower_status_t;

follower_config_t follower_config_default(void);
void follower_start(follower_t *follower, float yaw_rad);
/** @param velocity_mps  present velocity, map frame */
follower_status_t follower_step(follower_t *follower, const follower_config_t *cfg,
                                const route_t *route, pose2_t pose, vec2_t velocity_mps,
                                follower_limits_t limits, follower_command_t *command);
/** Stay at a point with a heading. */
follower_command_t follower_hold(const follower_config_t *cfg, pose2_t pose, pose2_t post);

#endif
