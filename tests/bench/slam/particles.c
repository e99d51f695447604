// SPDX-License-Identifier: GPL-3.0-or-later
#include "particles.h"

#include <math.h>
#include <string.h>

enum { FIRST_SETS = 5 };

static const float STEP_M = 0.03f; ///< a set is used when the body moved or turned this much
static const float STEP_RAD = 0.035f;
static const float MOVE_SD_M = 0.003f; ///< of a step, and per metre of it
static const float MOVE_SD_PER_M = 0.15f;
static const float TURN_SD_RAD = 0.003f; ///< of a step, per radian of it, per metre
static const float TURN_SD_PER_RAD = 0.05f;
static const float TURN_SD_RAD_PER_M = 0.03f;
static const double GAIN = 1.2; ///< of the score's exponent
static const float WALL_IN_THE_WAY = 0.3f;
static const float SHORT_OF_WALL_M = 0.2f;

/** Normal number of unit variance, nearly: twelve uniform ones. */
static float normal(rng_t *rng) {
  float sum = -6.0f;
  for (int i = 0; i < 12; i++) {
    sum += rng_uniform(rng);
  }
  return sum;
}

void particles_start(particles_t *filter, uint32_t seed) {
  memset(filter->particles, 0, sizeof filter->particles);
  for (int i = 0; i < PARTICLES; i++) {
    filter->particles[i].weight = 1.0 / PARTICLES;
  }
  filter->rng = rng_seed(seed);
  filter->odometry = (pose2_t){0};
  filter->sets = 0;
}

static void move(particles_t *filter, pose2_t step) {
  float length_m = vec2_norm(pose2_position(step));
  float sd_m = MOVE_SD_M + MOVE_SD_PER_M * length_m;
  float sd_rad = TURN_SD_RAD + TURN_SD_PER_RAD * fabsf(step.yaw_rad) + TURN_SD_RAD_PER_M * length_m;
  for (int i = 0; i < PARTICLES; i++) {
    pose2_t noisy = {step.x_m + sd_m * normal(&filter->rng), step.y_m + sd_m * normal(&filter->rng),
                     step.yaw_rad + sd_rad * normal(&filter->rng)};
    filter->particles[i].pose = pose2_compose(filter->particles[i].pose, noisy);
  }
}

static int value_at(const grid_t *grid, vec2_t point_m) {
  grid_cell_t cell;
  return grid_locate(grid, point_m, &cell) ? grid_value(grid, cell.ix, cell.iy) : GRID_UNKNOWN;
}

/** How well one beam fits: its end shall be occupied, what it passed shall not. */
static float beam_score(const grid_t *grid, pose2_t pose, int beam, float range_m, bool hit) {
  vec2_t along = vec2_rotate((vec2_t){1.0f, 0.0f}, pose.yaw_rad + scan_bearing_rad(beam));
  vec2_t from_m = pose2_position(pose);
  float score = 0.0f;
  for (float at_m = 0.1f; at_m < range_m - SHORT_OF_WALL_M; at_m += 2.0f * grid->cell_m) {
    if (value_at(grid, vec2_add(from_m, vec2_scale(along, at_m))) >= GRID_OCCUPIED_MIN) {
      score -= WALL_IN_THE_WAY;
    }
  }
  if (hit) {
    int value = value_at(grid, vec2_add(from_m, vec2_scale(along, range_m)));
    score += value >= GRID_OCCUPIED_MIN ? (float)(value - GRID_OCCUPIED_MIN + 1) * 0.125f
                                        : (value == GRID_UNKNOWN ? 0.0f : -0.5f);
  }
  return score;
}

static void weigh(particles_t *filter, const scan_frame_t *frame) {
  double total = 0.0;
  for (int i = 0; i < PARTICLES; i++) {
    particle_t *particle = &filter->particles[i];
    float score = 0.0f;
    for (int beam = 0; beam < SCAN_BEAMS; beam++) {
      bool hit = (frame->hit >> beam & 1) != 0;
      if (hit || (frame->clear >> beam & 1) != 0) {
        score += beam_score(&filter->drive.grid, particle->pose, beam, frame->range_m[beam], hit);
      }
    }
    particle->weight *= exp(GAIN * (double)score);
    total += particle->weight;
  }
  for (int i = 0; i < PARTICLES; i++) {
    filter->particles[i].weight /= total;
  }
}

/** Low-variance resampling, once the weights have become unequal. */
static void resample(particles_t *filter) {
  double squares = 0.0;
  for (int i = 0; i < PARTICLES; i++) {
    squares += filter->particles[i].weight * filter->particles[i].weight;
  }
  if (squares * PARTICLES < 2.0) {
    return;
  }
  particle_t old[PARTICLES];
  memcpy(old, filter->particles, sizeof old);
  double sum = old[0].weight;
  double mark = (double)rng_uniform(&filter->rng) / PARTICLES;
  for (int i = 0, from = 0; i < PARTICLES; i++, mark += 1.0 / PARTICLES) {
    while (mark > sum && from < PARTICLES - 1) {
      sum += old[++from].weight;
    }
    filter->particles[i] = (particle_t){old[from].pose, 1.0 / PARTICLES};
  }
}

/** Mean of all particles. */
static pose2_t mean(const particles_t *filter) {
  double x = 0.0;
  double y = 0.0;
  double c = 0.0;
  double s = 0.0;
  for (int i = 0; i < PARTICLES; i++) {
    const particle_t *particle = &filter->particles[i];
    x += particle->weight * (double)particle->pose.x_m;
    y += particle->weight * (double)particle->pose.y_m;
    c += particle->weight * cos((double)particle->pose.yaw_rad);
    s += particle->weight * sin((double)particle->pose.yaw_rad);
  }
  return (pose2_t){(float)x, (float)y, (float)atan2(s, c)};
}

static void take_set(particles_t *filter, const scan_frame_t *frame) {
  pose2_t step = pose2_compose(pose2_inverse(filter->odometry), frame->pose);
  bool first = filter->sets == 0;
  bool moved = vec2_norm(pose2_position(step)) > STEP_M || fabsf(step.yaw_rad) > STEP_RAD;
  if (!first && !moved) {
    return;
  }
  move(filter, step);
  filter->odometry = frame->pose;
  if (filter->sets >= FIRST_SETS) {
    weigh(filter, frame);
    resample(filter);
  }
  filter->sets++;
  grid_insert(&filter->drive.grid, frame, mean(filter));
}

void particles_fly(particles_t *filter, const float *poses, const float *ranges_m, int ticks,
                   uint32_t tick_ms, drive_said_t *said) {
  pose2_t believed = {0};
  for (int i = 0; i < ticks; i++) {
    scan_odometry_t odometry = drive_odometry(&poses[3 * i], (uint32_t)i * tick_ms);
    scan_frame_t frame;
    if (scan_step(&filter->drive.scan, &odometry, &ranges_m[SCAN_RANGES * i], &frame)) {
      take_set(filter, &frame);
      believed = mean(filter);
    }
    pose2_t since = pose2_compose(pose2_inverse(filter->odometry), odometry.pose);
    said[i] = (drive_said_t){.pose = pose2_compose(believed, since)};
  }
}
