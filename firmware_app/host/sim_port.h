// SPDX-License-Identifier: GPL-3.0-or-later
/** @file sim_port.h  What a simulator sees of the firmware on the PC: the other side of the host
 * firmware API. The app includes firmware headers (log.h, param.h, commander.h, ...), which exist
 * here as small host versions. The simulator includes none of them; it calls these functions. One
 * loaded library is one Crazyflie. Time stands still unless sim_port_run() moves it; the app runs
 * as a coroutine and is never preempted. */
#ifndef SIM_PORT_H
#define SIM_PORT_H

#include <stdbool.h>
#include <stdint.h>

enum {
  SIM_PORT_NAME_BYTES = 32,
  SIM_PORT_APPCHANNEL_BYTES = 30,
  SIM_PORT_CONSOLE_BYTES = 30,
};

/** What the rest of the firmware measures; the stock log variables (stateEstimate, range, pm, ...)
 * show these. Units are the firmware's: millimetres, degrees, G. */
typedef struct {
  float x_m, y_m, z_m;
  float vx_mps, vy_mps, vz_mps;
  float ax_g, ay_g, az_g;             ///< world frame, without gravity
  float roll_deg, pitch_deg, yaw_deg; ///< pitch nose up positive, as the firmware logs it
  float gyro_dps[3];
  float var_position_m2[3]; ///< kalman.varPX varPY varPZ, which are of the velocity
  uint16_t range_mm[5];     ///< front, back, left, right, up; 32767 = none
  uint16_t zrange_mm;
  float battery_v;
  uint8_t battery_percent;
  int8_t battery_state;
  uint16_t supervisor_info; ///< bits as logged in supervisor.info
  uint8_t motion_quality;   ///< motion.squal
  int16_t motion_dx, motion_dy;
  float motor_thrust; ///< stabilizer.thrust
  uint16_t motor_pwm[4];
  float var_place_m2[3];      ///< kalman.varX varY varZ
  float var_attitude_rad2[3]; ///< kalman.varD0 varD1 varD2
  uint8_t lighthouse_status;  ///< 2: its angles go to the estimator
  uint16_t lighthouse_active; ///< base stations that do, a bit each
  uint8_t loco_mode;          ///< 1 TWR, 2 TDoA 2, 3 TDoA 3
  uint16_t ranging_state;     ///< loco's anchors heard, a bit each; always 0 in TDoA 3
  float external_m[3];        ///< locSrv.x y z: the position that the ground sent last
  float external_q[4];        ///< and the attitude, x y z w
  uint16_t external_tick;     ///< when [ms]
} sim_port_sensors_t;

/** What the app has told the estimator. */
typedef struct {
  bool of_yaw; ///< else of the position
  float x_m, y_m, z_m;
  float yaw_error_rad; ///< estimated minus measured
  float sd;
} sim_port_measurement_t;

/** Modes as in stabilizer_types.h: 0 off, 1 absolute, 2 velocity. */
typedef struct {
  uint8_t mode_x, mode_y, mode_z, mode_roll, mode_pitch, mode_yaw;
  bool velocity_body;
  float x_m, y_m, z_m;
  float vx_mps, vy_mps, vz_mps;
  float roll_deg, pitch_deg, yaw_deg;
  float yaw_rate_dps;
  float thrust;     ///< 0..65535
  uint32_t age_ms;  ///< since it was set
  uint8_t priority; ///< of who set it: 1 high level, 2 CRTP, 3 app
} sim_port_setpoint_t;

typedef struct {
  uint8_t type;              ///< raw type byte of the table, flags included
  bool extended, persistent; ///< parameters only
  char group[SIM_PORT_NAME_BYTES];
  char name[SIM_PORT_NAME_BYTES];
} sim_port_entry_t;

/** Start the app's task and run it up to its first delay. The tables stand already when the library
 * is loaded, so that parameters may be written before: values restored from the EEPROM. */
void sim_port_boot(void);
/** Let ms of firmware time pass; the app and due callbacks run. */
void sim_port_run(uint32_t ms);
/** Other tasks take all the time: the app goes on so much later. */
void sim_port_stall(uint32_t ms);
uint32_t sim_port_now_ms(void);
/** False after an assertion failed in the app; its text is in the console. */
bool sim_port_alive(void);

void sim_port_set_sensors(const sim_port_sensors_t *sensors);
/** A client has sent a packet lately: crtpIsConnected(). */
void sim_port_set_connected(bool connected);
/** Slots free in the transmit queue for what the app sends; packets not yet taken fill them. */
void sim_port_set_tx_free(int packets);

/** The setpoint that the stabilizer would take now. */
void sim_port_get_setpoint(sim_port_setpoint_t *setpoint);
/** A setpoint from elsewhere (CRTP, high-level commander). @return false if a higher priority holds
 * the vehicle */
bool sim_port_put_setpoint(const sim_port_setpoint_t *setpoint, int priority);
void sim_port_relax_priority(void);
/** A setpoint of a lower priority than this is refused now. */
int sim_port_active_priority(void);
/** What the app asked of arming, since last asked: 0 nothing, 1 disarm, 2 arm. */
int sim_port_take_arming_request(void);

/** The oldest measurement for the estimator that was not taken yet. @return false if none waits */
bool sim_port_take_measurement(sim_port_measurement_t *measurement);

int sim_port_log_count(void);
bool sim_port_log_entry(int id, sim_port_entry_t *entry);
/** Read variable id, converted to log type fetch_type (1..8, 8 = FP16), at time_ms, into bytes
 * (little-endian). By-function variables get time_ms. @return bytes written, 0 if id or type is
 * unknown */
int sim_port_log_read(int id, int fetch_type, uint32_t time_ms, uint8_t *bytes);
/** Read n variables, one sim_port_log_read() after the other, into bytes: one run of a log block.
 *  @return bytes written, 0 if an id or type is unknown */
int sim_port_log_read_block(const uint16_t *ids, const uint8_t *types, int n, uint32_t time_ms,
                            uint8_t *bytes);
uint32_t sim_port_log_crc(void);

int sim_port_param_count(void);
bool sim_port_param_entry(int id, sim_port_entry_t *entry);
/** @return bytes written (size of the type), 0 if unknown */
int sim_port_param_read(int id, uint8_t *bytes);
int sim_port_param_default(int id, uint8_t *bytes);
/** Store and call the callback. @return 0, or ENOENT 2, EACCES 13 (read-only), EINVAL 22 (wrong
 * size) */
int sim_port_param_write(int id, const uint8_t *bytes, int size);
/** Store without a callback, read-only or not: what the firmware itself holds (decks found, values
 * kept since the last start, before sim_port_boot). @return as sim_port_param_write, never EACCES
 */
int sim_port_param_force(int id, const uint8_t *bytes, int size);
/** Next parameter that the firmware itself changed (paramSet*) while a client was connected, -1 if
 * none. */
int sim_port_take_param_update(void);
uint32_t sim_port_param_crc(void);

/** @return false if the app's queue of 10 is full */
bool sim_port_appchannel_push(const uint8_t *bytes, int size);
/** @return bytes of the oldest packet that the app sent, 0 if none */
int sim_port_appchannel_take(uint8_t *bytes);
/** @return characters of console text taken, at most SIM_PORT_CONSOLE_BYTES */
int sim_port_console_take(char *text);

#endif
