// SPDX-License-Identifier: GPL-3.0-or-later
/** @file nav.h  The whole pipeline behind one call per tick: sensors in, setpoint and events out.
 *
 *      ranges + odometry -> scan -> slam -> grid -> clearance -> pathfinder
 *                                                        -> route -> follower -> guard -> setpoint
 *
 *  The mission's state selects which of these stages run.
 *
 *  nav_t owns one instance of each stage and is the only state: two nav_t are independent. No call
 *  blocks, and the work done in one tick is bounded: long work runs in slices. SI units, radians
 *  and the map frame unless stated otherwise. Yaw is counter-clockwise.
 */
#ifndef NAV_H
#define NAV_H

#include <stdbool.h>
#include <stdint.h>

#include "clearance.h"
#include "follower.h"
#include "frontier.h"
#include "geometry.h"
#include "grid.h"
#include "guard.h"
#include "mapstream.h"
#include "mission.h"
#include "pathfinder.h"
#include "reloc.h"
#include "route.h"
#include "scan.h"
#include "seen.h"
#include "slam.h"
#include "wire.h"

enum { NAV_EVENTS = 8, NAV_WAYPOINTS = 12 };

typedef enum { NAV_PLANNER_RRTSTAR, NAV_PLANNER_GRID, NAV_PLANNERS } nav_planner_t;
typedef enum { NAV_SLAM_OFF, NAV_SLAM_MAP, NAV_SLAM_ESTIMATOR, NAV_SLAM_MODES } nav_slam_mode_t;
/** What to do when the ground station has been silent for lost_time_s. */
typedef enum {
  NAV_LOST_GO_ON,
  NAV_LOST_HOLD,
  NAV_LOST_HOME,
  NAV_LOST_LAND,
  NAV_LOST_POLICIES
} nav_lost_t;

/** Everything a user may tune. Defaults: nav_config_default(); limits: nav_config_check(). */
typedef struct {
  scan_config_t scan;
  grid_config_t grid;
  pathfinder_config_t search;
  follower_config_t follower;
  guard_config_t guard;
  slam_config_t slam_filter;
  float height_m;
  float clearance_m;       ///< planned distance of the drone's centre from obstacles
  float cell_m;            ///< side of a grid cell; takes effect when the next map is made
  vec2_t area_min_m;       ///< geofence; the grid is centred on it when the map is made
  vec2_t area_max_m;       ///< its opposite corner
  float low_battery_v;     ///< voltage to have left on arrival at home
  float lost_time_s;       ///< silence of the ground station before cfg.lost applies
  float climb_mps;         ///< vertical speed, upwards
  float descend_mps;       ///< vertical speed while landing
  float scan_turn_rad;     ///< stop-and-look turn: a quarter turn and a little
  float scan_rate_rps;     ///< yaw rate of stop-and-look and of a spin
  float watch_rad;         ///< half angle of the yaw sweep in flight and while hovering; 0: none
  float look_half_width_m; ///< half width that must be observed along a route to fly it
  float look_age_s;        ///< a beam must have looked along it within this time
  float turns;             ///< turns of a spin; counter-clockwise if positive
  uint32_t seed;           ///< of the planner's random samples
  nav_planner_t planner;
  nav_slam_mode_t slam;
  nav_lost_t lost;
  frontier_mode_t frontier;
} nav_config_t;

typedef enum {
  NAV_HAS_FLOW = 1,
  NAV_HAS_RANGER = 2,
  NAV_ESTIMATOR_SETTLED = 4,
  NAV_CAN_FLY = 8, ///< armed, not locked, not crashed
  NAV_IS_FLYING = 16,
  NAV_TUMBLED = 32,
  NAV_LINK_ALIVE = 64,
  NAV_FLOW_LOST = 128, ///< the flow sensor finds too few features on the floor
} nav_flag_t;

/** Positioning system that measures absolute position, so that the estimate does not drift. */
typedef enum {
  NAV_POSITIONING_NONE,
  NAV_POSITIONING_LIGHTHOUSE,
  NAV_POSITIONING_LOCO,
  NAV_POSITIONING_EXTERNAL, ///< positions sent from the ground, e.g. by motion capture
} nav_positioning_t;

/** Where the map pose comes from. The first three equal nav_slam_mode_t. */
typedef enum {
  NAV_SOURCE_ODOMETRY,
  NAV_SOURCE_SLAM,
  NAV_SOURCE_SLAM_ESTIMATOR,
  NAV_SOURCE_LIGHTHOUSE, ///< from here on in the order of nav_positioning_t
  NAV_SOURCE_LOCO,
  NAV_SOURCE_EXTERNAL,
} nav_source_t;

typedef struct {
  scan_odometry_t odometry;   ///< the firmware's estimate; nav.input holds odometry (nav_frames.c)
  vec2_t velocity_mps;        ///< in the frame of that pose
  float yaw_rate_rps;         ///< from the gyro
  float range_m[SCAN_RANGES]; ///< negative: no return
  float battery_v;
  uint8_t flags;       ///< of nav_flag_t
  uint8_t positioning; ///< nav_positioning_t that measures at present
} nav_input_t;

