// SPDX-License-Identifier: GPL-3.0-or-later
/** @file nav.h  The whole pipeline: one call a tick, sensors and commands in, setpoint and events
 * out.
 *
 *      ranges + odometry -> scan -> slam -> grid -> clearance -> pathfinder -> route -> follower ->
 * guard
 *
 *  nav_t owns one of each; nothing else is remembered anywhere, and two nav_t never touch each
 * other. SI units, radians, map frame unless said otherwise. No call blocks; the work of a tick is
 * bounded. */
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
/** When the ground falls silent. */
typedef enum {
  NAV_LOST_GO_ON,
  NAV_LOST_HOLD,
  NAV_LOST_HOME,
  NAV_LOST_LAND,
  NAV_LOST_POLICIES
} nav_lost_t;

/** Everything a user may tune. Copied at init and by nav_configure; see nav_config_default for the
 * numbers. */
typedef struct {
  scan_config_t scan;
  grid_config_t grid;
  pathfinder_config_t search;
  follower_config_t follower;
  guard_config_t guard;
  slam_config_t slam_filter;
  float height_m;
  float clearance_m; ///< from obstacles, drone radius included
  float cell_m;      ///< taken when the map is made
  vec2_t area_min_m; ///< the fence; the grid is centred on it when the map is made
  vec2_t area_max_m;
  float low_battery_v;
  float lost_time_s;
  float climb_mps;
  float descend_mps;
  float scan_turn_rad; ///< a quarter turn and a little
  float scan_rate_rps;
  float watch_rad;         ///< it looks so far to both sides in flight and while hovering; 0: not
  float look_half_width_m; ///< a corridor is flown only if this much on both sides was observed,
  float look_age_s;        ///< and it was looked at within this time
  float turns;             ///< of a spin; counter-clockwise if positive
  uint32_t seed;
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
  NAV_FLOW_LOST = 128, ///< the flow sensor sees nothing of the floor
} nav_flag_t;

/** What measures the position itself, so that the estimate does not drift. */
typedef enum {
  NAV_POSITIONING_NONE,
  NAV_POSITIONING_LIGHTHOUSE,
  NAV_POSITIONING_LOCO,
  NAV_POSITIONING_EXTERNAL, ///< from the ground, as motion capture does
} nav_positioning_t;

/** What the pose in the map comes from; the first three are nav_slam_mode_t. */
typedef enum {
  NAV_SOURCE_ODOMETRY,
  NAV_SOURCE_SLAM,
  NAV_SOURCE_SLAM_ESTIMATOR,
  NAV_SOURCE_LIGHTHOUSE, ///< from here on nav_positioning_t
  NAV_SOURCE_LOCO,
  NAV_SOURCE_EXTERNAL,
} nav_source_t;

typedef struct {
  scan_odometry_t odometry;   ///< given: the firmware's estimate; kept: odometry, see nav_frames.c
  vec2_t velocity_mps;        ///< same frame
  float yaw_rate_rps;         ///< gyro
  float range_m[SCAN_RANGES]; ///< negative: none
  float battery_v;
  uint8_t flags;       ///< nav_flag_t
  uint8_t positioning; ///< nav_positioning_t: who measures just now
} nav_input_t;

/** What the firmware's estimator may be told: the map is its frame from now on. */
typedef struct {
  pose2_t estimate; ///< as it believes now
  vec2_t off_m;     ///< from there to where the drone is in the map
  float off_rad;
  float sd_m; ///< of an axis
  float sd_rad;
} nav_fix_t;

typedef struct {
  mission_cmd_t cmd;
  vec2_t goal_m; ///< map frame, for MISSION_CMD_GOTO
} nav_command_t;

/** What the vehicle shall do now. */
typedef struct {
  bool motors; ///< false: no setpoint is needed
  float height_m;
  vec2_t velocity_body_mps; ///< level, x forward, y left
  float yaw_rate_rps;
} nav_setpoint_t;

