// SPDX-License-Identifier: GPL-3.0-or-later
/** @file model.h  Read before each file that is proven: a form of fabsf from which Frama-C learns
 * about its argument. */
#ifndef MODEL_H
#define MODEL_H

#include <math.h>

#define fabsf(x) ((x) < 0.0f ? -(x) : (x))

#endif
