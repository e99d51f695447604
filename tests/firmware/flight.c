// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
/* A recorded flight through nav_step: records in, every output out. See records.py. */
#include "bits.h"
#include "nav.h"
#include "port.h"

enum { RECORD_INIT = 'I', RECORD_TICK = 'T', RECORD_COMMAND = 'C', RECORD_HASH = 'H' };

static nav_t nav;

static void init(void) {
  nav_config_t cfg;
  nav_config_default(&cfg);
  cfg.area_min_m = bits_get_vec2();
  cfg.area_max_m = bits_get_vec2();
  cfg.cell_m = bits_get_float();
  cfg.clearance_m = bits_get_float();
  cfg.seed = bits_get_u32();
  cfg.planner = (nav_planner_t)bits_get_u8();
  cfg.slam = (nav_slam_mode_t)bits_get_u8();
  cfg.follower.yaw_mode = (follower_yaw_mode_t)bits_get_u8();
  bits_put_u8((uint8_t)nav_config_check(&cfg));
  nav_init(&nav, &cfg);
}

static void command(void) {
  nav_command_t order;
  order.cmd = (mission_cmd_t)bits_get_u8();
  order.goal_m = bits_get_vec2();
  bits_put_u8((uint8_t)nav_command(&nav, &order));
}

static void read_input(nav_input_t *input) {
  input->odometry.time_ms = bits_get_u32();
  input->odometry.pose.x_m = bits_get_float();
  input->odometry.pose.y_m = bits_get_float();
  input->odometry.pose.yaw_rad = bits_get_float();
  input->odometry.height_m = bits_get_float();
  input->odometry.roll_rad = bits_get_float();
  input->odometry.pitch_rad = bits_get_float();
  input->velocity_mps = bits_get_vec2();
  input->yaw_rate_rps = bits_get_float();
  for (int beam = 0; beam < SCAN_RANGES; beam++) {
    input->range_m[beam] = bits_get_float();
  }
  input->battery_v = bits_get_float();
  input->flags = bits_get_u8();
  input->positioning = bits_get_u8();
}

static void write_setpoint(const nav_setpoint_t *setpoint) {
  bits_put_u8(setpoint->motors);
  if (setpoint->motors) { // else the rest means nothing
    bits_put_float(setpoint->height_m);
    bits_put_vec2(setpoint->velocity_body_mps);
    bits_put_float(setpoint->yaw_rate_rps);
  }
}

static void write_status(const nav_status_t *status) {
  bits_put_pose(status->pose);
  bits_put_vec2(status->goal_m);
  bits_put_float(status->path_m);
  bits_put_u32(status->known_cells);
  bits_put_u32(status->plan_nodes);
  bits_put_u8(status->confidence);
  bits_put_u8(status->state);
  bits_put_u8(status->fault);
  bits_put_u8(status->task);
}

static void write_events(void) {
  wire_event_t event;
  bits_put_u8(nav.event_count);
  while (nav_take_event(&nav, &event)) {
    bits_put_u32(event.sequence);
    bits_put_u32(event.time_ms);
    bits_put_u8(event.code);
    bits_put_u8(event.argument);
    bits_put_vec2(event.place_m);
  }
}

static void tick(void) {
  nav_input_t input;
  uint8_t piece[WIRE_MAP_BYTES];
  read_input(&input);
  nav_setpoint_t setpoint = nav_step(&nav, &input);
  nav_next_map_piece(&nav, piece);
  write_setpoint(&setpoint);
  write_status(&nav.status);
  write_events();
  port_write(piece, sizeof piece);
}

void port_main(void) {
  uint8_t record;
  while (port_read(&record, sizeof record)) {
    bits_put_u8(record);
    switch (record) {
    case RECORD_INIT:
      init();
      break;
    case RECORD_TICK:
      tick();
      break;
    case RECORD_COMMAND:
      command();
      break;
    case RECORD_HASH:
      bits_put_u32(bits_hash_nav(&nav));
      break;
    default:
      return;
    }
  }
}
