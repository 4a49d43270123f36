/* Drives to the target; after a bump turns away and drives straight on for a while: the rule that worldgen
 * new-controller writes, as a controller over JSON lines in plain C.
 *
 *     cc -O2 -o bounce bounce.c -lm && worldgen run w.grid --controller cmd:./bounce
 */
#include <math.h>
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
    const double half = acos(-1.0); /* rad: half a turn */
    int waiting = 0;                /* steps left to drive straight */
    while (fgets(line, sizeof line, stdin)) {
        if (strstr(line, "\"reset\":")) { /* new episode: forget everything; no answer expected */
            waiting = 0;
            continue;
        }
        double turn = 0.0; /* rad */
        if (strstr(line, "\"bump\":true")) {
            turn = 1.5;
            waiting = 20;
        } else if (waiting > 0) {
            waiting -= 1;
        } else {
            turn = fmod(number(line, "\"target_heading\":") - number(line, "\"heading\":") + half, 2 * half);
            turn += turn < 0.0 ? half : -half;
        }
        printf("{\"speed\": %.17g, \"turn_rate\": %.17g}\n", number(line, "\"top_speed\":"),
               turn / number(line, "\"time_step\":"));
        fflush(stdout); /* otherwise the line waits in a buffer, and the verdict is hang */
    }
    return 0;
}