/** Correction that makes the firmware's estimate equal the map pose. */
typedef struct {
  pose2_t estimate; ///< the firmware's present estimate
  vec2_t off_m;     ///< map position minus estimated position
  float off_rad;    ///< map yaw minus estimated yaw
  float sd_m;       ///< standard deviation along each axis
  float sd_rad;     ///< standard deviation of the yaw
} nav_fix_t;

typedef struct {
  mission_cmd_t cmd;
  vec2_t goal_m; ///< for MISSION_CMD_GOTO
} nav_command_t;

/** Setpoint of this tick. */
typedef struct {
  bool motors; ///< false: on the ground, send no setpoint
  float height_m;
  vec2_t velocity_body_mps; ///< level, x forward, y left
  float yaw_rate_rps;
} nav_setpoint_t;

/** Status for the log variables and the ground station. */
typedef struct {
  pose2_t pose;
  vec2_t goal_m;
  float path_m;         ///< length of the present route
  uint16_t known_cells; ///< cells observed at least once
  uint16_t plan_nodes;
  uint8_t confidence; ///< [%]
  uint8_t state;      ///< mission_state_t
  uint8_t fault;      ///< mission_reason_t
  uint8_t task;       ///< mission_task_t
} nav_status_t;

typedef enum {
  NAV_PLAN_DONE,
  NAV_PLAN_BEGIN,  ///< requested, not started
  NAV_PLAN_SEARCH, ///< the pathfinder is at work
} nav_plan_stage_t;

typedef struct {
  nav_plan_stage_t stage;
  vec2_t start_cells;
  vec2_t goal_cells;
  uint16_t known_cells; ///< exploring: known cells at the last stop-and-look
  bool approach;        ///< the goal is occupied: flying beside it, to observe it from nearby
  bool wandering;       ///< exploring by random points: on the way to one
  bool narrow;          ///< planning with reduced clearance, as there was no way at the full one
  bool looked;          ///< a stop-and-look was made since the last plan
  uint8_t doubts;       ///< times in this task that weakly occupied cells were made unknown again
  uint8_t looks_left;   ///< stop-and-looks left before "no way" is final
  uint8_t stalls;       ///< weighted count of stops in a row without progress
  uint32_t stalled_ms;  ///< time of the last such stop
  uint8_t rounds_left;  ///< exploring: doubts left before "explored" is final
  uint8_t given_up;     ///< frontiers where looking showed nothing new
  frontier_vain_t vain; ///< the latest of these
} nav_plan_t;

/** Waypoint list sent by the ground station. */
typedef struct {
  int16_t points_mm[NAV_WAYPOINTS][2];
  uint16_t got;    ///< bit i is set when waypoint i has arrived
  uint8_t list;    ///< number of the list
  uint8_t total;   ///< waypoints in the list
  uint8_t next;    ///< the waypoint flown to
  uint8_t skipped; ///< waypoints skipped in a row
} nav_waypoints_t;

/** Battery discharge in this flight, and what bounds the way home. */
typedef struct {
  float fast_v, slow_v; ///< battery voltage behind a fast and a slow low-pass filter
  float flown_m;        ///< distance flown since take-off
  uint32_t grounded_ms; ///< last time on the ground
} nav_endurance_t;

/** Motion while relocalising: a full turn, then short moves, each followed by a turn. */
typedef struct {
  bool moving;            ///< else turning
  bool left;              ///< sense of the turn
  bool came;              ///< a move was made already
  bool home_too;          ///< take-off was while lost: home is corrected together with the pose
  float came_rad;         ///< direction of the last move, map frame
  float to_turn_rad;      ///< rest of the turn
  uint32_t move_since_ms; ///< start of the move
  uint32_t down_ms;       ///< last time the drone was not held up with its motors off
} nav_reloc_motion_t;

