// Moves several robots at once: exactly, and independently of their numbering.
//
// Robots that cannot meet any other in a part of a step move as if alone. The others form clusters,
// and a cluster moves in phases. In each phase all robots move uniformly along straight segments
// between lattice points, all in the same time, so two discs touch exactly when the segment of
// their relative motion comes within the sum of their radii of the origin. This is a test in
// integers, as for a wall's corner. Floating point only proposes the end of the phase, the first
// contact, where robots that touch lose the part of their displacement that leads into each other.
//
// No disc overlaps another disc or a wall: a segment that is not clear of everything is never
// driven, and robots that stand still are clear of each other.

#include <math.h>

#include "fleet.h"

enum {
    TRIES = 3,     // contacts after which a robot stops, as many as a robot alone tries
    ASIDE = 4,     // places to stop at, from the desired one away from what is touched
    BACK = 4,      // number of tries, each a lattice unit farther back
    STAND = BACK * ASIDE,
    SLACK = 32,    // lattice units: more than rounding and the places aside add to a move
};

static WgEpisode *member_of(const WgFleet *fleet, int64_t robot)
{
    return fleet->members[robot];
}

static WgDisc disc_of(const WgFleet *fleet, int64_t robot)
{
    return wg_disc(member_of(fleet, robot)->settings);
}

static bool is_moving(const WgMover *mover)
{
    return mover->left.x != 0 || mover->left.y != 0;
}

static bool is_at_goal(const WgMover *mover)
{
    return mover->place.x == mover->goal.x && mover->place.y == mover->goal.y;
}

// Returns true if a robot's path to its goal is clear of walls.
static bool is_clear_of_walls(const WgFleet *fleet, int64_t robot)
{
    WgMover *mover = &fleet->movers[robot];
    if (!mover->is_clear) {
        const WgArena *arena = member_of(fleet, robot)->arena;
        WgSegment way = {mover->place.x, mover->place.y, mover->goal.x, mover->goal.y};
        WgDisc disc = disc_of(fleet, robot);
        mover->is_clear = is_at_goal(mover) || wg_window_is_free(arena, disc.reach, way)
                          || !wg_first_not_clear(wg_grid(arena), WG_SOLID, disc, way).found;
    }
    return mover->is_clear;
}

// Returns true if two robots stay clear of each other on the way to their goals.
static bool are_clear(const WgFleet *fleet, const WgPair *pair)
{
    const WgMover *one = &fleet->movers[pair->one];
    const WgMover *other = &fleet->movers[pair->other];
    WgSegment way = {one->place.x - other->place.x, one->place.y - other->place.y, one->goal.x - other->goal.x,
                     one->goal.y - other->goal.y};
    return wg_point_is_clear(pair->clear_sq, way, 0, 0);
}

// Returns the normal of a robot's last contact, in this phase or before.
static WgNormal last_normal(const WgMover *mover)
{
    return mover->touching > 0 ? mover->touch : mover->normal;
}

// Sets the goal of a robot: the lattice point at a share of its remaining displacement, or a nearby
// one chosen by `candidate`, nearest first; or its current place.
static void set_goal(WgMover *mover, double share)
{
    double dx = (double)mover->left.x;
    double dy = (double)mover->left.y;
    double length = sqrt(dx * dx + dy * dy);
    int64_t away = mover->candidate % ASIDE;
    double part = length > 0.0 ? (share * length - (double)(mover->candidate / ASIDE)) / length : 0.0;
    int64_t x = mover->place.x + wg_round_away(part * dx);
    int64_t y = mover->place.y + wg_round_away(part * dy);
    mover->is_clear = false;
    if (mover->candidate >= STAND || part <= 0.0 || (x == mover->place.x && y == mover->place.y)) {
        mover->candidate = STAND;
        mover->goal = mover->place;
        return;
    }
    WgNormal normal = last_normal(mover);
    int64_t sx = (normal.x > 0.0) - (normal.x < 0.0);
    int64_t sy = (normal.y > 0.0) - (normal.y < 0.0);
    bool is_last = away == ASIDE - 1;
    mover->goal.x = x + (is_last ? sx : away * (fabs(normal.x) >= fabs(normal.y) ? sx : 0));
    mover->goal.y = y + (is_last ? sy : away * (fabs(normal.y) >= fabs(normal.x) ? sy : 0));
}

