// SPDX-License-Identifier: GPL-3.0-or-later
/** @file toc.h  Table of contents, common to log variables and parameters.
 *
 *  Filled when the library is loaded, group by group in the order of their names.
 */
#ifndef TOC_H
#define TOC_H

#include <stdbool.h>
#include <stdint.h>

#include "sim_port.h"

enum { TOC_ENTRIES = 512, TOC_NAMES_MAX = 24 };

typedef struct {
  uint8_t type; ///< raw type byte, flags included
  const char *group;
  const char *name;
  const void *entry; ///< log_s or param_s
} toc_entry_t;

typedef struct {
  toc_entry_t entries[TOC_ENTRIES];
  const char *group; ///< group that is being added; 0 between groups
  int count;
  uint32_t crc; ///< content hash by which clients cache the table
} toc_t;

/** Add one entry; group starts (type 0x81) and stops (0x80) count as entries here. Breaking a rule
 *  of the firmware (name too long, table full) aborts: it is a mistake in the C source. */
void toc_add(toc_t *toc, uint8_t type, const char *name, const void *entry);
/** @return index of a variable; -1 if there is none */
int toc_find(const toc_t *toc, const char *group, const char *name);
bool toc_valid(const toc_t *toc, int id);
/** Fill type, group and name of *out, and leave the rest. */
void toc_describe(const toc_entry_t *entry, sim_port_entry_t *out);

#endif
