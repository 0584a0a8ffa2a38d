/* Linux on x86-64 without its C library: a stack of our own, and two system calls. */
#include "port.h"
#include "bare.h"

__attribute__((used)) static uint32_t stack[32768] __attribute__((aligned(16)));

static long call(long number, long a, long b, long c)
{
    long result;
    __asm__ volatile("syscall"
                     : "=a"(result)
                     : "a"(number), "D"(a), "S"(b), "d"(c)
                     : "rcx", "r11", "memory");
    return result;
}

void port_write(const char *text)
{
    long n = 0;
    while (text[n]) n++;
    call(1, 1, (long)text, n);
}

uint32_t port_stack_used(void)
{
    return bare_unpainted(stack, stack + sizeof stack / sizeof stack[0]);
}

uint32_t port_instructions(void) { return 0; }

void start(void);
__attribute__((used)) void start(void)
{
    uintptr_t here;
    __asm__ volatile("mov %%rsp, %0" : "=r"(here));
    bare_paint(stack, (const volatile uint32_t *)here);
    call(60, port_main(), 0, 0);
}

__asm__(".globl _start\n"
        "_start:\n"
        "    lea stack+131072(%rip), %rsp\n"
        "    call start\n");