// Returns true if a robot has another goal to try: sideways only if it touches something,
// back only if that is allowed.
static bool has_another_goal(const WgMover *mover, bool back)
{
    if (!is_moving(mover) || mover->candidate >= STAND) {
        return false;
    }
    bool aside = wg_is_contact(last_normal(mover)) && mover->candidate % ASIDE < ASIDE - 1;
    return aside || back;
}

static void try_another_goal(WgMover *mover, double share)
{
    bool aside = wg_is_contact(last_normal(mover)) && mover->candidate % ASIDE < ASIDE - 1;
    mover->candidate = aside ? mover->candidate + 1 : (mover->candidate / ASIDE + 1) * ASIDE;
    set_goal(mover, share);
}

// Notes which robots' paths to their goals are not clear. Returns false if there are such robots,
// and none of them has another goal.
static bool look_for_violations(const WgFleet *fleet, WgCluster cluster, bool back, bool *found)
{
    WgMover *movers = fleet->movers;
    *found = false;
    for (int64_t k = cluster.first; k >= 0; k = movers[k].next) {
        movers[k].is_violated = !is_clear_of_walls(fleet, k);
        *found = *found || movers[k].is_violated;
        if (movers[k].is_violated && !has_another_goal(&movers[k], back)) {
            return false;
        }
    }
    for (int64_t k = cluster.first_pair; k >= 0; k = fleet->near->pairs[k].next) {
        const WgPair *pair = &fleet->near->pairs[k];
        if (are_clear(fleet, pair)) {
            continue;
        }
        *found = true;
        movers[pair->one].is_violated = true;
        movers[pair->other].is_violated = true;
        if (!has_another_goal(&movers[pair->one], back) && !has_another_goal(&movers[pair->other], back)) {
            return false;
        }
    }
    return true;
}

// Finds goals at a share of the displacements so that all paths to them are clear of walls and of
// each other. Robots whose paths are not clear try their next goals together. If stepping back is
// allowed, the last goal is to stay in place, so goals are always found.
static bool find_goals(const WgFleet *fleet, WgCluster cluster, double share, bool back)
{
    WgMover *movers = fleet->movers;
    for (int64_t k = cluster.first; k >= 0; k = movers[k].next) {
        movers[k].candidate = 0;
        set_goal(&movers[k], share);
    }
    bool found = true;
    while (found) {
        if (!look_for_violations(fleet, cluster, back, &found)) {
            return false;
        }
        for (int64_t k = cluster.first; found && k >= 0; k = movers[k].next) {
            if (movers[k].is_violated && has_another_goal(&movers[k], back)) {
                try_another_goal(&movers[k], share);
            }
        }
    }
    return true;
}

// Notes a contact of this phase. Of several normals it keeps the largest, by x and then by y, which
// does not depend on the robots' numbers.
static void touch(WgMover *mover, WgNormal normal)
{
    bool greater = normal.x > mover->touch.x || (normal.x == mover->touch.x && normal.y > mover->touch.y);
    if (mover->touching == 0 || greater) {
        mover->touch = normal;
    }
    mover->touching++;
}

// The direction from the second robot of a pair to the first,
// at a share of their remaining displacements.
static WgNormal between(const WgFleet *fleet, const WgPair *pair, double share)
{
    const WgMover *one = &fleet->movers[pair->one];
    const WgMover *other = &fleet->movers[pair->other];
    return (WgNormal){
        (double)(one->place.x - other->place.x) + share * (double)(one->left.x - other->left.x),
        (double)(one->place.y - other->place.y) + share * (double)(one->left.y - other->left.y),
    };
}

// Returns when two robots first touch if nothing stops them,
// as a share of their remaining displacements.
static double pair_contact(const WgFleet *fleet, const WgPair *pair)
{
    const WgMover *one = &fleet->movers[pair->one];
    const WgMover *other = &fleet->movers[pair->other];
    WgPlace from = {one->place.x - other->place.x, one->place.y - other->place.y};
    WgVector by = {one->left.x - other->left.x, one->left.y - other->left.y};
    // A touch that only exact arithmetic detects counts as one at the end.
    return wg_lower(1.0, wg_touch_time((double)pair->clear_sq, from, by));
}

