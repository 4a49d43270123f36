/* Drives to the target; after a bump turns away for a while. A controller over JSON lines in C, without a library:
 *
 *     cc -O2 -o bounce bounce.c && worldgen run w.grid --controller cmd:./bounce
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The number behind a name, which is given with its quotes and colon. */
static double number(const char *line, const char *name) {
    const char *place = strstr(line, name);
    if (place == NULL) {
        fprintf(stderr, "bounce: no %s in %s", name, line);
        exit(1);
    }
    return strtod(place + strlen(name), NULL);
}

int main(void) {
    static char line[65536];
    double wait = 0.0; /* steps for which the robot still drives away from a wall */
    while (fgets(line, sizeof line, stdin)) {
        if (strstr(line, "\"reset\":")) { /* a new episode: forget; nothing is answered */
            wait = 0.0;
            continue;
        }
        int bump = strstr(line, "\"bump\":true") != NULL;
        double turn = bump ? 1.5 : 0.0; /* rad */
        wait = bump ? 10.0 : wait > 1.0 ? wait - 1.0 : 0.0;
        if (wait == 0.0)
            turn = number(line, "\"target_heading\":") - number(line, "\"heading\":");
        printf("{\"speed\": %.17g, \"turn_rate\": %.17g}\n", number(line, "\"top_speed\":"),
               turn / number(line, "\"time_step\":"));
        fflush(stdout); /* or the line waits in a buffer, and the verdict is hang */
    }
    return 0;
}
