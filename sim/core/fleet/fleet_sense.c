// Lets the robots of a fleet sense each other: by range beams,
// and as neighbours that may send messages.

#include "fleet.h"
#include "rays.h"

// Up to this many robots are sorted by rank, which compares all pairs.
enum { MOST_RANKED = 32 };

double *wg_message_of(const WgFleet *fleet, int64_t robot)
{
    WgEpisode *member = fleet->members[robot];
    return member->robot.body->memory + member->controller.memory_size;
}

// Lays the grid over the robots: its cells are wide enough that all robots that a robot may sense
// are in the nine around it, and that there are no more cells than robots.
static void lay_grid(const WgFleet *fleet, WgRobotGrid *grid)
{
    const double most = 0x1p40;  // more than any world is wide
    WgPlace low = fleet->movers[0].place;
    WgPlace high = low;
    for (int64_t k = 1; k < fleet->count; k++) {
        WgPlace place = fleet->movers[k].place;
        low = (WgPlace){wg_least(low.x, place.x), wg_least(low.y, place.y)};
        high = (WgPlace){wg_most(high.x, place.x), wg_most(high.y, place.y)};
    }
    int64_t side = 1;
    while ((side + 1) * (side + 1) <= fleet->count) {
        side++;
    }
    grid->low = low;
    grid->cell = wg_ceil(wg_lower(fleet->furthest, most)) + 1;
    grid->cell = wg_most(grid->cell, wg_most(high.x - low.x, high.y - low.y) / side + 1);
    grid->columns = (high.x - low.x) / grid->cell + 1;
    grid->rows = (high.y - low.y) / grid->cell + 1;
}

// Returns the index of the cell in which a place is.
static int64_t cell_of(const WgRobotGrid *grid, WgPlace place)
{
    return (place.y - grid->low.y) / grid->cell * grid->columns + (place.x - grid->low.x) / grid->cell;
}

static WgSpot spot_of(const WgFleet *fleet, int64_t robot, WgPlace place)
{
    const WgSettings *settings = fleet->members[robot]->settings;
    const WgState *state = &fleet->members[robot]->robot.body->state;
    return (WgSpot){
        .place = place,
        .reach = settings->radius / settings->metres,
        .radius = settings->radius,
        .speed = (double)state->speed / (double)WG_SPEED_UNIT / settings->speed,
        .heading = state->heading,
        .robot = robot,
    };
}

void wg_ready_senses(WgFleet *fleet)
{
    WgRobotGrid *grid = &fleet->near->grid;
    for (int64_t k = 0; k < fleet->count; k++) {
        const WgState *state = &fleet->members[k]->robot.body->state;
        fleet->movers[k].place = (WgPlace){state->x, state->y};
    }
    lay_grid(fleet, grid);

    // Sort the robots by cell: count the robots of each cell, add up to where each cell ends, and
    // fill each from its end, so that its index moves down to where it begins.
    int64_t cells = grid->columns * grid->rows;
    memset(grid->first, 0, (size_t)cells * sizeof *grid->first);
    for (int64_t k = 0; k < fleet->count; k++) {
        grid->first[cell_of(grid, fleet->movers[k].place)]++;
    }
    for (int64_t cell = 1; cell < cells; cell++) {
        grid->first[cell] += grid->first[cell - 1];
    }
    grid->first[cells] = fleet->count;
    for (int64_t k = fleet->count - 1; k >= 0; k--) {
        WgPlace place = fleet->movers[k].place;
        grid->spots[--grid->first[cell_of(grid, place)]] = spot_of(fleet, k, place);
    }
}

// Notes the robots near enough for any sense that are in neighbouring cells of a row,
// which follow each other.
static int64_t note_some(const WgRobotGrid *grid, int64_t from, int64_t end, WgPlace own, double furthest_sq, int64_t count)
{
    for (int64_t k = from; k < end; k++) {
        int64_t dx = grid->spots[k].place.x - own.x;
        int64_t dy = grid->spots[k].place.y - own.y;
        int64_t away_sq = dx * dx + dy * dy;
        // Without a branch, which nobody could predict, each one is written, and the next one
        // overwrites it if it is too far away.
        grid->found[count] = (WgNearby){away_sq, k};
        count += (double)away_sq <= furthest_sq;
    }
    return count;
}

// Returns true if a robot comes before another in the order of sensing: nearest first, ties broken
// by place, which is never the same, so that their numbers do not matter.
static bool comes_before(const WgRobotGrid *grid, WgNearby one, WgNearby other)
{
    if (one.away_sq != other.away_sq) {
        return one.away_sq < other.away_sq;
    }
    WgPlace place = grid->spots[one.spot].place;
    WgPlace others = grid->spots[other.spot].place;
    return place.x < others.x || (place.x == others.x && place.y < others.y);
}

