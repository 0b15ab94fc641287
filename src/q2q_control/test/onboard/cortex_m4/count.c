/* Instructions of one step of the app on a Cortex-M4, for a column of Q2Q_NEIGHBOURS vehicles above this one.

   Under qemu-system-arm -M mps2-an386 -icount shift=0 an instruction takes 1 ns, and SysTick counts at 25 MHz:
   40 instructions. Prints their mean and their largest number over 1 s, then both without neighbours, by semihosting. */
#include "q2q_app.h"

#define SYSTICK ((volatile uint32_t *)0xE000E010) /* control, reload, current value */
#define CPACR (*(volatile uint32_t *)0xE000ED88)
#define INSTRUCTIONS_PER_COUNT 40u
#define STEPS 500 /* 1 s at 500 Hz */

extern uint32_t stack_top;
void reset(void);
__attribute__((section(".vectors"), used)) static const void *const vectors[2] = {&stack_top, (const void *)reset};

static struct q2q_app app;

static int semihosting(int operation, const void *argument) {
  register int r0 __asm__("r0") = operation;
  register const void *r1 __asm__("r1") = argument;
  __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
  return r0;
}

static struct q2q_motion hovering(int k) {
  const struct q2q_motion motion = {{0.01f * (float)k, 0.0f, 1.0f + 0.2f * (float)k}, {0.1f, 0.0f, 0.0f}, {0.1f, 0.0f, 0.995f}};
  return motion;
}

static void print(uint32_t number) {
  char text[12] = {0}, *at = text + 10;
  *at = '\n';
  do *--at = (char)('0' + number % 10u);
  while ((number /= 10u) != 0u);
  semihosting(4, at); /* SYS_WRITE0 */
}

/* Print the mean and the largest number of instructions of a step. */
static void measure(int neighbours) {
  uint32_t total = 0, largest = 0, now_us = 0;
  q2q_reset(&app);
  for (int step = 0; step < STEPS; ++step, now_us += 2000u) {
    const struct q2q_input input = {now_us, hovering(0), 9.0f, 9.81f, true};
    for (int k = 1; k <= neighbours; ++k) {
      const struct q2q_motion motion = hovering(k);
      if (step % 10 == 0) q2q_hear(&app, (uint8_t)k, now_us - 2000u, &motion);
    }
    const uint32_t before = SYSTICK[2];
    q2q_step(&app, &input);
    const uint32_t counts = (before - SYSTICK[2]) & 0xFFFFFFu;
    total += counts;
    if (counts > largest) largest = counts;
  }
  print(total * INSTRUCTIONS_PER_COUNT / STEPS);
  print(largest * INSTRUCTIONS_PER_COUNT);
}

void reset(void) {
  CPACR |= 0xFu << 20; /* floating point unit on */
  __asm__ volatile("dsb\nisb");
  SYSTICK[1] = 0xFFFFFFu;
  SYSTICK[2] = 0u;
  SYSTICK[0] = 5u; /* on, processor clock */
  measure(Q2Q_NEIGHBOURS);
  measure(0);
  semihosting(0x18, (const void *)0x20026); /* SYS_EXIT, application exit */
  for (;;) {
  }
}
