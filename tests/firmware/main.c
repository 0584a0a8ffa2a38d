/* Scenes on a machine without an operating system: their hashes as they run, what a step costs where
   the machine counts instructions, and the stack. With ALL_SCENES all of scenes.h, otherwise the
   first FIRMWARE_SCENES. */
#define ECPSIM_IMPLEMENTATION
#include "../../ecpsim.h"
#include "port.h"
#include "scenes.h"

#ifdef ALL_SCENES
enum { FIRMWARE_SCENES = SCENE_COUNT };
#else
enum { FIRMWARE_SCENES = 3 };
#endif

int port_main(void)
{
    int i, failed = 0;
    for (i = 0; i < FIRMWARE_SCENES; i++) {
        const scene *s = scenes + i;
        scene_result r = scene_run(s, 1);
        port_write(s->name);
        port_write(":");
        print_field("steps", (uint32_t)s->steps);
        print_field("not_solved", (uint32_t)r.not_solved);
        print_field("fallbacks", (uint32_t)r.fallbacks);
        print_field("centred", (uint32_t)r.centred);
        if (r.most_instructions > 0) {
            print_field("thousand_instructions_per_step",
                        r.thousand_instructions / (uint32_t)s->steps);
            print_field("at_most", r.most_instructions / 1000);
        }
        port_write("\n");
        /* with few iterations some are not, by any machine alike: the hash has their status */
        failed += r.not_solved < 0 || (r.not_solved > 0 && !s->options);
    }
    if (port_stack_used() > 0) {
        port_write("stack:");
        print_field("bytes", port_stack_used());
        port_write("\n");
    }
    return failed > 0;
}
