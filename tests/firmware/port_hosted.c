/* Any machine with a C library. */
#include "port.h"

#include <stdio.h>

void port_write(const char *text) { fputs(text, stdout); }
uint32_t port_stack_used(void) { return 0; }
uint32_t port_instructions(void) { return 0; }

int main(void) { return port_main(); }
