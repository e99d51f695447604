// SPDX-License-Identifier: GPL-3.0-or-later
/** @file sim_port.h  The simulator's interface to the firmware on a PC.
 *
 *  The app includes firmware headers (log.h, param.h, commander.h, ...), of which this folder has
 *  small host versions. The simulator includes none of them; it calls the functions below. One
 *  loaded library is one Crazyflie. Time advances only in sim_port_run(); the app runs as a
 *  coroutine and is never preempted.
 */
#ifndef SIM_PORT_H
#define SIM_PORT_H

#include <stdbool.h>
#include <stdint.h>

enum {
  SIM_PORT_NAME_BYTES = 32,
  SIM_PORT_APPCHANNEL_BYTES = 30,
  SIM_PORT_CONSOLE_BYTES = 30,
};

/** Estimate and measurements of the rest of the firmware, as its stock log variables show them
 *  (stateEstimate, range, pm, ...). Units are the firmware's: millimetres, degrees, G. */
typedef struct {
  float x_m, y_m, z_m;
  float vx_mps, vy_mps, vz_mps;
  float ax_g, ay_g, az_g;             ///< world frame, without gravity
  float roll_deg, pitch_deg, yaw_deg; ///< pitch positive nose up, as the firmware logs it
  float gyro_dps[3];
  float var_velocity_m2ps2[3]; ///< kalman.varPX varPY varPZ: variances of the velocity [(m/s)^2]
  uint16_t range_mm[5];        ///< front, back, left, right, up; 32767: no return
  uint16_t zrange_mm;          ///< downwards
  float battery_v;
  uint8_t battery_percent;
  int8_t battery_state;
  uint16_t supervisor_info; ///< bits as logged in supervisor.info
  uint8_t motion_quality;   ///< motion.squal
  int16_t motion_dx, motion_dy;
  float motor_thrust; ///< stabilizer.thrust
  uint16_t motor_pwm[4];
  float var_position_m2[3];   ///< kalman.varX varY varZ
  float var_attitude_rad2[3]; ///< kalman.varD0 varD1 varD2
  uint8_t lighthouse_status;  ///< 2: its angles go to the estimator
  uint16_t lighthouse_active; ///< bit mask of the base stations whose angles do
  uint8_t loco_mode;          ///< 1 TWR, 2 TDoA 2, 3 TDoA 3
  uint16_t ranging_state;     ///< bit mask of Loco anchors heard; always 0 in TDoA 3
  float external_m[3];        ///< locSrv.x y z: last position sent from the ground
  float external_q[4];        ///< locSrv.qx qy qz qw: last attitude sent
  uint16_t external_tick;     ///< locSrvZ.tick: its arrival [ms]
} sim_port_sensors_t;

/** Measurement that the app has given to the estimator. */
typedef struct {
  bool of_yaw; ///< of the yaw; else of the position
  float x_m, y_m, z_m;
  float yaw_error_rad; ///< estimated minus measured
  float sd;            ///< standard deviation [m] or [rad]
} sim_port_measurement_t;

/** A setpoint. Modes as in stabilizer_types.h: 0 off, 1 absolute, 2 velocity. */
typedef struct {
  uint8_t mode_x, mode_y, mode_z, mode_roll, mode_pitch, mode_yaw;
  bool velocity_body;
  float x_m, y_m, z_m;
  float vx_mps, vy_mps, vz_mps;
  float roll_deg, pitch_deg, yaw_deg;
  float yaw_rate_dps;
  float thrust;     ///< 0..65535
  uint32_t age_ms;  ///< since it was set
  uint8_t priority; ///< of its source: 1 high level, 2 CRTP, 3 app
} sim_port_setpoint_t;

typedef struct {
  uint8_t type;              ///< raw type byte, flags included
  bool extended, persistent; ///< parameters only
  char group[SIM_PORT_NAME_BYTES];
  char name[SIM_PORT_NAME_BYTES];
} sim_port_entry_t;

/** Start the app's task and run it up to its first delay. The tables exist once the library is
 *  loaded, so that stored parameters may be restored before. */
void sim_port_boot(void);
/** Advance the time; the app runs whenever it is due. */
void sim_port_run(uint32_t ms);
/** Delay the app's next wake-up, as if other tasks had used up this time. */
void sim_port_stall(uint32_t ms);
uint32_t sim_port_now_ms(void);
/** False after an assertion failed in the app; its text is in the console. */
bool sim_port_alive(void);

void sim_port_set_sensors(const sim_port_sensors_t *sensors);
/** Set crtpIsConnected(): has a client sent a packet lately? */
void sim_port_set_connected(bool connected);
/** Set the size of the transmit queue for the app; packets not yet taken occupy it. */
void sim_port_set_tx_free(int packets);

/** Present setpoint of the stabilizer. */
void sim_port_get_setpoint(sim_port_setpoint_t *setpoint);
/** Give a setpoint from another source (CRTP, high-level commander).
 *  @return false if a higher priority holds the vehicle */
bool sim_port_put_setpoint(const sim_port_setpoint_t *setpoint, int priority);
void sim_port_relax_priority(void);
/** Priority below which setpoints are refused at present. */
int sim_port_active_priority(void);
/** The app's last request since the previous call: 0 none, 1 disarm, 2 arm. */
int sim_port_take_arming_request(void);

/** Take the oldest measurement that waits for the estimator. @return false if none waits */
bool sim_port_take_measurement(sim_port_measurement_t *measurement);

int sim_port_log_count(void);
bool sim_port_log_entry(int id, sim_port_entry_t *entry);
/** Read a variable, converted to log type fetch_type (1..8, 8 is FP16), into little-endian bytes.
 *  @param time_ms  time stamp given to variables by function
 *  @return bytes written; 0 if id or type is unknown */
int sim_port_log_read(int id, int fetch_type, uint32_t time_ms, uint8_t *bytes);
/** Read n variables one after the other, as a log block does.
 *  @return bytes written; 0 if an id or type is unknown */
int sim_port_log_read_block(const uint16_t *ids, const uint8_t *types, int n, uint32_t time_ms,
                            uint8_t *bytes);
uint32_t sim_port_log_crc(void);

int sim_port_param_count(void);
bool sim_port_param_entry(int id, sim_port_entry_t *entry);
/** @return bytes written, the size of the type; 0 if the id is unknown */
int sim_port_param_read(int id, uint8_t *bytes);
int sim_port_param_default(int id, uint8_t *bytes);
/** Store a value and call the callback.
 *  @return 0, ENOENT (2), EACCES (13, read-only) or EINVAL (22, wrong size) */
int sim_port_param_write(int id, const uint8_t *bytes, int size);
/** Store a value without the callback, read-only or not: for what the firmware itself sets, such as
 *  decks found, and stored values before sim_port_boot(). @return 0, ENOENT or EINVAL */
int sim_port_param_force(int id, const uint8_t *bytes, int size);
/** Take the id of a parameter that the firmware changed (paramSet*) while a client was connected.
 *  @return -1 if there is none */
int sim_port_take_param_update(void);
uint32_t sim_port_param_crc(void);

/** Send a packet to the app. @return false if its queue of 10 is full */
bool sim_port_appchannel_push(const uint8_t *bytes, int size);
/** Take the oldest packet that the app sent. @return its bytes, 0 if there is none */
int sim_port_appchannel_take(uint8_t *bytes);
/** Take a packet of console text. @return characters, at most SIM_PORT_CONSOLE_BYTES */
int sim_port_console_take(char *text);

#endif
