/* What the programs of this directory need of the machine they run on. One file port_*.c each: a
   Cortex-M4F under qemu, a RISC-V board, Linux on x86-64 without its C library, and any machine with
   a C library. */
#ifndef PORT_H
#define PORT_H

#include <stdint.h>

/* shows a text that ends in a zero byte */
void port_write(const char *text);

/* the most bytes of stack that were in use since the start; 0 where nobody counts */
uint32_t port_stack_used(void);

/* instructions since the last call, if they were less than 600 million; 0 where nobody counts */
uint32_t port_instructions(void);

/* The program, called once by the port; returns 0 if all went well. */
int port_main(void);

#endif
