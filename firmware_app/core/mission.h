// SPDX-License-Identifier: GPL-3.0-or-later
/** @file mission.h  What the drone is about: a table of states and events, and why something was
 * refused. Pure: it sees events, never ranges or maps. nav.h turns the world into events and states
 * into motion. */
#ifndef MISSION_H
#define MISSION_H

#include <stdbool.h>
#include <stdint.h>

/** As written to parameter way.cmd and sent in a COMMAND packet. */
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

/** As logged in way.state. */
typedef enum {
  MISSION_IDLE,    ///< on the ground, motors off; with a task: checking that there is a way before
                   ///< taking off
  MISSION_TAKEOFF, ///< climbing to the flight height
  MISSION_SCAN,    ///< turning a quarter: the four beams see all around
  MISSION_PLAN,    ///< hovering while a route is computed
  MISSION_FOLLOW,  ///< flying the route to the goal or the next frontier
  MISSION_AVOID,   ///< something is too near: backing away
  MISSION_HOVER,   ///< holding a post: arrived, or told to hold
  MISSION_RETURN,  ///< flying the route home, to land there
  MISSION_LAND,    ///< descending
  MISSION_FAULT,   ///< ended by a fault, motors off; a new command starts afresh
  MISSION_RELOCALISE, ///< turning and moving a little until it knows where it is in its map
  MISSION_SPIN,       ///< turning in place, as often as it was told
  MISSION_STATES,
} mission_state_t;

/** What the flight is for; decides where PLAN aims and what follows arrival. */
typedef enum {
  MISSION_TASK_NONE,
  MISSION_TASK_GOTO,
  MISSION_TASK_EXPLORE,
  MISSION_TASK_HOME,
  MISSION_TASK_SPIN,
  MISSION_TASK_FLY,    ///< to each way point in turn
  MISSION_TASK_PATROL, ///< the same, again and again
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
  MISSION_EV_WAY_EXISTS, ///< on the ground: the goal can be reached as far as the map knows
  MISSION_EV_ROUTE,      ///< a route is ready to fly
  MISSION_EV_NO_ROUTE,   ///< proven: no way
  MISSION_EV_LOOK,       ///< the observed part of the route ends here
  MISSION_EV_BLOCKED,    ///< the map no longer allows the route
  MISSION_EV_ARRIVED,    ///< end of the route
  MISSION_EV_NEAR,       ///< the guard backs away
  MISSION_EV_CLEAR,      ///< the guard has room again
  MISSION_EV_LANDED,     ///< touched down
  MISSION_EV_FAILED,     ///< cannot fly any more: tumbled, stopped, locked
  MISSION_EV_RELOCALISE, ///< command
  MISSION_EV_FOUND,      ///< it knows again where it is
  MISSION_EV_NOT_FOUND,  ///< it looked for long enough
  MISSION_EVENTS,
} mission_event_t;

/** Why a command was refused or a flight ended; logged in way.fault, sent in ACK and EVENT. */
typedef enum {
  MISSION_OK,
  MISSION_NO_FLOW_DECK,
  MISSION_NO_RANGER_DECK,
  MISSION_BATTERY_LOW,
  MISSION_BATTERY_EMPTY,
  MISSION_ESTIMATOR,  ///< position estimate has not settled, or jumped in flight
  MISSION_CANNOT_FLY, ///< not armed, locked or crashed: the supervisor says no
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
  MISSION_STUCK,         ///< too many attempts without progress
  MISSION_RANGES_FROZEN, ///< the ranges have stopped changing
  MISSION_TUMBLED,
  MISSION_SELF_TEST,    ///< running: everything else waits
  MISSION_LOST,         ///< it did not find out where it is in its map
  MISSION_NO_MAP,       ///< there is no map to find itself in
  MISSION_NO_WAYPOINTS, ///< none are held, or not all have come
  MISSION_FLOW_LOST,    ///< the flow sensor sees nothing of the floor
  MISSION_BLIND,        ///< one of the range sensors is stuck or dead
  MISSION_BUSY,         ///< not holding its place: no hand may steer it
  MISSION_REASONS,
} mission_reason_t;

typedef struct {
  mission_state_t state;
  mission_task_t task;
  mission_reason_t fault; ///< the last one
  bool lost;              ///< its pose in the map is not known: it relocalises before all else
} mission_t;

void mission_init(mission_t *mission);
/** Apply one event. @return true if the state was entered anew (also when it is the same state
 * again) */
bool mission_step(mission_t *mission, mission_event_t event);
/** Motors may run in this state. */
bool mission_airborne(mission_state_t state);

#endif
