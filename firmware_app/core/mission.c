// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
#include "mission.h"

/** Entries of the table: a state to enter, or a rule that selects it. Default, 0: STAY. */
enum {
  STAY,
  TO_IDLE,
  TO_TAKEOFF,
  TO_SCAN,
  TO_PLAN,
  TO_FOLLOW,
  TO_AVOID,
  TO_HOVER,
  TO_RETURN,
  TO_LAND,
  TO_FAULT,
  TO_RELOCALISE,
  TO_SPIN,
  BY_TASK,    ///< SPIN if that is the task, PLAN for any other task, HOVER without one
  LOOK_AGAIN, ///< SCAN if there is a task, else HOVER
  GO,         ///< RETURN if the task is to go home, else FOLLOW
  AFTER,      ///< at the end of a route: SCAN if exploring, LAND if going home, else HOVER
  END = 0x80, ///< flag: the task is over
};

static const uint8_t NEXT[MISSION_STATES][MISSION_EVENTS] = {
    [MISSION_IDLE] =
        {
            [MISSION_EV_TAKE_OFF] = TO_TAKEOFF,
            [MISSION_EV_TASK] = TO_IDLE,
            [MISSION_EV_WAY_EXISTS] = TO_TAKEOFF,
            [MISSION_EV_RELOCALISE] = TO_TAKEOFF,
            [MISSION_EV_NO_ROUTE] = END | TO_IDLE,
            [MISSION_EV_LAND] = END | TO_IDLE,
            [MISSION_EV_HOLD] = END | TO_IDLE,
            [MISSION_EV_FAILED] = END | TO_FAULT,
        },
    [MISSION_TAKEOFF] =
        {
            [MISSION_EV_HEIGHT] = TO_SCAN,
            [MISSION_EV_LAND] = END | TO_LAND,
            [MISSION_EV_HOLD] = END | TO_HOVER,
            [MISSION_EV_FAILED] = END | TO_FAULT,
        },
    [MISSION_SCAN] =
        {
            [MISSION_EV_SCANNED] = BY_TASK,
            [MISSION_EV_SCAN] = TO_SCAN,
            [MISSION_EV_LAND] = END | TO_LAND,
            [MISSION_EV_HOLD] = END | TO_HOVER,
            [MISSION_EV_NEAR] = TO_AVOID,
            [MISSION_EV_RELOCALISE] = TO_RELOCALISE,
            [MISSION_EV_FAILED] = END | TO_FAULT,
        },
    [MISSION_PLAN] =
        {
            [MISSION_EV_ROUTE] = GO,
            [MISSION_EV_NO_ROUTE] = END | TO_HOVER,
            [MISSION_EV_LOOK] = TO_SCAN,
            [MISSION_EV_TASK] = BY_TASK,
            [MISSION_EV_SCAN] = TO_SCAN,
            [MISSION_EV_LAND] = END | TO_LAND,
            [MISSION_EV_HOLD] = END | TO_HOVER,
            [MISSION_EV_NEAR] = TO_AVOID,
            [MISSION_EV_RELOCALISE] = TO_RELOCALISE,
            [MISSION_EV_FAILED] = END | TO_FAULT,
        },
    [MISSION_FOLLOW] =
        {
            [MISSION_EV_ARRIVED] = AFTER,
            [MISSION_EV_LOOK] = TO_SCAN,
            [MISSION_EV_BLOCKED] = TO_PLAN,
            [MISSION_EV_TASK] = BY_TASK,
            [MISSION_EV_SCAN] = TO_SCAN,
            [MISSION_EV_LAND] = END | TO_LAND,
            [MISSION_EV_HOLD] = END | TO_HOVER,
            [MISSION_EV_NEAR] = TO_AVOID,
            [MISSION_EV_RELOCALISE] = TO_RELOCALISE,
            [MISSION_EV_FAILED] = END | TO_FAULT,
        },
    [MISSION_AVOID] =
        {
            [MISSION_EV_CLEAR] = LOOK_AGAIN,
            [MISSION_EV_LAND] = END | TO_LAND,
            [MISSION_EV_HOLD] = END | STAY,
            [MISSION_EV_RELOCALISE] = TO_RELOCALISE,
            [MISSION_EV_FAILED] = END | TO_FAULT,
        },
    [MISSION_HOVER] =
        {
            [MISSION_EV_TASK] = BY_TASK,
            [MISSION_EV_SCAN] = TO_SCAN,
            [MISSION_EV_HOLD] = END | TO_HOVER,
            [MISSION_EV_LAND] = END | TO_LAND,
            [MISSION_EV_NEAR] = TO_AVOID,
            [MISSION_EV_RELOCALISE] = TO_RELOCALISE,
            [MISSION_EV_FAILED] = END | TO_FAULT,
        },
    [MISSION_RETURN] =
        {
            [MISSION_EV_ARRIVED] = AFTER,
            [MISSION_EV_LOOK] = TO_SCAN,
            [MISSION_EV_BLOCKED] = TO_PLAN,
            [MISSION_EV_TASK] = BY_TASK,
            [MISSION_EV_SCAN] = TO_SCAN,
            [MISSION_EV_LAND] = END | TO_LAND,
            [MISSION_EV_HOLD] = END | TO_HOVER,
            [MISSION_EV_NEAR] = TO_AVOID,
            [MISSION_EV_RELOCALISE] = TO_RELOCALISE,
            [MISSION_EV_FAILED] = END | TO_FAULT,
        },
    [MISSION_LAND] =
        {
            [MISSION_EV_LANDED] = END | TO_IDLE,
            [MISSION_EV_TAKE_OFF] = TO_TAKEOFF,
            [MISSION_EV_TASK] = TO_TAKEOFF,
            [MISSION_EV_HOLD] = END | TO_HOVER,
            [MISSION_EV_RELOCALISE] = TO_TAKEOFF,
            [MISSION_EV_FAILED] = END | TO_FAULT,
        },
    [MISSION_FAULT] =
        {
            [MISSION_EV_TAKE_OFF] = TO_TAKEOFF,
            [MISSION_EV_TASK] = TO_IDLE,
            [MISSION_EV_RELOCALISE] = TO_TAKEOFF,
        },
    [MISSION_RELOCALISE] =
        {
            [MISSION_EV_FOUND] = BY_TASK,
            [MISSION_EV_NOT_FOUND] = END | TO_LAND,
            [MISSION_EV_RELOCALISE] = TO_RELOCALISE,
            [MISSION_EV_SCAN] = TO_SCAN,
            [MISSION_EV_LAND] = END | TO_LAND,
            [MISSION_EV_HOLD] = END | TO_HOVER,
            [MISSION_EV_FAILED] = END | TO_FAULT,
        },
    [MISSION_SPIN] =
        {
            [MISSION_EV_SCANNED] = END | TO_HOVER,
            [MISSION_EV_TASK] = BY_TASK,
            [MISSION_EV_SCAN] = TO_SCAN,
            [MISSION_EV_LAND] = END | TO_LAND,
            [MISSION_EV_HOLD] = END | TO_HOVER,
            [MISSION_EV_NEAR] = TO_AVOID,
            [MISSION_EV_RELOCALISE] = TO_RELOCALISE,
            [MISSION_EV_FAILED] = END | TO_FAULT,
        },
};