// Sorts a few robots by distance alone, without a branch that depends on one. The rank of each is
// the number of robots that are nearer. Equal distances share a rank, so they stay unsorted.
//
// With eleven robots in range, insertion alone takes twice as long,
// because its branches cannot be predicted.
static void sort_by_rank(WgNearby *found, int64_t count)
{
    int64_t away_sq[MOST_RANKED];
    WgNearby sorted[MOST_RANKED];
    int64_t sum = 0;
    for (int64_t k = 0; k < count; k++) {
        away_sq[k] = found[k].away_sq;
    }
    for (int64_t k = 0; k < count; k++) {
        int64_t nearer = 0;
        for (int64_t other = 0; other < count; other++) {
            // The sign of the difference: unlike a comparison,
            // compilers take two of these at a time.
            nearer += (int64_t)((uint64_t)(away_sq[other] - away_sq[k]) >> 63);
        }
        sorted[nearer] = found[k];
        sum += nearer;
    }
    if (2 * sum == count * (count - 1)) {
        memcpy(found, sorted, (size_t)count * sizeof *found);
    }
}

// Sorts robots by the order of sensing. Unless the range is long, there are few.
static void sort_found(const WgRobotGrid *grid, int64_t count)
{
    if (count <= MOST_RANKED) {
        sort_by_rank(grid->found, count);
    }
    // Insertion settles what is left: equal distances, or a crowd.
    for (int64_t k = 1; k < count; k++) {
        WgNearby found = grid->found[k];
        int64_t at = k;
        for (; at > 0 && comes_before(grid, found, grid->found[at - 1]); at--) {
            grid->found[at] = grid->found[at - 1];
        }
        grid->found[at] = found;
    }
}

// Fills what a robot senses of the others around it, as far as its neighbours' range
// and room reach.
static void fill_neighbours(WgFleet *fleet, int64_t robot)
{
    WgEpisode *member = fleet->members[robot];
    const WgSettings *settings = member->settings;
    const WgState *state = &member->robot.body->state;
    WgWorkspace *workspace = &member->workspace;
    double along = wg_cosine(member->arena->headings, state->heading);
    double across = wg_sine(member->arena->headings, state->heading);
    double range_sq = settings->neighbour_range * settings->neighbour_range;
    int64_t count = 0;
    for (int64_t k = 0; k < fleet->others.count && count < workspace->neighbour_room; k++) {
        const WgOther *other = &fleet->around[k];
        if ((double)other->away_sq > range_sq) {
            break;  // so are all that follow
        }
        const WgSpot *spot = &fleet->near->grid.spots[other->spot];
        double dx = (double)(other->x - state->x) * settings->metres;
        double dy = (double)(other->y - state->y) * settings->metres;
        WgNeighbour *neighbour = &workspace->neighbours[count++];
        neighbour->x = dx * along + dy * across;
        neighbour->y = dy * along - dx * across;
        neighbour->heading = (double)wg_turn_towards(state->heading, spot->heading) * settings->radians;
        neighbour->speed = spot->speed;
        neighbour->radius = spot->radius;
        if (fleet->settings->message > 0) {
            memcpy(neighbour->message, wg_message_of(fleet, spot->robot),
                   (size_t)fleet->settings->message * sizeof *neighbour->message);
        }
    }
    workspace->observation.neighbour_count = count;
}

void wg_sense_others(WgFleet *fleet, int64_t robot)
{
    const WgRobotGrid *grid = &fleet->near->grid;
    WgPlace own = fleet->movers[robot].place;
    double furthest_sq = fleet->furthest * fleet->furthest;
    int64_t column = (own.x - grid->low.x) / grid->cell;
    int64_t row = (own.y - grid->low.y) / grid->cell;
    int64_t left = wg_most(column - 1, 0);
    int64_t right = wg_least(column + 1, grid->columns - 1);
    int64_t bottom = wg_least(row + 1, grid->rows - 1);
    int64_t count = 0;
    for (int64_t at = wg_most(row - 1, 0); at <= bottom; at++) {
        int64_t from = grid->first[at * grid->columns + left];
        int64_t end = grid->first[at * grid->columns + right + 1];
        count = note_some(grid, from, end, own, furthest_sq, count);
    }
    sort_found(grid, count);
    fleet->others.count = 0;
    for (int64_t k = 0; k < count; k++) {
        WgNearby found = grid->found[k];
        const WgSpot *spot = &grid->spots[found.spot];
        if (spot->robot != robot) {
            fleet->around[fleet->others.count++] =
                (WgOther){spot->place.x, spot->place.y, found.away_sq, spot->reach, found.spot};
        }
    }
    fill_neighbours(fleet, robot);
}