// Finds the first contact in a cluster, and marks the robots in it.
// Returns its share of the displacements.
static double first_contact(const WgFleet *fleet, WgCluster cluster)
{
    WgMover *movers = fleet->movers;
    WgPair *pairs = fleet->near->pairs;
    double first = 1.0;
    for (int64_t k = cluster.first; k >= 0; k = movers[k].next) {
        movers[k].candidate = 0;
        set_goal(&movers[k], 1.0);
        while (!is_clear_of_walls(fleet, k) && has_another_goal(&movers[k], false)) {
            try_another_goal(&movers[k], 1.0);
        }
    }

    // Find when contacts happen.
    for (int64_t k = cluster.first; k >= 0; k = movers[k].next) {
        WgMover *mover = &movers[k];
        mover->wall = (WgContact){2.0, {0.0, 0.0}};
        if (!is_clear_of_walls(fleet, k)) {
            WgGrid grid = wg_grid(member_of(fleet, k)->arena);
            mover->wall = wg_wall_contact(grid, disc_of(fleet, k), mover->place, mover->left);
            first = wg_lower(first, mover->wall.time);
        }
    }
    for (int64_t k = cluster.first_pair; k >= 0; k = pairs[k].next) {
        pairs[k].time = are_clear(fleet, &pairs[k]) ? 2.0 : pair_contact(fleet, &pairs[k]);
        first = wg_lower(first, pairs[k].time);
    }

    // Find which robots they stop.
    for (int64_t k = cluster.first; k >= 0; k = movers[k].next) {
        movers[k].touching = 0;
        if (movers[k].wall.time <= first) {
            touch(&movers[k], movers[k].wall.normal);
        }
    }
    for (int64_t k = cluster.first_pair; k >= 0; k = pairs[k].next) {
        if (pairs[k].time <= first) {
            WgNormal normal = between(fleet, &pairs[k], first);
            touch(&movers[pairs[k].one], normal);
            touch(&movers[pairs[k].other], (WgNormal){-normal.x, -normal.y});
        }
    }
    return first;
}

// A time in the step, 2^-32 steps.
static int64_t whole_time(double time)
{
    return wg_floor(time * 0x1p32 + 0.5);
}

// Moves the robots of a cluster to their goals, from a time in the step to another.
static void go_to_goals(WgFleet *fleet, WgCluster cluster, int64_t step, double begin, double end)
{
    for (int64_t k = cluster.first; k >= 0; k = fleet->movers[k].next) {
        WgMover *mover = &fleet->movers[k];
        if (!is_at_goal(mover)) {
            WgEpisode *member = member_of(fleet, k);
            // If it stood still before, its path records the time until which it waited for others.
            if (mover->since < whole_time(begin)) {
                wg_add_corner(&member->robot, mover->place.x, mover->place.y, whole_time(begin));
            }
            mover->since = whole_time(end);
            wg_add_corner(&member->robot, mover->goal.x, mover->goal.y, mover->since);
            wg_arrive_closely(member->arena, member->settings, step, mover->goal.x, mover->goal.y, &member->robot);
        }
    }
}

// Notes that one robot drives into another.
static void note_block(WgFleet *fleet, int64_t step, int64_t robot, int64_t by)
{
    const WgFleetSettings *settings = fleet->settings;
    if (settings->find_loop == WG_PROVE_LOOP && step > settings->loop_entry) {
        fleet->blocked[robot * fleet->count + by] = 1;
    }
}

// Notes which robot drives into which at a contact.
static void note_blocks(WgFleet *fleet, WgCluster cluster, int64_t step, double share)
{
    const WgPair *pairs = fleet->near->pairs;
    for (int64_t k = cluster.first_pair; k >= 0; k = pairs[k].next) {
        if (pairs[k].time > share) {
            continue;
        }
        WgNormal normal = between(fleet, &pairs[k], share);
        WgVector one = fleet->movers[pairs[k].one].left;
        WgVector other = fleet->movers[pairs[k].other].left;
        if ((double)one.x * normal.x + (double)one.y * normal.y < 0.0) {
            note_block(fleet, step, pairs[k].one, pairs[k].other);
        }
        if ((double)other.x * normal.x + (double)other.y * normal.y > 0.0) {
            note_block(fleet, step, pairs[k].other, pairs[k].one);
        }
    }
}

