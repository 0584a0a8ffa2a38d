/* Runs files through tests/fuzz/target.c, without a fuzzer:

     replay FILE...                              each once
     replay -mutate ROUNDS SEED LAST FILE...     what comes of them by random changes, the same on
                                                 every machine; LAST has the input of the round */
#include "target.c"

#define REPLAY_FILES 4096
#define REPLAY_BYTES 600

typedef struct replay_text {
    unsigned char bytes[REPLAY_BYTES];
    size_t count;
} replay_text;

static uint32_t replay_state;

/* Marsaglia's xorshift; less than n */
static unsigned replay_random(size_t n)
{
    replay_state ^= replay_state << 13;
    replay_state ^= replay_state >> 17;
    replay_state ^= replay_state << 5;
    return n > 0 ? (unsigned)(replay_state % n) : 0;
}

static int replay_read(const char *name, replay_text *t)
{
    FILE *file = fopen(name, "rb");
    if (!file) {
        perror(name);
        return 0;
    }
    t->count = fread(t->bytes, 1, sizeof t->bytes, file);
    fclose(file);
    return 1;
}

/* a piece of b in place of one of a, anywhere */
static void replay_splice(replay_text *a, const replay_text *b)
{
    size_t from = replay_random(b->count), to = replay_random(a->count);
    size_t count = 1 + replay_random(b->count - from), room = sizeof a->bytes - to;
    size_t cut = to + replay_random(a->count - to);
    replay_text rest = *a;
    if (b->count == 0) return;
    if (count > room) count = room;
    memcpy(a->bytes + to, b->bytes + from, count);
    a->count = to + count;
    room = sizeof a->bytes - a->count;
    if (rest.count - cut < room) room = rest.count - cut;
    memcpy(a->bytes + a->count, rest.bytes + cut, room);
    a->count += room;
}

/* a byte, often one that stands for a number that breaks things */
static void replay_byte(replay_text *t)
{
    unsigned how = replay_random(3);
    unsigned char *at = t->bytes + replay_random(t->count);
    if (t->count == 0) return;
    if (how == 0) *at = (unsigned char)(232 + replay_random(24));
    if (how == 1) *at = (unsigned char)replay_random(256);
    if (how == 2) *at = (unsigned char)(*at + 1 - 2 * replay_random(2));
}

static int replay_mutate(int rounds, const char *last, int count, char **names)
{
    static replay_text text[REPLAY_FILES];
    int i;
    if (count > REPLAY_FILES) count = REPLAY_FILES;
    for (i = 0; i < count; i++) {
        if (!replay_read(names[i], text + i)) return 1;
    }
    for (i = 0; i < rounds; i++) {
        replay_text *t = text + replay_random((size_t)count), next = *t;
        int n = 1 + (int)replay_random(6);
        FILE *file = fopen(last, "wb");
        if (replay_random(3) == 0) replay_splice(&next, text + replay_random((size_t)count));
        while (n-- > 0) replay_byte(&next);
        if (!file || fwrite(next.bytes, 1, next.count, file) != next.count) return perror(last), 1;
        fclose(file);
        LLVMFuzzerTestOneInput(next.bytes, next.count);
        if (replay_random(16) == 0) *t = next; /* they wander */
    }
    return 0;
}

int main(int argc, char **argv)
{
    int i;
    if (argc > 5 && strcmp(argv[1], "-mutate") == 0) {
        replay_state = 2654435769u * (uint32_t)atoi(argv[3]) + 1;
        return replay_mutate(atoi(argv[2]), argv[4], argc - 5, argv + 5);
    }
    for (i = 1; i < argc; i++) {
        replay_text t;
        if (!replay_read(argv[i], &t)) return 1;
        LLVMFuzzerTestOneInput(t.bytes, t.count);
    }
    return 0;
}