void mission_init(mission_t *mission) {
  *mission = (mission_t){.state = MISSION_IDLE, .task = MISSION_TASK_NONE, .fault = MISSION_OK};
}

static mission_state_t after_arrival(mission_task_t task) {
  switch (task) {
  case MISSION_TASK_EXPLORE:
    return MISSION_SCAN;
  case MISSION_TASK_HOME:
    return MISSION_LAND;
  default:
    return MISSION_HOVER;
  }
}

static mission_state_t resolve(uint8_t entry, const mission_t *mission) {
  mission_task_t task = mission->task;
  bool has_task = task != MISSION_TASK_NONE;
  switch (entry) {
  case BY_TASK:
    return task == MISSION_TASK_SPIN ? MISSION_SPIN : has_task ? MISSION_PLAN : MISSION_HOVER;
  case LOOK_AGAIN:
    return has_task ? MISSION_SCAN : MISSION_HOVER;
  case GO:
    return task == MISSION_TASK_HOME ? MISSION_RETURN : MISSION_FOLLOW;
  case AFTER:
    return after_arrival(task);
  default:
    return (mission_state_t)(entry - TO_IDLE);
  }
}

/** Does the drone act on the map in this state? Then it must not be lost. */
static bool needs_pose(mission_state_t state) {
  return state == MISSION_SCAN || state == MISSION_PLAN || state == MISSION_FOLLOW ||
         state == MISSION_RETURN;
}

bool mission_step(mission_t *mission, mission_event_t event) {
  uint8_t entry = NEXT[mission->state][event];
  uint8_t where = entry & (uint8_t)~END;
  bool moves = where != STAY;
  if (moves) {
    mission_state_t next = resolve(where, mission);
    mission->state = mission->lost && needs_pose(next) ? MISSION_RELOCALISE : next;
  }
  bool goal_done = where == AFTER && mission->task != MISSION_TASK_EXPLORE;
  if ((entry & END) != 0 || goal_done) {
    mission->task = MISSION_TASK_NONE;
  }
  return moves;
}

bool mission_airborne(mission_state_t state) {
  return state != MISSION_IDLE && state != MISSION_FAULT;
}
