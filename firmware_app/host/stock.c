// SPDX-License-Identifier: GPL-3.0-or-later
/* The rest of the firmware as the app and clients see it: stock log variables, fed by the
 * simulator, and the supervisor. Stock parameters are in stock_params.c. */
#include <math.h>

#include "log.h"
#include "sim_port.h"
#include "supervisor.h"

enum {
  INFO_ARMED = 1 << 1,
  INFO_CAN_FLY = 1 << 3,
  INFO_FLYING = 1 << 4,
  INFO_TUMBLED = 1 << 5,
  INFO_LOCKED = 1 << 6,
  INFO_CRASHED = 1 << 7,
  RSSI = 40,
};

static const float RAD_PER_DEG = 0.01745329252f;
static const float STANDARD_GRAVITY_MPS2 = 9.80665f;

static sim_port_sensors_t now = {
    .range_mm = {32767, 32767, 32767, 32767, 32767},
    .var_velocity_m2ps2 = {1.0f, 1.0f, 1.0f},
    .var_position_m2 = {100.0f, 100.0f, 1.0f},
};

/** Log variables computed from `now`. */
static struct {
  float quaternion[4]; ///< x y z w
  float acc_g[3];      ///< as measured in the body, gravity included
  int16_t position_mm[3];
  int16_t velocity_mmps[3];
  int16_t acceleration_mmps2[3];
  int16_t rate_mradps[3];
  uint16_t battery_mv;
  uint8_t can_fly, flying, tumbled;
} derived;

static uint8_t rssi = RSSI;
static uint8_t radio_connected = 1;
static uint16_t no_rate;
static int arming_request;

static int16_t to_int16(float value) {
  return (int16_t)fmaxf(fminf(value, 32767.0f), -32768.0f);
}

static void derive_quaternion(void) {
  const float roll = 0.5f * RAD_PER_DEG * now.roll_deg;
  const float pitch = -0.5f * RAD_PER_DEG * now.pitch_deg; // the logged pitch is inverted
  const float yaw = 0.5f * RAD_PER_DEG * now.yaw_deg;
  const float sr = sinf(roll), cr = cosf(roll);
  const float sp = sinf(pitch), cp = cosf(pitch);
  const float sy = sinf(yaw), cy = cosf(yaw);
  derived.quaternion[0] = sr * cp * cy - cr * sp * sy;
  derived.quaternion[1] = cr * sp * cy + sr * cp * sy;
  derived.quaternion[2] = cr * cp * sy - sr * sp * cy;
  derived.quaternion[3] = cr * cp * cy + sr * sp * sy;
}

/** Specific force in the body frame: acceleration plus gravity, rotated from the world frame. */
static void derive_acc(void) {
  const float x = -derived.quaternion[0], y = -derived.quaternion[1];
  const float z = -derived.quaternion[2], w = derived.quaternion[3];
  const float ax = now.ax_g, ay = now.ay_g, az = now.az_g + 1.0f;
  const float tx = 2.0f * (y * az - z * ay);
  const float ty = 2.0f * (z * ax - x * az);
  const float tz = 2.0f * (x * ay - y * ax);
  derived.acc_g[0] = ax + w * tx + y * tz - z * ty;
  derived.acc_g[1] = ay + w * ty + z * tx - x * tz;
  derived.acc_g[2] = az + w * tz + x * ty - y * tx;
}

static void derive_compressed(void) {
  const float position_m[] = {now.x_m, now.y_m, now.z_m};
  const float velocity_mps[] = {now.vx_mps, now.vy_mps, now.vz_mps};
  const float acceleration_g[] = {now.ax_g, now.ay_g, now.az_g};
  for (int i = 0; i < 3; i++) {
    derived.position_mm[i] = to_int16(1000.0f * position_m[i]);
    derived.velocity_mmps[i] = to_int16(1000.0f * velocity_mps[i]);
    derived.acceleration_mmps2[i] = to_int16(1000.0f * STANDARD_GRAVITY_MPS2 * acceleration_g[i]);
    derived.rate_mradps[i] = to_int16(1000.0f * RAD_PER_DEG * now.gyro_dps[i]);
  }
  derived.battery_mv = (uint16_t)to_int16(1000.0f * now.battery_v);
}

static bool info(uint16_t bit) {
  return (now.supervisor_info & bit) != 0;
}

void sim_port_set_sensors(const sim_port_sensors_t *sensors) {
  now = *sensors;
  derive_quaternion();
  derive_acc();
  derive_compressed();
  derived.can_fly = info(INFO_CAN_FLY);
  derived.flying = info(INFO_FLYING);
  derived.tumbled = info(INFO_TUMBLED);
}

bool supervisorCanFly(void) {
  return info(INFO_CAN_FLY);
}

bool supervisorIsFlying(void) {
  return info(INFO_FLYING);
}

