// SPDX-License-Identifier: GPL-3.0-or-later
/** @file estimator.h  Host version: measurements for the estimator. */
#ifndef ESTIMATOR_H
#define ESTIMATOR_H

#include "stabilizer_types.h"

/** Both drop the measurement if the queue is full, as the firmware does. */
void estimatorEnqueuePosition(const positionMeasurement_t *position);
void estimatorEnqueueYawError(const yawErrorMeasurement_t *yawError);

#endif
