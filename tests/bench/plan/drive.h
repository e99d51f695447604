// SPDX-License-Identifier: GPL-3.0-or-later
/** @file drive.h  What all drivers of the planning bench share: problems in, one row of figures per
 * problem out, one clock. */
#ifndef DRIVE_H
#define DRIVE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { DRIVE_SIDE = 128, DRIVE_CELLS = DRIVE_SIDE * DRIVE_SIDE, DRIVE_WAY_POINTS = 4096 };

/** As the problem file holds it; positions and lengths in cells. */
typedef struct {
  double optimum; ///< -1: there is no way
  double start[2], goal[2];
  uint8_t raw[DRIVE_CELLS];     ///< obstacles
  uint8_t blocked[DRIVE_CELLS]; ///< the same, made wider by the drone
} drive_problem_t;

/** The improvements of one run. Times are CPU seconds of this thread since drive_begin, without
 * what was spent in verification. */
typedef struct {
  const drive_problem_t *problem;
  double began_s, unpaid_s;
  double cost; ///< best so far, verified where the planner gives its way
  double first_s, within_105_s, within_102_s, end_s;
  double first_cost;
  double enough_s, enough_cost; ///< when a planner would stop by itself
  double fixed_cost;            ///< best after the number of samples that the bench fixes
  double flown_cost; ///< length of the route made of that way, where the planner makes one
  double clearance;  ///< least distance of the final way to an obstacle, cells
  long nodes_105, nodes_end;
  long bytes_105, bytes_end;
  long samples;
  int invalid; ///< ways that broke a rule
} drive_run_t;

/** All problems of a file; ends the process if it cannot be read. */
drive_problem_t *drive_read(const char *path, int *count);

void drive_begin(drive_run_t *run, const drive_problem_t *problem);
/** CPU seconds that count. */
double drive_time_s(const drive_run_t *run);
/** Time spent in here is not counted up to drive_resume(). @return the time at which it stopped */
double drive_pause(drive_run_t *run);
void drive_resume(drive_run_t *run, double paused_s);
/** A better cost was reached at this time. @return true if it was the first to be within 1.05 */
bool drive_note(drive_run_t *run, double time_s, double cost);
/** Length of a way from start to goal; -1 and one more invalid way if it is not one. shrink as in
 * exact.h. */
double drive_verify(drive_run_t *run, const double *xy_cells, int count, int64_t shrink);
/** Take the clearance of the way that the run ends with. */
void drive_finish(drive_run_t *run, const double *xy_cells, int count);

void drive_print_header(void);
void drive_print(int problem, const drive_run_t *run);

#ifdef __cplusplus
}
#endif

#endif
