// SPDX-License-Identifier: GPL-3.0-or-later
/** @file particles.h  The classic way, to compare with: a particle filter over poses that scores
 * every set by its correlation with the occupancy grid (as CrazySLAM does; Thrun, Burgard, Fox,
 * Probabilistic Robotics, tables 4.3 and 8.3). Cells that a beam passed count too, and the motion's
 * noise grows with the motion. On this machine only. */
#ifndef PARTICLES_H
#define PARTICLES_H

#include "drive.h"
#include "rng.h"

enum { PARTICLES = 300 };

typedef struct {
  pose2_t pose; ///< map frame, at the newest set used
  double weight;
} particle_t;

typedef struct {
  drive_t drive; ///< its scan and grid; SLAM stays unused
  particle_t particles[PARTICLES];
  rng_t rng;
  pose2_t odometry; ///< at the newest set used
  int sets;
} particles_t;

/** After drive_start. */
void particles_start(particles_t *filter, uint32_t seed);
/** As drive_fly. */
void particles_fly(particles_t *filter, const float *poses, const float *ranges_m, int ticks,
                   uint32_t tick_ms, drive_said_t *said);

#endif
