// SPDX-License-Identifier: GPL-3.0-or-later
/* Start of the chip, and bytes in and out through break points that the emulator answers. */
#include <stdint.h>
#include <string.h>

#include "port.h"

enum { BUFFER_BYTES = 24 * 1024, CALL_READ = 1, CALL_WRITE = 2, CALL_EXIT = 3 };

extern uint32_t chip_stack_top[];
extern uint32_t chip_data[], chip_data_end[], chip_data_image[], chip_bss[], chip_bss_end[];
extern void (*const chip_constructors[])(void);
extern void (*const chip_constructors_end[])(void);

/** In the memory that no DMA reaches and the core does not use. */
__attribute__((section(".ccm"))) static uint8_t in[BUFFER_BYTES];
__attribute__((section(".ccm"))) static uint8_t out[BUFFER_BYTES];
static size_t in_first, in_count, out_count;

static size_t call(uint32_t what, void *bytes, size_t size) {
  register uint32_t r0 __asm__("r0") = what;
  register void *r1 __asm__("r1") = bytes;
  register size_t r2 __asm__("r2") = size;
  __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1), "r"(r2) : "memory");
  return r0;
}

static void flush(void) {
  call(CALL_WRITE, out, out_count);
  out_count = 0;
}

bool port_read(void *bytes, size_t size) {
  if (in_count < size) {
    memmove(in, &in[in_first], in_count);
    in_first = 0;
    in_count += call(CALL_READ, &in[in_count], BUFFER_BYTES - in_count);
  }
  if (in_count < size) {
    return false;
  }
  memcpy(bytes, &in[in_first], size);
  in_first += size;
  in_count -= size;
  return true;
}

void port_write(const void *bytes, size_t size) {
  if (out_count + size > BUFFER_BYTES) {
    flush();
  }
  memcpy(&out[out_count], bytes, size);
  out_count += size;
}

/** The end, of abort() too. */
__attribute__((noreturn)) void _exit(int status) {
  (void)status;
  flush();
  call(CALL_EXIT, 0, 0);
  for (;;) {
  }
}

/** As a C library's start: variables, the floating-point unit, constructors. */
__attribute__((noreturn)) void chip_reset(void) {
  *(volatile uint32_t *)0xE000ED88 |= 0xFu << 20; // CPACR: full access to the FPU
  __asm__ volatile("dsb\n isb");
  const uint32_t *from = chip_data_image;
  for (uint32_t *to = chip_data; to < chip_data_end; to++) {
    *to = *from++;
  }
  for (uint32_t *to = chip_bss; to < chip_bss_end; to++) {
    *to = 0;
  }
  for (void (*const *make)(void) = chip_constructors; make < chip_constructors_end; make++) {
    (*make)();
  }
  port_main();
  _exit(0);
}

__attribute__((section(".vectors"), used)) static const void *const vectors[] = {
    chip_stack_top,
    (const void *)chip_reset,
};
