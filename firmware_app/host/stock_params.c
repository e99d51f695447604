// SPDX-License-Identifier: GPL-3.0-or-later
/* Stock parameters that cfclient and cflib's helpers read or write. Values only: their effects are
 * simulated elsewhere. */
#include "param.h"

/** 1: the deck is attached. */
static struct {
  uint8_t multiranger, flow, flow2, zranger, zranger2, lighthouse, loco, none;
} deck = {.multiranger = 1, .flow2 = 1, .zranger2 = 1};

static struct {
  uint8_t high_level;
  uint8_t althold, poshold, poshold_set, yaw_mode;
  uint8_t stab_roll, stab_pitch, stab_yaw;
  uint8_t estimator, controller, stop;
} flight = {.stab_roll = 1, .stab_pitch = 1, .estimator = 2, .controller = 1};

static struct {
  uint8_t reset;
  float x_m, y_m, z_m, yaw_rad;
} kalman;

static struct {
  uint8_t tumble_check;
  uint16_t preflight_timeout_ms, landed_timeout_ms;
  float crash_g;
} supervisor = {.tumble_check = 1, .preflight_timeout_ms = 30000, .landed_timeout_ms = 3000};

static struct {
  float kp, x_max_mps, y_max_mps, z_max_mps, roll_max_deg, pitch_max_deg;
} position = {2.0f, 1.0f, 1.0f, 1.0f, 20.0f, 20.0f};

static struct { float position_m, quaternion; } ext_std = {0.01f, 4.5e-3f};

static struct { float takeoff_mps, land_mps; } high_level = {0.5f, 0.5f};

static struct { float low_v, critical_v; } battery = {3.2f, 3.0f};

static uint8_t always = 1;
static uint8_t assert_info;
static uint16_t filter_mask = 1;
static uint8_t flow_disabled;
static uint32_t revision0;
static uint16_t revision1;
static uint8_t modified;

PARAM_GROUP_START(deck)
PARAM_ADD_CORE(PARAM_UINT8 | PARAM_RONLY, bcMultiranger, &deck.multiranger)
PARAM_ADD_CORE(PARAM_UINT8 | PARAM_RONLY, bcFlow, &deck.flow)
PARAM_ADD_CORE(PARAM_UINT8 | PARAM_RONLY, bcFlow2, &deck.flow2)
PARAM_ADD_CORE(PARAM_UINT8 | PARAM_RONLY, bcZRanger, &deck.zranger)
PARAM_ADD_CORE(PARAM_UINT8 | PARAM_RONLY, bcZRanger2, &deck.zranger2)
PARAM_ADD_CORE(PARAM_UINT8 | PARAM_RONLY, bcLighthouse4, &deck.lighthouse)
PARAM_ADD_CORE(PARAM_UINT8 | PARAM_RONLY, bcLoco, &deck.loco)
PARAM_ADD_CORE(PARAM_UINT8 | PARAM_RONLY, bcDWM1000, &deck.loco)
PARAM_ADD_CORE(PARAM_UINT8 | PARAM_RONLY, bcLedRing, &deck.none)
PARAM_ADD_CORE(PARAM_UINT8 | PARAM_RONLY, bcBuzzer, &deck.none)
PARAM_ADD_CORE(PARAM_UINT8 | PARAM_RONLY, bcAI, &deck.none)
PARAM_ADD_CORE(PARAM_UINT8 | PARAM_RONLY, bcUSD, &deck.none)
PARAM_ADD_CORE(PARAM_UINT8 | PARAM_RONLY, bcOA, &deck.none)
PARAM_GROUP_STOP(deck)

PARAM_GROUP_START(commander)
PARAM_ADD_CORE(PARAM_UINT8, enHighLevel, &flight.high_level)
PARAM_GROUP_STOP(commander)

PARAM_GROUP_START(flightmode)
PARAM_ADD_CORE(PARAM_UINT8, althold, &flight.althold)
PARAM_ADD_CORE(PARAM_UINT8, poshold, &flight.poshold)
PARAM_ADD_CORE(PARAM_UINT8, posSet, &flight.poshold_set)
PARAM_ADD(PARAM_UINT8, yawMode, &flight.yaw_mode)
PARAM_ADD_CORE(PARAM_UINT8, stabModeRoll, &flight.stab_roll)
PARAM_ADD_CORE(PARAM_UINT8, stabModePitch, &flight.stab_pitch)
PARAM_ADD_CORE(PARAM_UINT8, stabModeYaw, &flight.stab_yaw)
PARAM_GROUP_STOP(flightmode)