bool supervisorIsTumbled(void) {
  return info(INFO_TUMBLED);
}

bool supervisorIsArmed(void) {
  return info(INFO_ARMED);
}

bool supervisorIsLocked(void) {
  return info(INFO_LOCKED);
}

bool supervisorIsCrashed(void) {
  return info(INFO_CRASHED);
}

bool supervisorRequestArming(bool arm) {
  arming_request = arm ? 2 : 1;
  return false;
}

int sim_port_take_arming_request(void) {
  const int request = arming_request;
  arming_request = 0;
  return request;
}

LOG_GROUP_START(stateEstimate)
LOG_ADD_CORE(LOG_FLOAT, x, &now.x_m)
LOG_ADD_CORE(LOG_FLOAT, y, &now.y_m)
LOG_ADD_CORE(LOG_FLOAT, z, &now.z_m)
LOG_ADD_CORE(LOG_FLOAT, vx, &now.vx_mps)
LOG_ADD_CORE(LOG_FLOAT, vy, &now.vy_mps)
LOG_ADD_CORE(LOG_FLOAT, vz, &now.vz_mps)
LOG_ADD_CORE(LOG_FLOAT, ax, &now.ax_g)
LOG_ADD_CORE(LOG_FLOAT, ay, &now.ay_g)
LOG_ADD_CORE(LOG_FLOAT, az, &now.az_g)
LOG_ADD_CORE(LOG_FLOAT, roll, &now.roll_deg)
LOG_ADD_CORE(LOG_FLOAT, pitch, &now.pitch_deg)
LOG_ADD_CORE(LOG_FLOAT, yaw, &now.yaw_deg)
LOG_ADD_CORE(LOG_FLOAT, qx, &derived.quaternion[0])
LOG_ADD_CORE(LOG_FLOAT, qy, &derived.quaternion[1])
LOG_ADD_CORE(LOG_FLOAT, qz, &derived.quaternion[2])
LOG_ADD_CORE(LOG_FLOAT, qw, &derived.quaternion[3])
LOG_GROUP_STOP(stateEstimate)

LOG_GROUP_START(stateEstimateZ)
LOG_ADD(LOG_INT16, x, &derived.position_mm[0])
LOG_ADD(LOG_INT16, y, &derived.position_mm[1])
LOG_ADD(LOG_INT16, z, &derived.position_mm[2])
LOG_ADD(LOG_INT16, vx, &derived.velocity_mmps[0])
LOG_ADD(LOG_INT16, vy, &derived.velocity_mmps[1])
LOG_ADD(LOG_INT16, vz, &derived.velocity_mmps[2])
LOG_ADD(LOG_INT16, ax, &derived.acceleration_mmps2[0])
LOG_ADD(LOG_INT16, ay, &derived.acceleration_mmps2[1])
LOG_ADD(LOG_INT16, az, &derived.acceleration_mmps2[2])
LOG_ADD(LOG_INT16, rateRoll, &derived.rate_mradps[0])
LOG_ADD(LOG_INT16, ratePitch, &derived.rate_mradps[1])
LOG_ADD(LOG_INT16, rateYaw, &derived.rate_mradps[2])
LOG_GROUP_STOP(stateEstimateZ)

LOG_GROUP_START(stabilizer)
LOG_ADD(LOG_FLOAT, roll, &now.roll_deg)
LOG_ADD(LOG_FLOAT, pitch, &now.pitch_deg)
LOG_ADD(LOG_FLOAT, yaw, &now.yaw_deg)
LOG_ADD(LOG_FLOAT, thrust, &now.motor_thrust)
LOG_GROUP_STOP(stabilizer)

LOG_GROUP_START(range)
LOG_ADD_CORE(LOG_UINT16, front, &now.range_mm[0])
LOG_ADD_CORE(LOG_UINT16, back, &now.range_mm[1])
LOG_ADD_CORE(LOG_UINT16, left, &now.range_mm[2])
LOG_ADD_CORE(LOG_UINT16, right, &now.range_mm[3])
LOG_ADD_CORE(LOG_UINT16, up, &now.range_mm[4])
LOG_ADD_CORE(LOG_UINT16, zrange, &now.zrange_mm)
LOG_GROUP_STOP(range)

LOG_GROUP_START(kalman)
LOG_ADD(LOG_FLOAT, varX, &now.var_position_m2[0])
LOG_ADD(LOG_FLOAT, varY, &now.var_position_m2[1])
LOG_ADD(LOG_FLOAT, varZ, &now.var_position_m2[2])
LOG_ADD(LOG_FLOAT, varPX, &now.var_velocity_m2ps2[0])
LOG_ADD(LOG_FLOAT, varPY, &now.var_velocity_m2ps2[1])
LOG_ADD(LOG_FLOAT, varPZ, &now.var_velocity_m2ps2[2])
LOG_ADD(LOG_FLOAT, varD0, &now.var_attitude_rad2[0])
LOG_ADD(LOG_FLOAT, varD1, &now.var_attitude_rad2[1])
LOG_ADD(LOG_FLOAT, varD2, &now.var_attitude_rad2[2])
LOG_GROUP_STOP(kalman)

