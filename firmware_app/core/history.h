// SPDX-License-Identifier: GPL-3.0-or-later
/** @file history.h  Records of where the drone was and of how its map pose was corrected.
 *
 * Records have sequence numbers, and the last HISTORY_RECORDS are kept, so that the ground station
 * can ask for those it missed. They are derived from nav after each tick: a motion of the map pose
 * that odometry does not explain is a correction. */
#ifndef HISTORY_H
#define HISTORY_H

#include <stdbool.h>
#include <stdint.h>

#include "nav.h"

enum { HISTORY_RECORDS = 16 };

typedef struct {
  wire_record_t records[HISTORY_RECORDS]; ///< sequence number s is at s % HISTORY_RECORDS
  uint16_t next;                          ///< sequence number of the next record
  uint8_t kept;                           ///< number of records still available
  bool lost;                              ///< in the previous tick
  pose2_t pose, odometry;                 ///< in the previous tick: map pose and odometry pose
  vec2_t recorded_m;                      ///< position in the last WIRE_RECORD_POSE
} history_t;

/** To be called after each nav_step. */
void history_step(history_t *history, const nav_t *nav);
/** Copy up to WIRE_RECORDS_A_PACKET records from this sequence number on; records no longer kept
 * are skipped. @return false if there is none */
bool history_get(const history_t *history, uint16_t sequence, wire_history_t *found);

#endif
