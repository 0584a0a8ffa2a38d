/* Included once by the port of a machine without a C library: the few functions that compilers call by
   themselves, short rather than fast (to be compiled with -fno-tree-loop-distribute-patterns, or gcc
   makes each of them a call of itself), and a stack whose high-water mark can be read. */
#ifndef BARE_H
#define BARE_H

#include <stddef.h>
#include <stdint.h>

void *memcpy(void *to, const void *from, size_t bytes);
void *memmove(void *to, const void *from, size_t bytes);
void *memset(void *to, int value, size_t bytes);

void *memcpy(void *to, const void *from, size_t bytes)
{
    unsigned char *t = (unsigned char *)to;
    const unsigned char *f = (const unsigned char *)from;
    while (bytes-- > 0) *t++ = *f++;
    return to;
}

void *memmove(void *to, const void *from, size_t bytes)
{
    unsigned char *t = (unsigned char *)to;
    const unsigned char *f = (const unsigned char *)from;
    if (t < f) return memcpy(to, from, bytes);
    while (bytes-- > 0) t[bytes] = f[bytes];
    return to;
}

void *memset(void *to, int value, size_t bytes)
{
    unsigned char *t = (unsigned char *)to;
    while (bytes-- > 0) *t++ = (unsigned char)value;
    return to;
}

/* The stack grows downwards from stack_top to stack_end; both come from the port. */
#define BARE_PAINT 0x5ac3a53cu

#if defined(__GNUC__)
#define BARE_UNUSED __attribute__((unused))
#else
#define BARE_UNUSED
#endif

BARE_UNUSED static void bare_paint(volatile uint32_t *end, const volatile uint32_t *now)
{
    while (end < now) *end++ = BARE_PAINT;
}

BARE_UNUSED static uint32_t bare_unpainted(const volatile uint32_t *end,
                                           const volatile uint32_t *top)
{
    while (end < top && *end == BARE_PAINT) end++;
    return (uint32_t)((uintptr_t)top - (uintptr_t)end);
}

#endif
