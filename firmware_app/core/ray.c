// SPDX-License-Identifier: GPL-3.0-or-later
#pragma GCC optimize("fp-contract=off")
#include "ray.h"

#include <math.h>

static int whole_steps(int from, int to) {
  return to > from ? to - from : from - to;
}

ray_t ray_start(vec2_t a_cells, vec2_t b_cells) {
  float cell_x = floorf(a_cells.x);
  float cell_y = floorf(a_cells.y);
  float dx = b_cells.x - a_cells.x;
  float dy = b_cells.y - a_cells.y;
  ray_t ray = {
      .ix = (int)cell_x,
      .iy = (int)cell_y,
      .step_x = dx > 0.0f ? 1 : -1,
      .step_y = dy > 0.0f ? 1 : -1,
      .dt_x = fabsf(dy),
      .dt_y = fabsf(dx),
  };
  ray.left_x = whole_steps(ray.ix, (int)floorf(b_cells.x));
  ray.left_y = whole_steps(ray.iy, (int)floorf(b_cells.y));
  float to_side_x = dx > 0.0f ? cell_x + 1.0f - a_cells.x : a_cells.x - cell_x;
  float to_side_y = dy > 0.0f ? cell_y + 1.0f - a_cells.y : a_cells.y - cell_y;
  ray.t_x = to_side_x * ray.dt_x;
  ray.t_y = to_side_y * ray.dt_y;
  return ray;
}

bool ray_next(ray_t *ray) {
  if (ray->left_x == 0 && ray->left_y == 0) {
    return false;
  }
  bool go_x = ray->left_y == 0 || (ray->left_x != 0 && ray->t_x <= ray->t_y);
  bool go_y = ray->left_x == 0 || (ray->left_y != 0 && ray->t_y <= ray->t_x);
  if (go_x) {
    ray->ix += ray->step_x;
    ray->t_x += ray->dt_x;
    ray->left_x--;
  }
  if (go_y) {
    ray->iy += ray->step_y;
    ray->t_y += ray->dt_y;
    ray->left_y--;
  }
  ray->corner = go_x && go_y;
  return true;
}
