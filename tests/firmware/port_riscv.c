/* A RISC-V machine without anything (laid out for qemu's "virt" board): startup, semihosting. */
#include "port.h"
#include "bare.h"

/* from riscv.ld */
extern uint32_t bss_begin[], bss_end[], stack_end[], stack_top[];

enum { SYS_WRITE0 = 0x04, SYS_EXIT_EXTENDED = 0x20, APPLICATION_EXIT = 0x20026 };

/* the three instructions must be uncompressed and on one page */
static void semihost(uintptr_t operation, const void *argument)
{
    register uintptr_t a0 __asm__("a0") = operation;
    register const void *a1 __asm__("a1") = argument;
    __asm__ volatile(".option push\n .option norvc\n .balign 16\n"
                     "slli zero, zero, 0x1f\n ebreak\n srai zero, zero, 7\n .option pop"
                     : "+r"(a0)
                     : "r"(a1)
                     : "memory");
}

void port_write(const char *text) { semihost(SYS_WRITE0, text); }

uint32_t port_stack_used(void) { return bare_unpainted(stack_end, stack_top); }

uint32_t port_instructions(void)
{
    static uintptr_t last;
    uintptr_t now, count;
    __asm__ volatile("csrr %0, minstret" : "=r"(now));
    count = now - last;
    last = now;
    return (uint32_t)count;
}

void start(void);
void start(void)
{
    volatile uint32_t *to;
    uintptr_t here, block[2];
    for (to = bss_begin; to < bss_end;) *to++ = 0;
    __asm__ volatile("mv %0, sp" : "=r"(here));
    bare_paint(stack_end, (const volatile uint32_t *)here);
    block[0] = APPLICATION_EXIT;
    block[1] = (uintptr_t)port_main();
    semihost(SYS_EXIT_EXTENDED, block);
    for (;;) {
    }
}

/* the floating-point unit on (mstatus.FS), the stack, the global pointer */
__asm__(".section .vectors, \"ax\"\n"
        ".globl entry\n"
        "entry:\n"
        "    li t0, 0x2000\n"
        "    csrs mstatus, t0\n"
        "    .option push\n"
        "    .option norelax\n"
        "    la gp, __global_pointer$\n"
        "    .option pop\n"
        "    la sp, stack_top\n"
        "    j start\n"
        ".text\n");
