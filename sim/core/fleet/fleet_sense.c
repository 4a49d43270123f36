// Lets the robots of a fleet sense each other: by range beams, and as neighbours that may send messages.

#include "fleet.h"
#include "rays.h"

double *wg_message_of(const WgFleet *fleet, int64_t robot)
{
    WgEpisode *member = fleet->members[robot];
    return member->robot.body->memory + member->controller.memory_size;
}

// Returns the width of a bucket, chosen so that all robots that a robot may sense are in the nine around it.
static int64_t width_of(const WgFleet *fleet)
{
    const double most = 0x1p40;  // more than any world is wide
    return wg_ceil(wg_lower(fleet->furthest, most)) + 1;
}

void wg_ready_senses(WgFleet *fleet)
{
    for (int64_t k = 0; k < fleet->count; k++) {
        const WgState *state = &fleet->members[k]->robot.body->state;
        fleet->movers[k].place = (WgPlace){state->x, state->y};
    }
    if (fleet->count > WG_FEW_ROBOTS) {
        wg_fill_buckets(fleet, width_of(fleet));
    }
}

// Returns true if a robot comes before another in the order of sensing: nearest first, ties broken by place, which is
// never the same, so that their numbers do not matter.
static bool comes_before(const WgOther *one, const WgOther *other)
{
    if (one->away_sq != other->away_sq) {
        return one->away_sq < other->away_sq;
    }
    return one->x < other->x || (one->x == other->x && one->y < other->y);
}

// Puts another robot into the sorted list of those around a robot, if it is near enough for any sense.
static void add_other(WgFleet *fleet, int64_t robot, int64_t other)
{
    const WgMover *movers = fleet->movers;
    const WgSettings *settings = fleet->members[other]->settings;
    int64_t dx = movers[other].place.x - movers[robot].place.x;
    int64_t dy = movers[other].place.y - movers[robot].place.y;
    WgOther found = {movers[other].place.x, movers[other].place.y, dx * dx + dy * dy,
                     settings->radius / settings->metres, other};
    if (other == robot || (double)found.away_sq > fleet->furthest * fleet->furthest) {
        return;
    }
    int64_t at = fleet->others.count++;
    for (; at > 0 && comes_before(&found, &fleet->around[at - 1]); at--) {
        fleet->around[at] = fleet->around[at - 1];
    }
    fleet->around[at] = found;
}

// Fills what a robot senses of another one.
static void fill_neighbour(const WgFleet *fleet, int64_t robot, const WgOther *other, WgNeighbour *neighbour)
{
    const WgEpisode *member = fleet->members[robot];
    const WgSettings *settings = member->settings;
    const WgState *state = &member->robot.body->state;
    const WgEpisode *theirs = fleet->members[other->robot];
    const WgState *their_state = &theirs->robot.body->state;
    double along = wg_cosine(member->arena->headings, state->heading);
    double across = wg_sine(member->arena->headings, state->heading);
    double dx = (double)(other->x - state->x) * settings->metres;
    double dy = (double)(other->y - state->y) * settings->metres;
    *neighbour = (WgNeighbour){
        .x = dx * along + dy * across,
        .y = dy * along - dx * across,
        .heading = (double)wg_turn_towards(state->heading, their_state->heading) * settings->radians,
        .speed = (double)their_state->speed / (double)WG_SPEED_UNIT / settings->speed,
        .radius = theirs->settings->radius,
    };
    memcpy(neighbour->message, wg_message_of(fleet, other->robot),
           (size_t)fleet->settings->message * sizeof *neighbour->message);
}

void wg_sense_others(WgFleet *fleet, int64_t robot)
{
    fleet->others.count = 0;
    if (fleet->count <= WG_FEW_ROBOTS) {
        for (int64_t other = 0; other < fleet->count; other++) {
            add_other(fleet, robot, other);
        }
    } else {
        const WgMover *mover = &fleet->movers[robot];
        for (int64_t which = 0; which < 9; which++) {
            int64_t other = wg_first_in(fleet, mover->column + which % 3 - 1, mover->row + which / 3 - 1);
            for (; other >= 0; other = wg_next_in(fleet, other)) {
                add_other(fleet, robot, other);
            }
        }
    }

    WgEpisode *member = fleet->members[robot];
    WgWorkspace *workspace = &member->workspace;
    double range = member->settings->neighbour_range;
    int64_t count = 0;
    for (int64_t k = 0; k < fleet->others.count && count < workspace->neighbour_room; k++) {
        if ((double)fleet->around[k].away_sq <= range * range) {
            fill_neighbour(fleet, robot, &fleet->around[k], &workspace->neighbours[count++]);
        }
    }
    workspace->observation.neighbour_count = count;
}
