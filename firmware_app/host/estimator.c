// SPDX-License-Identifier: GPL-3.0-or-later
/* Queue of measurements for the estimator, which is in the simulator. */
#include "estimator.h"

#include "sim_port.h"

enum { QUEUE = 20 }; ///< as in the firmware

static sim_port_measurement_t queue[QUEUE];
static int first, count;

static void enqueue(sim_port_measurement_t measurement) {
  if (count < QUEUE) {
    queue[(first + count++) % QUEUE] = measurement;
  }
}

void estimatorEnqueuePosition(const positionMeasurement_t *position) {
  enqueue((sim_port_measurement_t){
      .x_m = position->x,
      .y_m = position->y,
      .z_m = position->z,
      .sd = position->stdDev,
  });
}

void estimatorEnqueueYawError(const yawErrorMeasurement_t *yawError) {
  enqueue((sim_port_measurement_t){
      .of_yaw = true,
      .yaw_error_rad = yawError->yawError,
      .sd = yawError->stdDev,
  });
}

bool sim_port_take_measurement(sim_port_measurement_t *measurement) {
  if (count == 0) {
    return false;
  }
  *measurement = queue[first];
  first = (first + 1) % QUEUE;
  count--;
  return true;
}
