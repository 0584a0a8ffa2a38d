/* Runs files through tests/fuzz/target.c, without a fuzzer: replay FILE... */
#include "target.c"

int main(int argc, char **argv)
{
    static unsigned char bytes[4096];
    int i;
    for (i = 1; i < argc; i++) {
        FILE *file = fopen(argv[i], "rb");
        size_t count;
        if (!file) return perror(argv[i]), 1;
        count = fread(bytes, 1, sizeof bytes, file);
        fclose(file);
        LLVMFuzzerTestOneInput(bytes, count);
    }
    return 0;
}
