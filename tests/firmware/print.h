/* Numbers, without printf. */
#ifndef PRINT_H
#define PRINT_H

#include "port.h"

static void print_number(uint32_t value, uint32_t base, int digits)
{
    char text[33];
    int at = 32;
    text[at] = 0;
    do {
        text[--at] = "0123456789abcdef"[value % base];
        value /= base;
        digits--;
    } while (value > 0 || digits > 0);
    port_write(text + at);
}

/* " name=value" */
static void print_field(const char *name, uint32_t value)
{
    port_write(" ");
    port_write(name);
    port_write("=");
    print_number(value, 10, 1);
}

#endif