// Removes from a robot's displacement the part that a phase has used up, and the part that would
// lead into whatever it touches.
static void slide(WgMover *mover, double share, double friction)
{
    double dx = (1.0 - share) * (double)mover->left.x;
    double dy = (1.0 - share) * (double)mover->left.y;
    if (mover->touching == 0) {
        // A robot that had to wait has lost that time; all others drive to the very end of their
        // displacement.
        bool stood = is_at_goal(mover);
        mover->left.x = stood ? wg_round_away(dx) : mover->left.x - (mover->goal.x - mover->place.x);
        mover->left.y = stood ? wg_round_away(dy) : mover->left.y - (mover->goal.y - mover->place.y);
        return;
    }
    WgNormal before = mover->normal;
    WgNormal normal = mover->touch;
    mover->normal = normal;
    mover->contacts++;
    double into = (dx * normal.x + dy * normal.y) / (normal.x * normal.x + normal.y * normal.y);
    if (into < 0.0) {
        dx = dx - into * normal.x;
        dy = dy - into * normal.y;
    }
    // It stops if it touches two things at once, is pushed back into what it touched before, or has
    // touched things too often.
    bool is_wedged = mover->contacts > 1 && dx * before.x + dy * before.y < 0.0;
    bool stops = mover->touching > 1 || is_wedged || mover->contacts >= TRIES;
    mover->left.x = stops ? 0 : wg_round_away((1.0 - friction) * dx);
    mover->left.y = stops ? 0 : wg_round_away((1.0 - friction) * dy);
}

// Moves the robots of a cluster by their remaining displacements, in phases.
static void sweep(WgFleet *fleet, WgCluster cluster, int64_t step, WgSpan span)
{
    double now = (double)span.from / (double)WG_STEP_TIME;
    double end = (double)span.until / (double)WG_STEP_TIME;
    for (int64_t k = cluster.first; k >= 0; k = fleet->movers[k].next) {
        fleet->movers[k].since = span.from;
    }
    for (int64_t phase = 0; phase < WG_MOST_PHASES; phase++) {
        for (int64_t k = cluster.first; k >= 0; k = fleet->movers[k].next) {
            fleet->movers[k].touching = 0;
        }
        if (find_goals(fleet, cluster, 1.0, false)) {
            go_to_goals(fleet, cluster, step, now, end);
            return;
        }
        double share = first_contact(fleet, cluster);
        note_blocks(fleet, cluster, step, share);
        find_goals(fleet, cluster, share, true);
        double until = now + (end - now) * share;
        go_to_goals(fleet, cluster, step, now, until);
        now = until;
        for (int64_t k = cluster.first; k >= 0; k = fleet->movers[k].next) {
            WgMover *mover = &fleet->movers[k];
            slide(mover, share, member_of(fleet, k)->settings->wall_friction);
            mover->place = mover->goal;
        }
    }
}

// Notes in the report the first pair of robots, by their numbers, that drive through each other.
static void collide(WgFleet *fleet, const WgPair *pair)
{
    WgFleetReport *report = &fleet->report;
    int64_t robot = wg_least(pair->one, pair->other);
    int64_t other = wg_most(pair->one, pair->other);
    bool first = report->ending != WG_COLLISION || robot < report->robot
                 || (robot == report->robot && other < report->other);
    if (first) {
        report->ending = WG_COLLISION;
        report->robot = robot;
        report->other = other;
    }
}