LOG_GROUP_START(lighthouse)
LOG_ADD_CORE(LOG_UINT16, bsActive, &now.lighthouse_active)
LOG_ADD_CORE(LOG_UINT8, status, &now.lighthouse_status)
LOG_GROUP_STOP(lighthouse)

LOG_GROUP_START(loco)
LOG_ADD_CORE(LOG_UINT8, mode, &now.loco_mode)
LOG_GROUP_STOP(loco)

LOG_GROUP_START(ranging)
LOG_ADD(LOG_UINT16, state, &now.ranging_state)
LOG_GROUP_STOP(ranging)

LOG_GROUP_START(locSrv)
LOG_ADD_CORE(LOG_FLOAT, x, &now.external_m[0])
LOG_ADD_CORE(LOG_FLOAT, y, &now.external_m[1])
LOG_ADD_CORE(LOG_FLOAT, z, &now.external_m[2])
LOG_ADD_CORE(LOG_FLOAT, qx, &now.external_q[0])
LOG_ADD_CORE(LOG_FLOAT, qy, &now.external_q[1])
LOG_ADD_CORE(LOG_FLOAT, qz, &now.external_q[2])
LOG_ADD_CORE(LOG_FLOAT, qw, &now.external_q[3])
LOG_GROUP_STOP(locSrv)

LOG_GROUP_START(locSrvZ)
LOG_ADD_CORE(LOG_UINT16, tick, &now.external_tick)
LOG_GROUP_STOP(locSrvZ)

LOG_GROUP_START(gyro)
LOG_ADD_CORE(LOG_FLOAT, x, &now.gyro_dps[0])
LOG_ADD_CORE(LOG_FLOAT, y, &now.gyro_dps[1])
LOG_ADD_CORE(LOG_FLOAT, z, &now.gyro_dps[2])
LOG_GROUP_STOP(gyro)

LOG_GROUP_START(acc)
LOG_ADD_CORE(LOG_FLOAT, x, &derived.acc_g[0])
LOG_ADD_CORE(LOG_FLOAT, y, &derived.acc_g[1])
LOG_ADD_CORE(LOG_FLOAT, z, &derived.acc_g[2])
LOG_GROUP_STOP(acc)

LOG_GROUP_START(motion)
LOG_ADD(LOG_UINT8, squal, &now.motion_quality)
LOG_ADD(LOG_INT16, deltaX, &now.motion_dx)
LOG_ADD(LOG_INT16, deltaY, &now.motion_dy)
LOG_GROUP_STOP(motion)

LOG_GROUP_START(motor)
LOG_ADD_CORE(LOG_UINT16, m1, &now.motor_pwm[0])
LOG_ADD_CORE(LOG_UINT16, m2, &now.motor_pwm[1])
LOG_ADD_CORE(LOG_UINT16, m3, &now.motor_pwm[2])
LOG_ADD_CORE(LOG_UINT16, m4, &now.motor_pwm[3])
LOG_GROUP_STOP(motor)

LOG_GROUP_START(pm)
LOG_ADD_CORE(LOG_FLOAT, vbat, &now.battery_v)
LOG_ADD(LOG_UINT16, vbatMV, &derived.battery_mv)
LOG_ADD_CORE(LOG_INT8, state, &now.battery_state)
LOG_ADD_CORE(LOG_UINT8, batteryLevel, &now.battery_percent)
LOG_GROUP_STOP(pm)

LOG_GROUP_START(supervisor)
LOG_ADD(LOG_UINT16, info, &now.supervisor_info)
LOG_GROUP_STOP(supervisor)

LOG_GROUP_START(sys)
LOG_ADD_CORE(LOG_UINT8, canfly, &derived.can_fly)
LOG_ADD_CORE(LOG_UINT8, isFlying, &derived.flying)
LOG_ADD_CORE(LOG_UINT8, isTumbled, &derived.tumbled)
LOG_GROUP_STOP(sys)

LOG_GROUP_START(radio)
LOG_ADD_CORE(LOG_UINT8, rssi, &rssi)
LOG_ADD_CORE(LOG_UINT8, isConnected, &radio_connected)
LOG_GROUP_STOP(radio)

LOG_GROUP_START(crtp)
LOG_ADD(LOG_UINT16, rxRate, &no_rate)
LOG_ADD(LOG_UINT16, txRate, &no_rate)
LOG_GROUP_STOP(crtp)
