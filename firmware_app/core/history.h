// SPDX-License-Identifier: GPL-3.0-or-later
/** @file history.h  Where the drone was, and by how much it was corrected: records with sequence
 * numbers, the last of them kept so that the ground may ask for what it missed. Looks at nav after
 * each tick: what moves the pose by more than odometry explains is a correction. */
#ifndef HISTORY_H
#define HISTORY_H

#include <stdbool.h>
#include <stdint.h>

#include "nav.h"

enum { HISTORY_RECORDS = 16 };

typedef struct {
  wire_record_t records[HISTORY_RECORDS]; ///< of sequence s in s % HISTORY_RECORDS
  uint16_t next;                          ///< sequence of the record that comes next
  uint8_t kept;                           ///< as many as are still there
  bool lost;
  pose2_t pose, odometry; ///< of the tick before
  vec2_t recorded_m;      ///< the last pose
} history_t;

/** Once after each nav_step. */
void history_step(history_t *history, const nav_t *nav);
/** Up to WIRE_RECORDS_A_PACKET records from this sequence on; those that are gone are skipped.
 * @return false if there is none */
bool history_get(const history_t *history, uint16_t sequence, wire_history_t *found);

#endif
