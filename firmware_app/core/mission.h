// SPDX-License-Identifier: GPL-3.0-or-later
/** @file mission.h  Mission state machine: states, tasks, events and the reasons of refusals.
 *
 *  It sees events only, never ranges or maps: nav.h turns what is measured into events, and states
 *  into motion.
 */
#ifndef MISSION_H
#define MISSION_H

#include <stdbool.h>
#include <stdint.h>

/** Commands, as written to parameter way.cmd and sent in a COMMAND packet. */
typedef enum {
  MISSION_CMD_NONE = 0,
  MISSION_CMD_TAKE_OFF = 1,
  MISSION_CMD_GOTO = 2,
  MISSION_CMD_EXPLORE = 3,
  MISSION_CMD_HOME = 4,
  MISSION_CMD_LAND = 5,
  MISSION_CMD_HOLD = 6,
  MISSION_CMD_SCAN = 7,
  MISSION_CMD_FORGET = 8,
  MISSION_CMD_RELOCALISE = 9,
  MISSION_CMD_SPIN = 10,
  MISSION_CMD_FLY = 11,
  MISSION_CMD_PATROL = 12,
  MISSION_CMDS,
} mission_cmd_t;

/** States, as logged in way.state. */
typedef enum {
  MISSION_IDLE,       ///< on the ground, motors off; with a task: checks for a route first
  MISSION_TAKEOFF,    ///< climbing to the flight height
  MISSION_SCAN,       ///< stop-and-look: a quarter turn, so that the four beams see all around
  MISSION_PLAN,       ///< a route is computed: hovers, or flies on where the old one is clear
  MISSION_FOLLOW,     ///< flying the route to the goal or the next frontier
  MISSION_AVOID,      ///< something is too near: backing away
  MISSION_HOVER,      ///< holding its post: arrived, told to hold, or flown by hand
  MISSION_RETURN,     ///< flying the route home, to land there
  MISSION_LAND,       ///< descending
  MISSION_FAULT,      ///< ended by a fault, motors off; a new command starts afresh
  MISSION_RELOCALISE, ///< turning and making short moves to find its pose in the map
  MISSION_SPIN,       ///< turning in place, parameter way.turns
  MISSION_STATES,
} mission_state_t;

/** Purpose of the flight: decides where MISSION_PLAN aims and what follows an arrival. */
typedef enum {
  MISSION_TASK_NONE,
  MISSION_TASK_GOTO,
  MISSION_TASK_EXPLORE,
  MISSION_TASK_HOME,
  MISSION_TASK_SPIN,
  MISSION_TASK_FLY,    ///< to each waypoint in turn
  MISSION_TASK_PATROL, ///< likewise, again and again
  MISSION_TASKS,
} mission_task_t;

typedef enum {
  MISSION_EV_NONE,
  MISSION_EV_TAKE_OFF,   ///< command
  MISSION_EV_TASK,       ///< command: a new task is set (go to, explore, home ...)
  MISSION_EV_LAND,       ///< command, or a policy says land
  MISSION_EV_HOLD,       ///< command, or a policy says hold
  MISSION_EV_SCAN,       ///< command
  MISSION_EV_HEIGHT,     ///< flight height reached
  MISSION_EV_SCANNED,    ///< the turn is complete
  MISSION_EV_WAY_EXISTS, ///< on the ground: the map shows a route, or the drone is lost
  MISSION_EV_ROUTE,      ///< a route is ready to fly
  MISSION_EV_NO_ROUTE,   ///< no route was found, however weak obstacles are
  MISSION_EV_LOOK,       ///< stop and look, as the way ahead is not known well enough
  MISSION_EV_BLOCKED,    ///< the map no longer allows the route
  MISSION_EV_ARRIVED,    ///< end of the route
  MISSION_EV_NEAR,       ///< the guard backs away
  MISSION_EV_CLEAR,      ///< the guard no longer backs away
  MISSION_EV_LANDED,     ///< touched down
  MISSION_EV_FAILED,     ///< cannot fly any more: tumbled, stopped or locked
  MISSION_EV_RELOCALISE, ///< command, or the drone was carried elsewhere in flight
  MISSION_EV_FOUND,      ///< relocalisation is sure
  MISSION_EV_NOT_FOUND,  ///< relocalisation timed out
  MISSION_EVENTS,
} mission_event_t;

/** Why a command was refused or a flight ended; logged in way.refused and way.fault, and sent in
 *  ACK and EVENT packets. */
typedef enum {
  MISSION_OK,
  MISSION_NO_FLOW_DECK,
  MISSION_NO_RANGER_DECK,
  MISSION_BATTERY_LOW,
  MISSION_BATTERY_EMPTY,
  MISSION_ESTIMATOR,  ///< the firmware's estimate has not settled, is unsure, or jumped in flight
  MISSION_CANNOT_FLY, ///< the supervisor says no: not armed, locked or crashed
  MISSION_BAD_VALUE,  ///< not a number, or out of range
  MISSION_OUTSIDE_GRID,
  MISSION_OUTSIDE_AREA,
  MISSION_GOAL_OCCUPIED,    ///< nearer to an obstacle than the clearance
  MISSION_GOAL_UNREACHABLE, ///< walled off, as far as the map knows
  MISSION_NOT_FLYING,
  MISSION_UNKNOWN_COMMAND,
  MISSION_BAD_AREA, ///< empty, or larger than the grid
  MISSION_FLYING,   ///< only possible on the ground
  MISSION_LINK_LOST,
  MISSION_STUCK,         ///< too many attempts without progress, or walled in
  MISSION_RANGES_FROZEN, ///< the ranges have stopped changing
  MISSION_TUMBLED,
  MISSION_SELF_TEST,    ///< the self-test is running
  MISSION_LOST,         ///< carried elsewhere in flight, or relocalisation found no pose
  MISSION_NO_MAP,       ///< there is no map to relocalise in
  MISSION_NO_WAYPOINTS, ///< no list of waypoints, or not all of it has arrived
  MISSION_FLOW_LOST,    ///< the flow sensor finds too few features on the floor
  MISSION_BLIND,        ///< a range sensor is stuck, dead or broken
  MISSION_BUSY,         ///< not hovering, so it cannot be flown by hand
  MISSION_REASONS,
} mission_reason_t;

typedef struct {
  mission_state_t state;
  mission_task_t task;
  mission_reason_t fault; ///< latest; MISSION_OK from a take-off on
  bool lost;              ///< the pose in the map is unknown: relocalise before using the map
} mission_t;

void mission_init(mission_t *mission);
/** Apply one event. @return true if it entered a state, be it the same one again */
bool mission_step(mission_t *mission, mission_event_t event);
/** May the motors run in this state? */
bool mission_airborne(mission_state_t state);

#endif
