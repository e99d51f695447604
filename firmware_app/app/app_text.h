// SPDX-License-Identifier: GPL-3.0-or-later
/** @file app_text.h  Texts for the console. */
#ifndef APP_TEXT_H
#define APP_TEXT_H

#include "mission.h"

/** Text for a reason; never NULL. */
const char *app_reason_text(mission_reason_t reason);

#endif
