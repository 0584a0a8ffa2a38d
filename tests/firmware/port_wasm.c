/* WebAssembly without a C library: tests/wasm.js loads it and gives it `show`. */
#include "port.h"
#include "bare.h"

__attribute__((import_module("env"), import_name("show"))) void show(const char *text);
__attribute__((export_name("run"))) int run(void);

void port_write(const char *text) { show(text); }
uint32_t port_stack_used(void) { return 0; }
uint32_t port_instructions(void) { return 0; }
int run(void) { return port_main(); }
