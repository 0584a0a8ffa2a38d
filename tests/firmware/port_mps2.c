/* An Arm MPS2 board with a Cortex-M4F (qemu-system-arm -M mps2-an386): vectors, startup, output by
   semihosting. Instructions are counted by SysTick, which qemu drives at 25 MHz of a clock that
   -icount shift=0 advances by 1 ns each instruction. */
#include "port.h"
#include "bare.h"

/* from mps2.ld */
extern uint32_t data_begin[], data_end[], data_from[], bss_begin[], bss_end[];
extern uint32_t stack_end[], stack_top[];

#define SYSTICK ((volatile uint32_t *)0xe000e010u) /* control, reload, value */
#define CPACR (*(volatile uint32_t *)0xe000ed88u)

enum { SYS_WRITE0 = 0x04, SYS_EXIT_EXTENDED = 0x20, APPLICATION_EXIT = 0x20026 };

static void semihost(uint32_t operation, const void *argument)
{
    register uint32_t r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
}

void port_write(const char *text) { semihost(SYS_WRITE0, text); }

uint32_t port_stack_used(void) { return bare_unpainted(stack_end, stack_top); }

uint32_t port_instructions(void)
{
    static uint32_t last;
    uint32_t now = SYSTICK[2], ticks = (last - now) & 0xffffffu; /* it counts down */
    last = now;
    return ticks * 40u;
}

static void stop(uint32_t status)
{
    uint32_t block[2];
    block[0] = APPLICATION_EXIT;
    block[1] = status;
    semihost(SYS_EXIT_EXTENDED, block);
    for (;;) {
    }
}

void reset(void);
void reset(void)
{
    volatile uint32_t *to = data_begin;
    const uint32_t *from = data_from;
    uint32_t here;
    while (to < data_end) *to++ = *from++;
    for (to = bss_begin; to < bss_end;) *to++ = 0;
    CPACR |= 0xfu << 20; /* the floating-point unit: full access */
    __asm__ volatile("dsb\n isb" ::: "memory");
    SYSTICK[1] = 0xffffffu;
    SYSTICK[2] = 0;
    SYSTICK[0] = 5; /* on, processor clock, no interrupt */
    __asm__ volatile("mov %0, sp" : "=r"(here));
    bare_paint(stack_end, (const volatile uint32_t *)here);
    stop((uint32_t)port_main());
}

/* any exception is an error of the program */
static void fault(void) { stop(255); }

__attribute__((section(".vectors"), used)) static const struct vectors {
    uint32_t *stack;
    void (*handler[15])(void);
} vectors = {stack_top,
             {reset, fault, fault, fault, fault, fault, fault, fault, fault, fault, fault, fault,
              fault, fault, fault}};
