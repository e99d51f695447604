// SPDX-License-Identifier: GPL-3.0-or-later
/** @file estimator.h  Host version: measurements on their way to the estimator. */
#ifndef ESTIMATOR_H
#define ESTIMATOR_H

#include "stabilizer_types.h"

/** A full queue loses them, as in the firmware. */
void estimatorEnqueuePosition(const positionMeasurement_t *position);
void estimatorEnqueueYawError(const yawErrorMeasurement_t *yawError);

#endif
