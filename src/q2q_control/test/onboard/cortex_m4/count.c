/* Instructions of one step of the app on a Cortex-M4, for columns of Q2Q_NEIGHBOURS vehicles above this one.

   Under qemu-system-arm -M mps2-an386 -icount shift=0 an instruction takes 1 ns, and SysTick counts at 25 MHz:
   40 instructions. Columns have spacings of 0.05 to 0.3 m, and are flown for 1 s each; every broadcast is 5 cm and
   0.5 m/s aside at random, and vehicles take turns. Prints the mean and the largest number of all columns, then both
   without neighbours, and both of the column of 0.2 m, by semihosting. */
#include "q2q_app.h"

#define SYSTICK ((volatile uint32_t *)0xE000E010) /* control, reload, current value */
#define CPACR (*(volatile uint32_t *)0xE000ED88)
#define INSTRUCTIONS_PER_COUNT 40u
#define STEPS 500 /* 1 s at 500 Hz */
#define COLUMNS 6

extern uint32_t stack_top;
void reset(void);
__attribute__((section(".vectors"), used)) static const void *const vectors[2] = {&stack_top, (const void *)reset};

static struct q2q_app app;
static uint32_t drawn = 1;

static int semihosting(int operation, const void *argument) {
  register int r0 __asm__("r0") = operation;
  register const void *r1 __asm__("r1") = argument;
  __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
  return r0;
}

/* Return a random number of -size to size. */
static float scattered(float size) {
  drawn = 1664525u * drawn + 1013904223u; /* Numerical Recipes */
  return size * ((float)(drawn >> 8) * 0x1p-23f - 1.0f);
}

static struct q2q_motion broadcast(float height) {
  const struct q2q_motion motion = {{scattered(0.05f), scattered(0.05f), height},
                                    {scattered(0.5f), scattered(0.5f), scattered(0.5f)},
                                    {0.1f, 0.0f, 0.995f}};
  return motion;
}

static void print(uint32_t number) {
  char text[12] = {0}, *at = text + 10;
  *at = '\n';
  do *--at = (char)('0' + number % 10u);
  while ((number /= 10u) != 0u);
  semihosting(4, at); /* SYS_WRITE0 */
}

struct cost {
  uint32_t total, largest; /* [SysTick counts] */
};

/* Fly one column, and add its steps to the cost. */
static void fly(int neighbours, float spacing, struct cost *cost) {
  uint32_t now_us = 0;
  q2q_reset(&app);
  for (int step = 0; step < STEPS; ++step, now_us += 2000u) {
    const struct q2q_input input = {now_us, {{0.0f, 0.0f, 1.0f}, {0.1f, 0.0f, 0.0f}, {0.1f, 0.0f, 0.995f}}, 9.0f, 9.81f, true};
    for (int k = 1; k <= neighbours; ++k) {
      if ((step + 2 * k) % 10 != 0) continue;
      const struct q2q_motion motion = broadcast(1.0f + spacing * (float)k);
      q2q_hear(&app, (uint8_t)k, now_us - 2000u, &motion);
    }
    const uint32_t before = SYSTICK[2];
    q2q_step(&app, &input);
    const uint32_t counts = (before - SYSTICK[2]) & 0xFFFFFFu;
    cost->total += counts;
    if (counts > cost->largest) cost->largest = counts;
  }
}

/* Print the mean and the largest number of instructions of a step in columns first to last. */
static void measure(int neighbours, int first, int last) {
  struct cost cost = {0, 0};
  for (int k = first; k <= last; ++k) fly(neighbours, 0.05f * (float)k, &cost);
  print(cost.total * INSTRUCTIONS_PER_COUNT / ((uint32_t)(last - first + 1) * STEPS));
  print(cost.largest * INSTRUCTIONS_PER_COUNT);
}

void reset(void) {
  CPACR |= 0xFu << 20; /* floating point unit on */
  __asm__ volatile("dsb\nisb");
  SYSTICK[1] = 0xFFFFFFu;
  SYSTICK[2] = 0u;
  SYSTICK[0] = 5u; /* on, processor clock */
  measure(Q2Q_NEIGHBOURS, 1, COLUMNS);
  measure(0, 1, COLUMNS);
  measure(Q2Q_NEIGHBOURS, 4, 4);
  semihosting(0x18, (const void *)0x20026); /* SYS_EXIT, application exit */
  for (;;) {
  }
}
