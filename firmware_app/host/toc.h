// SPDX-License-Identifier: GPL-3.0-or-later
/** @file toc.h  A table of contents: what the log and the parameter tables have in common.
 *  Filled when the library is loaded, group by group in the order of their names. */
#ifndef TOC_H
#define TOC_H

#include <stdbool.h>
#include <stdint.h>

#include "sim_port.h"

enum { TOC_ENTRIES = 512, TOC_NAMES_MAX = 24 };

typedef struct {
  uint8_t type; ///< raw, with flags
  const char *group;
  const char *name;
  const void *entry; ///< of the table itself
} toc_entry_t;

typedef struct {
  toc_entry_t entries[TOC_ENTRIES];
  const char *group; ///< that is being added, 0 between two groups
  int count;
  uint32_t crc;
} toc_t;

/** Add one table entry, group starts (type 0x81) and stops (0x80) included. Breaking a rule of the
 *  firmware (names too long, table full) ends the program: it is a mistake in the C source. */
void toc_add(toc_t *toc, uint8_t type, const char *name, const void *entry);
/** @return index, -1 if there is none */
int toc_find(const toc_t *toc, const char *group, const char *name);
bool toc_valid(const toc_t *toc, int id);
/** type, group and name of *out; the rest is left alone. */
void toc_describe(const toc_entry_t *entry, sim_port_entry_t *out);

#endif