PARAM_GROUP_START(stabilizer)
PARAM_ADD_CORE(PARAM_UINT8, estimator, &flight.estimator)
PARAM_ADD_CORE(PARAM_UINT8, controller, &flight.controller)
PARAM_ADD_CORE(PARAM_UINT8, stop, &flight.stop)
PARAM_GROUP_STOP(stabilizer)

PARAM_GROUP_START(kalman)
PARAM_ADD_CORE(PARAM_UINT8, resetEstimation, &kalman.reset)
PARAM_ADD_CORE(PARAM_FLOAT, initialX, &kalman.x_m)
PARAM_ADD_CORE(PARAM_FLOAT, initialY, &kalman.y_m)
PARAM_ADD_CORE(PARAM_FLOAT, initialZ, &kalman.z_m)
PARAM_ADD_CORE(PARAM_FLOAT, initialYaw, &kalman.yaw_rad)
PARAM_GROUP_STOP(kalman)

PARAM_GROUP_START(supervisor)
PARAM_ADD(PARAM_UINT16 | PARAM_PERSISTENT, prefltTimeout, &supervisor.preflight_timeout_ms)
PARAM_ADD(PARAM_UINT16 | PARAM_PERSISTENT, landedTimeout, &supervisor.landed_timeout_ms)
PARAM_ADD(PARAM_UINT8 | PARAM_PERSISTENT, tmblChckEn, &supervisor.tumble_check)
PARAM_ADD(PARAM_FLOAT | PARAM_PERSISTENT, crashDetectGs, &supervisor.crash_g)
PARAM_GROUP_STOP(supervisor)

PARAM_GROUP_START(posCtlPid)
PARAM_ADD(PARAM_FLOAT | PARAM_PERSISTENT, xKp, &position.kp)
PARAM_ADD(PARAM_FLOAT | PARAM_PERSISTENT, rLimit, &position.roll_max_deg)
PARAM_ADD(PARAM_FLOAT | PARAM_PERSISTENT, pLimit, &position.pitch_max_deg)
PARAM_ADD(PARAM_FLOAT | PARAM_PERSISTENT, xVelMax, &position.x_max_mps)
PARAM_ADD(PARAM_FLOAT | PARAM_PERSISTENT, yVelMax, &position.y_max_mps)
PARAM_ADD(PARAM_FLOAT | PARAM_PERSISTENT, zVelMax, &position.z_max_mps)
PARAM_GROUP_STOP(posCtlPid)

PARAM_GROUP_START(locSrv)
PARAM_ADD_CORE(PARAM_FLOAT, extPosStdDev, &ext_std.position_m)
PARAM_ADD_CORE(PARAM_FLOAT, extQuatStdDev, &ext_std.quaternion)
PARAM_GROUP_STOP(locSrv)

PARAM_GROUP_START(hlCommander)
PARAM_ADD_CORE(PARAM_FLOAT, vtoff, &high_level.takeoff_mps)
PARAM_ADD_CORE(PARAM_FLOAT, vland, &high_level.land_mps)
PARAM_GROUP_STOP(hlCommander)

PARAM_GROUP_START(pm)
PARAM_ADD_CORE(PARAM_FLOAT | PARAM_PERSISTENT, lowVoltage, &battery.low_v)
PARAM_ADD_CORE(PARAM_FLOAT | PARAM_PERSISTENT, criticalLowVoltage, &battery.critical_v)
PARAM_GROUP_STOP(pm)

PARAM_GROUP_START(motion)
PARAM_ADD(PARAM_UINT8, disable, &flow_disabled)
PARAM_GROUP_STOP(motion)

PARAM_GROUP_START(multiranger)
PARAM_ADD(PARAM_UINT16, filterMask, &filter_mask)
PARAM_GROUP_STOP(multiranger)

PARAM_GROUP_START(imu_sensors)
PARAM_ADD(PARAM_UINT8 | PARAM_RONLY, BMP3XX, &always)
PARAM_GROUP_STOP(imu_sensors)

PARAM_GROUP_START(system)
PARAM_ADD_CORE(PARAM_INT8 | PARAM_RONLY, selftestPassed, &always)
PARAM_ADD(PARAM_UINT8, assertInfo, &assert_info)
PARAM_GROUP_STOP(system)

PARAM_GROUP_START(firmware)
PARAM_ADD_CORE(PARAM_UINT32 | PARAM_RONLY, revision0, &revision0)
PARAM_ADD_CORE(PARAM_UINT16 | PARAM_RONLY, revision1, &revision1)
PARAM_ADD_CORE(PARAM_UINT8 | PARAM_RONLY, modified, &modified)
PARAM_GROUP_STOP(firmware)
