// SPDX-License-Identifier: GPL-3.0-or-later
/* The whole app by its radio link, parameters and sensors: packets of any bytes never stop it, and
 * whatever it answers can be read. The app starts once, as it does in a Crazyflie: what an input
 * finds also depends on those before it. */
#include "bytes.h"
#include "sim_port.h"
#include "wire.h"

static void boot_once(void) {
  static bool booted;
  if (!booted) {
    booted = true;
    sim_port_boot();
    sim_port_set_connected(true);
  }
}

static void read_answers(void) {
  uint8_t packet[SIM_PORT_APPCHANNEL_BYTES];
  char text[SIM_PORT_CONSOLE_BYTES];
  wire_message_t message;
  for (int length; (length = sim_port_appchannel_take(packet)) > 0;) {
    REQUIRE(wire_decode(packet, length, &message) == WIRE_OK);
  }
  while (sim_port_console_take(text) > 0) {
  }
  while (sim_port_take_param_update() >= 0) {
  }
}

static void push(bytes_t *bytes) {
  uint8_t packet[SIM_PORT_APPCHANNEL_BYTES];
  int size = take_below(bytes, SIM_PORT_APPCHANNEL_BYTES + 1);
  take(bytes, packet, (size_t)size);
  if (size > 0 && take_below(bytes, 4) != 0) {
    packet[0] = WIRE_VERSION;
  }
  sim_port_appchannel_push(packet, size);
}

static void write_parameter(bytes_t *bytes) {
  uint8_t value[4];
  int id = take_u8(bytes) % (sim_port_param_count() + 1);
  take(bytes, value, sizeof value);
  sim_port_param_write(id, value, 1 << take_below(bytes, 3));
}

static void feel(bytes_t *bytes) {
  sim_port_sensors_t sensors;
  memset(&sensors, 0, sizeof sensors);
  sensors.x_m = take_float(bytes, -3.0f, 3.0f);
  sensors.y_m = take_float(bytes, -3.0f, 3.0f);
  sensors.z_m = take_float(bytes, 0.0f, 1.0f);
  sensors.yaw_deg = take_float(bytes, -180.0f, 180.0f);
  sensors.battery_v = take_float(bytes, 3.0f, 4.2f);
  sensors.supervisor_info = take_u8(bytes);
  for (int i = 0; i < 5; i++) {
    sensors.range_mm[i] = (uint16_t)(take_u8(bytes) * 20);
  }
  sim_port_set_sensors(&sensors);
}

static void check_app(void) {
  sim_port_setpoint_t setpoint;
  REQUIRE(sim_port_alive());
  sim_port_get_setpoint(&setpoint);
  REQUIRE(isfinite(setpoint.vx_mps) && isfinite(setpoint.vy_mps) && isfinite(setpoint.z_m));
  REQUIRE(isfinite(setpoint.yaw_rate_dps));
  REQUIRE(hypotf(setpoint.vx_mps, setpoint.vy_mps) <= 1.001f);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  bytes_t bytes = {data, size};
  boot_once();
  while (bytes.left > 0) {
    switch (take_below(&bytes, 6)) {
    case 0:
      sim_port_set_tx_free(take_u8(&bytes));
      break;
    case 1:
      write_parameter(&bytes);
      break;
    case 2:
      feel(&bytes);
      break;
    case 3:
      sim_port_run(take_u8(&bytes));
      check_app();
      read_answers();
      break;
    default:
      push(&bytes);
      break;
    }
  }
  sim_port_run(40);
  check_app();
  read_answers();
  return 0;
}