// Moves the robots of a cluster to where their displacements lead, as `endpoint` does: a robot
// whose end is not clear stays. Paths that cross end the run as WG_COLLISION.
static void jump(WgFleet *fleet, WgCluster cluster, int64_t step)
{
    WgMover *movers = fleet->movers;
    const WgPair *pairs = fleet->near->pairs;
    for (int64_t k = cluster.first; k >= 0; k = movers[k].next) {
        WgMover *mover = &movers[k];
        WgPlace goal = {mover->place.x + mover->left.x, mover->place.y + mover->left.y};
        mover->touching = 0;
        if (is_moving(mover)
            && !wg_disc_is_clear(wg_grid(member_of(fleet, k)->arena), WG_SOLID, disc_of(fleet, k), goal.x, goal.y)) {
            touch(mover, (WgNormal){-(double)mover->left.x, -(double)mover->left.y});
            goal = mover->place;
        }
        mover->goal = goal;
    }

    // A robot that would end in another one stays, and then blocks others in turn.
    bool found = true;
    while (found) {
        found = false;
        for (int64_t k = cluster.first; k >= 0; k = movers[k].next) {
            movers[k].is_violated = false;
        }
        for (int64_t k = cluster.first_pair; k >= 0; k = pairs[k].next) {
            WgMover *one = &movers[pairs[k].one];
            WgMover *other = &movers[pairs[k].other];
            int64_t dx = one->goal.x - other->goal.x;
            int64_t dy = one->goal.y - other->goal.y;
            if (dx * dx + dy * dy < pairs[k].clear_sq) {
                found = true;
                one->is_violated = true;
                other->is_violated = true;
                WgNormal normal = {(double)(one->place.x - other->place.x), (double)(one->place.y - other->place.y)};
                touch(one, normal);
                touch(other, (WgNormal){-normal.x, -normal.y});
                if (!is_at_goal(one)) {
                    note_block(fleet, step, pairs[k].one, pairs[k].other);
                }
                if (!is_at_goal(other)) {
                    note_block(fleet, step, pairs[k].other, pairs[k].one);
                }
            }
        }
        for (int64_t k = cluster.first; k >= 0; k = movers[k].next) {
            if (movers[k].is_violated) {
                movers[k].goal = movers[k].place;
            }
        }
    }
    for (int64_t k = cluster.first_pair; k >= 0; k = pairs[k].next) {
        if (!are_clear(fleet, &pairs[k])) {
            collide(fleet, &pairs[k]);
        }
    }
    go_to_goals(fleet, cluster, step, 0.0, 1.0);
    for (int64_t k = cluster.first; k >= 0; k = movers[k].next) {
        movers[k].normal = movers[k].touching > 0 ? movers[k].touch : (WgNormal){0.0, 0.0};
    }
}

// Moves the robots of a cluster and judges their paths.
static void move_cluster(WgFleet *fleet, WgCluster cluster, int64_t step, WgSpan span)
{
    if (fleet->settings->motion == WG_SWEPT) {
        sweep(fleet, cluster, step, span);
    } else {
        jump(fleet, cluster, step);
    }
    for (int64_t k = cluster.first; k >= 0; k = fleet->movers[k].next) {
        WgMover *mover = &fleet->movers[k];
        WgEpisode *member = member_of(fleet, k);
        // A robot that stands still may be at its target.
        const WgState *state = &member->robot.body->state;
        if (mover->is_active && state->x == mover->begin.x && state->y == mover->begin.y) {
            wg_arrive_closely(member->arena, member->settings, step, state->x, state->y, &member->robot);
        }
        if (wg_is_contact(mover->normal)) {
            member->robot.contact = mover->normal;
        }
    }
}

// Prepares a robot for a part of the step: where it is, and how far it may get.
static void set_out(const WgFleet *fleet, int64_t robot, WgVector by)
{
    WgMover *mover = &fleet->movers[robot];
    const WgEpisode *member = member_of(fleet, robot);
    mover->place = (WgPlace){member->robot.body->state.x, member->robot.body->state.y};
    mover->begin = mover->place;
    mover->left = mover->is_active ? by : (WgVector){0, 0};
    mover->normal = (WgNormal){0.0, 0.0};
    mover->touching = 0;
    mover->contacts = 0;
    mover->far = member->settings->reach;
    if (is_moving(mover)) {
        double dx = (double)mover->left.x;
        double dy = (double)mover->left.y;
        mover->far += wg_ceil(sqrt(dx * dx + dy * dy)) + SLACK;
    }
}