typedef struct {
  nav_config_t cfg;
  mission_t mission;
  scan_t scan;
  slam_t slam;
  grid_t grid;
  clearance_t clearance;
  union {
    pathfinder_t planner;
    reloc_t reloc;
  }; ///< reloc in MISSION_RELOCALISE, planner in all other states
  nav_reloc_motion_t reloc_motion;
  seen_t seen;
  route_t route;
  follower_t follower;
  guard_t guard;
  mapstream_t stream;
  nav_plan_t plan;
  nav_waypoints_t waypoints;
  nav_endurance_t endurance;
  nav_status_t status;
  nav_input_t input;               ///< of the present tick
  pose2_t pose;                    ///< present pose, map frame
  pose2_t home;                    ///< pose at take-off
  pose2_t post;                    ///< pose to hold when no route is flown
  pose2_t from_estimate;           ///< odometry_T_estimate: takes corrections of the estimate out
  pose2_t absolute;                ///< map_T_estimate when a positioning system last measured
  uint32_t unmeasured_ms;          ///< last time none did
  uint8_t told_ticks;              ///< ticks left in which the estimator may apply a fix
  bool matched;                    ///< SLAM corrected the pose since nav_take_fix()
  bool aside;                      ///< SLAM is off because a positioning system measures
  bool has_absolute;               ///< absolute is valid
  vec2_t goal_m;                   ///< present goal, map frame
  wire_event_t events[NAV_EVENTS]; ///< ring
  uint16_t event_sequence;         ///< number of the next event
  uint8_t event_first, event_count;
  uint8_t epoch;              ///< of the map; changes when a new map is made
  bool mapped;                ///< the map frame is fixed: there was a take-off, or a map was loaded
  float tick_s;               ///< duration of this tick, 1 to 100 ms
  float height_sp_m;          ///< height setpoint, ramped
  wire_steer_t stick;         ///< latest stick packet
  uint32_t steered_ms;        ///< its arrival
  bool by_hand;               ///< post and height were last set by the stick
  float hand_s;               ///< how long something has been close above
  float to_spin_rad;          ///< rest of the spin, signed
  float turned_rad;           ///< angle turned in this stop-and-look
  follower_limits_t limits;   ///< how far and with how much room the route may be flown
  uint8_t glances;            ///< sets measured while the follower waits at limits.until_m
  bool rolling;               ///< replanning while flying the clear part of the old route
  float best_progress_m;      ///< along the present route
  uint32_t state_since_ms;    ///< when the state was entered or progress last made
  uint32_t near_ms;           ///< when the guard last retreated
  uint32_t link_seen_ms;      ///< when the link was last alive
  uint32_t battery_good_ms;   ///< when the voltage was last enough to fly home
  uint32_t estimate_good_ms;  ///< when estimator and flow were last usable
  uint8_t astray;             ///< excess of strange over familiar echoes; lost at a threshold
  uint8_t silent[SCAN_BEAMS]; ///< sets in a row without return, while following or looking around
  bool link_lost;             ///< cfg.lost was applied
  bool battery_low;           ///< the drone was sent home for its battery
} nav_t;

/** Defaults of nav and of all its stages. */
void nav_config_default(nav_config_t *cfg);
/** @return MISSION_OK, or MISSION_BAD_VALUE if a value is out of its range */
mission_reason_t nav_config_check(const nav_config_t *cfg);

/** Start afresh, without a map. cfg must have passed nav_config_check(); it may be &nav->cfg. */
void nav_init(nav_t *nav, const nav_config_t *cfg);
/** Change the configuration between two ticks. Cell size and centre of the grid wait for the next
 *  map if there is one already; the geofence applies at once. cfg may be &nav->cfg, changed in
 *  place: the caller then restores it if it is refused.
 *  @return MISSION_OK, or MISSION_BAD_VALUE and nothing was changed */
mission_reason_t nav_configure(nav_t *nav, const nav_config_t *cfg);

/** Accept or refuse a command by what is known now. If its goal proves unreachable later, an event
 *  says so. */
mission_reason_t nav_command(nav_t *nav, const nav_command_t *command);

/** Store a packet of the waypoints for MISSION_CMD_FLY and _PATROL.
 *  @return MISSION_OK, or why none of it was stored */
mission_reason_t nav_take_waypoints(nav_t *nav, const wire_waypoints_t *given);

/** Fly by hand: velocities wanted from now on, accepted while the drone hovers. Guard and geofence
 *  limit them. Half a second after the last packet they become zero, and half a second later the
 *  drone holds the place that it has reached. @return MISSION_OK, or why the packet was refused */
mission_reason_t nav_steer(nav_t *nav, const wire_steer_t *stick);

/** Run one tick. Input that is not finite is replaced by the last good value, or zero for rates. */
nav_setpoint_t nav_step(nav_t *nav, const nav_input_t *input);

/** Correction for the firmware's estimator, due after a match if cfg.slam is NAV_SLAM_ESTIMATOR.
 *  Valid within the tick. @return false if none is due */
bool nav_take_fix(nav_t *nav, nav_fix_t *fix);
/** Present source of the map pose. */
nav_source_t nav_source(const nav_t *nav);
/** Take the oldest waiting event. If more than NAV_EVENTS wait, the oldest are lost, which leaves a
 *  gap in the sequence numbers. @return false if none waits */
bool nav_take_event(nav_t *nav, wire_event_t *event);
/** Read one of the last NAV_EVENTS events, taken or not.
 *  @return false if the event is older, or has not happened yet */
bool nav_past_event(const nav_t *nav, uint16_t sequence, wire_event_t *event);
/** Geometry and epoch of the map, without which the ground station cannot decode its pieces. */
wire_hello_t nav_hello(const nav_t *nav);
/** Write the next piece of the map stream, WIRE_MAP_BYTES long. */
void nav_next_map_piece(nav_t *nav, uint8_t *bytes);
/** Load a piece of a stored map, WIRE_MAP_BYTES long and of the present epoch, on the ground only.
 *  Afterwards the drone has a map, but its pose in it is unknown.
 *  @return false if the piece was refused */
bool nav_take_map_piece(nav_t *nav, const uint8_t *bytes);
/** Mark all tiles of the map as changed, so that they are sent again. */
void nav_resend_map(nav_t *nav);
/** Mark these tiles as changed. */
void nav_resend_tiles(nav_t *nav, const wire_tiles_t *tiles);

#endif