/** For logs and the ground. */
typedef struct {
  pose2_t pose; ///< map frame
  vec2_t goal_m;
  float path_m; ///< length of the present route
  uint16_t known_cells;
  uint16_t plan_nodes;
  uint8_t confidence; ///< [%]
  uint8_t state;      ///< mission_state_t
  uint8_t fault;      ///< mission_reason_t
  uint8_t task;       ///< mission_task_t
} nav_status_t;

typedef enum {
  NAV_PLAN_DONE,
  NAV_PLAN_BEGIN,  ///< asked for, not begun
  NAV_PLAN_SEARCH, ///< the planner is at work
} nav_plan_stage_t;

typedef struct {
  nav_plan_stage_t stage;
  vec2_t start_cells;
  vec2_t goal_cells;
  uint16_t known_cells; ///< when it last looked around
  bool approach;        ///< the goal is occupied: going beside it, to look from nearer
  bool wandering;       ///< exploring by random points: on its way to one
  bool narrow;          ///< keeping less from obstacles: there was no way otherwise
  bool looked;          ///< it has looked around since the last plan
  uint8_t doubts;       ///< in this task, that occupied cells are noise
  uint8_t looks_left;   ///< turns to look around that are left before "no way" is final
  uint8_t stalls;       ///< stops without progress, one after the other
  uint32_t stalled_ms;  ///< when it stopped last
  uint8_t rounds_left;  ///< doubts that are left before "explored" is final
  uint8_t given_up;     ///< frontiers where looking showed nothing
  frontier_vain_t vain;
} nav_plan_t;

/** What the ground has sent to be flown along. */
typedef struct {
  int16_t points_mm[NAV_WAYPOINTS][2];
  uint16_t got; ///< a bit for each that has come
  uint8_t list; ///< number of the list
  uint8_t total;
  uint8_t next;    ///< the one that is flown to
  uint8_t skipped; ///< since the last that was reached
} nav_waypoints_t;

/** What is known of the battery in this flight, and of the way home. */
typedef struct {
  float fast_v, slow_v; ///< voltage, smoothed
  float flown_m;
  uint32_t grounded_ms; ///< when it last stood
} nav_endurance_t;

/** Finding itself again: a full turn, then short moves with a turn behind each. */
typedef struct {
  bool moving;       ///< else turning
  bool left;         ///< the way it turns
  bool came;         ///< there was a move already
  bool home_too;     ///< home was set while lost: it moves with the pose
  float came_rad;    ///< direction of the last move, map frame
  float to_turn_rad; ///< left of the turn
  uint32_t move_since_ms;
  uint32_t down_ms; ///< when it was last seen not lifted
} nav_looking_t;

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
  }; ///< by the state: nobody plans while it relocalises
  nav_looking_t looking;
  seen_t seen;
  route_t route;
  follower_t follower;
  guard_t guard;
  mapstream_t stream;
  nav_plan_t plan;
  nav_waypoints_t waypoints;
  nav_endurance_t endurance;
  nav_status_t status;
  nav_input_t input; ///< of the present tick
  pose2_t pose;      ///< map frame, now
  pose2_t home;
  pose2_t post;           ///< held while hovering
  pose2_t from_estimate;  ///< odometry from the firmware's estimate: what it was pulled is left out
  pose2_t absolute;       ///< map from the estimate while something measured the position
  uint32_t unmeasured_ms; ///< when nothing did
  uint8_t told_ticks;     ///< still to come in which the estimator takes what it was told
  bool matched;           ///< slam was corrected since nav_take_fix
  bool aside;             ///< slam stands aside: something else measures the position
  bool has_absolute;
  vec2_t goal_m;
  wire_event_t events[NAV_EVENTS];
  uint16_t event_sequence;
  uint8_t event_first, event_count;
  uint8_t epoch;            ///< of the map
  bool mapped;              ///< the map frame is fixed: since the first take-off
  float tick_s;             ///< since the tick before
  float height_sp_m;        ///< ramped
  wire_steer_t stick;       ///< the last one
  uint32_t steered_ms;      ///< when it came
  bool by_hand;             ///< its place and height were last given by a hand
  float hand_s;             ///< how long something has been right above
  float to_spin_rad;        ///< left of the spin
  float turned_rad;         ///< in this scan
  follower_limits_t limits; ///< of the present route: clear, observed, looked at lately
  uint8_t glances;          ///< sets since the follower has been waiting where that ends
  bool rolling;             ///< planning anew while still flying the old route's clear part
  float best_progress_m;    ///< along the route since it was made
  uint32_t state_since_ms;
  uint32_t near_ms; ///< when it last gave way
  uint32_t link_seen_ms;
  uint32_t battery_good_ms;   ///< when the battery was last above the limit
  uint32_t estimate_good_ms;  ///< when odometry and flow were last usable
  uint8_t astray;             ///< how much of late was not where the map has it
  uint8_t silent[SCAN_BEAMS]; ///< sets in a row without an answer, while flying or looking around
  bool link_lost;             ///< the policy has acted
  bool battery_low;           ///< likewise
} nav_t;