// Moves all robots by a part of the step in which the world does not change.
static void move_part(WgFleet *fleet, int64_t step, WgSpan span)
{
    wg_find_near(fleet);
    for (int64_t k = 0; k < fleet->count; k++) {
        WgMover *mover = &fleet->movers[k];
        WgEpisode *member = member_of(fleet, k);
        WgCluster cluster = {fleet->near->first[k], fleet->near->first_pair[k]};
        if (cluster.first >= 0) {
            move_cluster(fleet, cluster, step, span);
        } else if (mover->is_active && fleet->near->first[mover->cluster] < 0) {
            WgNormal contact = wg_move(member->arena, member->settings, step, mover->left.x, mover->left.y, span.from,
                                       span.until, &member->robot);
            if (wg_is_contact(contact)) {
                member->robot.contact = contact;
            }
        }
    }
}

// A robot waits for an event at the end of a part of the step.
static void wait_for(WgRobot *robot, int64_t until)
{
    if (until < WG_STEP_TIME && (robot->corners == 0 || robot->chain[robot->corners - 1].time < until)) {
        wg_add_corner(robot, robot->body->state.x, robot->body->state.y, until);
    }
}

// Moves all robots that still drive up to a time in the step.
static void move_until(WgFleet *fleet, int64_t step, WgSpan span, const WgVector *by)
{
    for (int64_t k = 0; k < fleet->count; k++) {
        WgMover *mover = &fleet->movers[k];
        mover->is_active = member_of(fleet, k)->robot.report.ending == WG_LIMIT;
        WgVector there = by[k];
        WgVector gone = {0, 0};
        if (span.until < WG_STEP_TIME) {
            there = (WgVector){wg_share_of(by[k].x, span.until, WG_STEP_TIME), wg_share_of(by[k].y, span.until, WG_STEP_TIME)};
        }
        if (span.from > 0) {
            gone = (WgVector){wg_share_of(by[k].x, span.from, WG_STEP_TIME), wg_share_of(by[k].y, span.from, WG_STEP_TIME)};
        }
        set_out(fleet, k, (WgVector){there.x - gone.x, there.y - gone.y});
    }
    move_part(fleet, step, span);
    for (int64_t k = 0; k < fleet->count; k++) {
        if (fleet->movers[k].is_active) {
            wait_for(&member_of(fleet, k)->robot, span.until);
        }
    }
}

// Applies the changes of cells at this time, and catches the robots there, including parked ones.
static void change_world(WgFleet *fleet, int64_t step)
{
    fleet->next_event = wg_change_cells(member_of(fleet, 0)->arena, step, fleet->next_event);
    for (int64_t k = 0; k < fleet->count; k++) {
        WgEpisode *member = member_of(fleet, k);
        int64_t ending = member->robot.report.ending;
        if (ending == WG_LIMIT || ending == WG_REACHED) {
            wg_catch(member->arena, member->settings, step, &member->robot);
        }
    }
}

static bool is_ended(const WgFleet *fleet)
{
    for (int64_t k = 0; k < fleet->count; k++) {
        int64_t ending = member_of(fleet, k)->robot.report.ending;
        if (ending != WG_LIMIT && ending != WG_REACHED) {
            return true;
        }
    }
    return fleet->report.ending != WG_LIMIT;
}

void wg_move_fleet(WgFleet *fleet, int64_t step, const WgVector *by)
{
    // `endpoint` checks the world only at the end of a step, so all events come first.
    const WgArena *arena = member_of(fleet, 0)->arena;
    bool exact = fleet->settings->motion == WG_SWEPT;
    int64_t now = 0;
    while (now < WG_STEP_TIME && !is_ended(fleet)) {
        bool due = fleet->next_event < arena->event_count && arena->events[fleet->next_event].step == step;
        int64_t until = due && exact ? arena->events[fleet->next_event].time : WG_STEP_TIME;
        if (until > now && (exact || !due)) {
            move_until(fleet, step, (WgSpan){now, until}, by);
            now = until;
        }
        if (due && !is_ended(fleet)) {
            change_world(fleet, step);
        }
    }
}
