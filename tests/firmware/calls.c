// SPDX-License-Identifier: GPL-3.0-or-later
/* Recorded calls of sim_port.h: each is made again, and what came of it is written. The app runs
 * behind them in a task of its own, as on the drone. See calls.py. */
#include <string.h>

#include "coroutine_chip.h"
#include "port.h"
#include "sim_port.h"

enum { SENSORS_BYTES = 176, VALUES_BYTES = 64, VARIABLES_MAX = 32 };

_Static_assert(sizeof(sim_port_sensors_t) == SENSORS_BYTES, "read as it lies in memory");

static uint8_t bytes[VALUES_BYTES]; ///< of the call being made

static uint32_t get(size_t size) {
  uint32_t value = 0;
  port_read(&value, size);
  return value;
}

static void put(uint32_t value, size_t size) {
  port_write(&value, size);
}

static void put_sized(int size) {
  put((uint32_t)size, 1);
  port_write(bytes, (size_t)size);
}

static int get_sized(void) {
  const uint32_t size = get(1);
  port_read(bytes, size);
  return (int)size;
}

static void set_sensors(void) {
  sim_port_sensors_t sensors;
  port_read(&sensors, sizeof sensors);
  sim_port_set_sensors(&sensors);
}

/** Without what lies between the fields. */
static void get_setpoint(void) {
  sim_port_setpoint_t s;
  sim_port_get_setpoint(&s);
  const uint8_t modes[] = {s.mode_x,     s.mode_y,   s.mode_z,       s.mode_roll,
                           s.mode_pitch, s.mode_yaw, s.velocity_body};
  const float numbers[] = {s.x_m,      s.y_m,       s.z_m,     s.vx_mps,       s.vy_mps, s.vz_mps,
                           s.roll_deg, s.pitch_deg, s.yaw_deg, s.yaw_rate_dps, s.thrust};
  port_write(modes, sizeof modes);
  port_write(numbers, sizeof numbers);
  put(s.age_ms, 4);
  put(s.priority, 1);
}

static void put_setpoint(void) {
  sim_port_setpoint_t s = {0};
  uint8_t modes[7];
  port_read(modes, sizeof modes);
  s.mode_x = modes[0], s.mode_y = modes[1], s.mode_z = modes[2];
  s.mode_roll = modes[3], s.mode_pitch = modes[4], s.mode_yaw = modes[5];
  s.velocity_body = modes[6] != 0;
  float *const numbers[] = {&s.x_m,     &s.y_m,          &s.z_m,      &s.vx_mps,
                            &s.vy_mps,  &s.vz_mps,       &s.roll_deg, &s.pitch_deg,
                            &s.yaw_deg, &s.yaw_rate_dps, &s.thrust};
  for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++) {
    port_read(numbers[i], sizeof(float));
  }
  put(sim_port_put_setpoint(&s, (int)get(1)), 1);
}

static void take_measurement(void) {
  sim_port_measurement_t m = {0};
  put(sim_port_take_measurement(&m), 1);
  const float numbers[] = {m.x_m, m.y_m, m.z_m, m.yaw_error_rad, m.sd};
  put(m.of_yaw, 1);
  port_write(numbers, sizeof numbers);
}

static void write_param(int (*write)(int id, const uint8_t *value, int size)) {
  const int id = (int)get(2);
  put((uint32_t)write(id, bytes, get_sized()), 1);
}

static void read_log_block(void) {
  uint16_t ids[VARIABLES_MAX];
  uint8_t types[VARIABLES_MAX];
  const uint32_t time_ms = get(4);
  const uint32_t count = get(1);
  port_read(ids, count * sizeof ids[0]);
  port_read(types, count);
  put_sized(sim_port_log_read_block(ids, types, (int)count, time_ms, bytes));
}

static void push_packet(void) {
  const int size = get_sized();
  put(sim_port_appchannel_push(bytes, size), 1);
}

/** What the app is told. */
static bool input(char call) {
  switch (call) {
  case 's':
    set_sensors();
    return true;
  case 'c':
    sim_port_set_connected(get(1) != 0);
    return true;
  case 'f':
    sim_port_set_tx_free((int)get(1));
    return true;
  case 'w':
    write_param(sim_port_param_write);
    return true;
  case 'e':
    write_param(sim_port_param_force);
    return true;
  case 'a':
    push_packet();
    return true;
  case 'p':
    put_setpoint();
    return true;
  case 'x':
    sim_port_relax_priority();
    return true;
  default:
    return false;
  }
}

/** What the app says. */
static bool output(char call) {
  switch (call) {
  case 'S':
    get_setpoint();
    return true;
  case 'I':
    put((uint32_t)sim_port_active_priority(), 1);
    return true;
  case 'R':
    put((uint32_t)sim_port_take_arming_request(), 1);
    return true;
  case 'M':
    take_measurement();
    return true;
  case 'L':
    read_log_block();
    return true;
  case 'P':
    put_sized(sim_port_param_read((int)get(2), bytes));
    return true;
  case 'U':
    put((uint32_t)sim_port_take_param_update(), 4);
    return true;
  case 'A':
    put_sized(sim_port_appchannel_take(bytes));
    return true;
  case 'C':
    put_sized(sim_port_console_take((char *)bytes));
    return true;
  case 'V':
    put(sim_port_alive(), 1);
    return true;
  case 'T':
    put(sim_port_log_crc(), 4);
    put(sim_port_param_crc(), 4);
    return true;
  default:
    return false;
  }
}

void port_main(void) {
  char call;
  while (port_read(&call, sizeof call)) {
    put((uint8_t)call, 1);
    if (call == 'b') {
      sim_port_boot();
    } else if (call == 'r') {
      sim_port_run(get(4));
    } else if (call == 'z') {
      sim_port_stall(get(4));
    } else if (!input(call) && !output(call)) {
      return;
    }
  }
  put(coroutine_stack_used(), 4);
}