/** The only place where these numbers are. */
void nav_config_default(nav_config_t *cfg);
/** @return MISSION_OK, or what is wrong with the values */
mission_reason_t nav_config_check(const nav_config_t *cfg);

/** cfg must have passed nav_config_check; it may be nav's own. */
void nav_init(nav_t *nav, const nav_config_t *cfg);
/** Take new values between two ticks; area and cell size wait until the map is made anew. Refused
 * values change nothing. cfg may be nav's own, changed in place: if refused, the caller puts back
 * what it was. */
mission_reason_t nav_configure(nav_t *nav, const nav_config_t *cfg);

/** Take or refuse a command, by what is known now. A goal that turns out unreachable is refused
 * later by an event. */
mission_reason_t nav_command(nav_t *nav, const nav_command_t *command);

/** Take some of the way points of commands FLY and PATROL. @return MISSION_OK, or why none of them
 * was taken */
mission_reason_t nav_take_waypoints(nav_t *nav, const wire_waypoints_t *given);

/** Fly by hand: what the stick wants from now on, while it holds its place. Guard and fence have
 * the last word. Without another one it comes to rest half a second later, and holds where that is.
 * @return MISSION_OK, or why the stick was not taken */
mission_reason_t nav_steer(nav_t *nav, const wire_steer_t *stick);

/** One tick. Input that is not finite is replaced by what was known before. */
nav_setpoint_t nav_step(nav_t *nav, const nav_input_t *input);

/** After a match, when cfg.slam is NAV_SLAM_ESTIMATOR: what to tell the estimator, within this
 * tick.
 * @return false if there is nothing to tell */
bool nav_take_fix(nav_t *nav, nav_fix_t *fix);
/** What the pose comes from just now. */
nav_source_t nav_source(const nav_t *nav);
/** Oldest event not taken yet; false if there is none. When more than NAV_EVENTS wait the oldest
 * are lost, and a gap in the sequence numbers says so. */
bool nav_take_event(nav_t *nav, wire_event_t *event);
/** One of the last NAV_EVENTS again, waiting or taken; false if it is forgotten, or yet to come. */
bool nav_past_event(const nav_t *nav, uint16_t sequence, wire_event_t *event);
/** What the ground must know before it can read the map. */
wire_hello_t nav_hello(const nav_t *nav);
/** The next WIRE_MAP_BYTES of the map stream. */
void nav_next_map_piece(nav_t *nav, uint8_t *bytes);
/** Take a piece of a map that the ground has kept, while not flying, of this epoch, WIRE_MAP_BYTES
 * long. The drone then knows a map, but not where in it it is. @return false if it is refused */
bool nav_take_map_piece(nav_t *nav, const uint8_t *bytes);
/** Let every tile count as changed. */
void nav_resend_map(nav_t *nav);
/** Let these. */
void nav_resend_tiles(nav_t *nav, const wire_tiles_t *tiles);

#endif
