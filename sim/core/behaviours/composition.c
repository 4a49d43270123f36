// A composition of the library's behaviours: the parts are stored as numbers in its memory, so any
// combination runs at full speed.
//
// The arbiter decides by priority (worldgen_behaviours.h), lets the parts vote,
// or learns when each part is useful.
//
// Sources: the vote follows Julio K. Rosenblatt, "DAMN: a distributed architecture for mobile
// navigation", Journal of Experimental & Theoretical Artificial Intelligence 9 (1997); learning
// follows Pattie Maes and Rodney A. Brooks, "Learning to coordinate behaviors", AAAI (1990).

#include <assert.h>
#include <math.h>

#include "behaviours.h"
#include "directions.h"
#include "library.h"

// rad: a vote for a direction fades out at this angle
static const double SPREAD = 0.5 * 3.14159265358979323846;
// steps that a part must act in a condition before its value is known
static const double TRIALS = 48.0;
static const int64_t RECENT = 128;      // steps of a condition over which shares are averaged
static const double LATELY = 32.0;      // steps for which a touch counts as recent
// relevance of a part that has yet to be tried: above any other
static const double UNTRIED = 2.0;

static const WgBehaviour *const BEHAVIOURS[] = {
    &wg_collide, &wg_seek,  &wg_drive_on, &wg_avoid,  &wg_follow_wall,
    &wg_approach, &wg_escape, &wg_home,    &wg_swerve, &wg_wander,
};

int64_t wg_behaviour_count(void)
{
    return (int64_t)(sizeof BEHAVIOURS / sizeof BEHAVIOURS[0]);
}

const WgBehaviour *wg_behaviour_at(int64_t index)
{
    return BEHAVIOURS[index];
}

// The parts of a composition's memory.
typedef struct Composed {
    WgComposition *own;
    int64_t count;
    double *left;          // (count,) steps that each part has left, for a vote
    WgLearning *learning;  // for an arbiter that learns
    WgFeedback *all;       // (WG_CONDITIONS,)
    WgFeedback *of_part;   // (count, WG_CONDITIONS)
    WgPart parts[WG_MOST_PARTS];
} Composed;

// others: behaviours for parts whose kind is negative, starting at -1; NULL if there are none.
static Composed composed_of(double *memory, const WgBehaviour *others)
{
    Composed made;
    made.own = (WgComposition *)memory;
    made.count = (int64_t)made.own->count;
    assert(made.count >= 1 && made.count <= WG_MOST_PARTS);
    const WgStoredPart *stored = (const WgStoredPart *)(made.own + 1);
    double *rest = (double *)(stored + made.count);

    // Memory that only some arbiters use.
    made.left = rest;
    if (made.own->arbiter == (double)WG_BY_VOTE) {
        rest += made.count;
    }
    made.learning = (WgLearning *)rest;
    made.all = (WgFeedback *)(made.learning + 1);
    made.of_part = made.all + WG_CONDITIONS;
    if (made.own->arbiter == (double)WG_BY_LEARNING) {
        rest = (double *)(made.of_part + made.count * WG_CONDITIONS);
    }

    for (int64_t k = 0; k < made.count; k++) {
        int64_t kind = (int64_t)stored[k].kind;
        assert(kind < wg_behaviour_count() && (kind >= 0 || others != NULL));
        const WgBehaviour *does = kind >= 0 ? BEHAVIOURS[kind] : &others[-1 - kind];
        made.parts[k] = (WgPart){
            does, stored[k].priority, stored[k].duration, stored[k].interruptible, stored[k].options, rest,
        };
        rest += does->state_size;
    }
    return made;
}

// Returns the direction of vote number k from the heading, rad: 0, then alternately to the left and
// to the right, so that the smallest turn wins a tie.
static double voted_direction(int64_t k)
{
    double away = wg_bearing_of((k + 1) / 2, WG_VOTE_DIRECTIONS);
    return wg_wrap(k % 2 == 0 ? -away : away);
}

// Returns the share of its weight that a part gives to a direction, if it is to turn by a given
// angle.
static double vote_for(double direction, double turn)
{
    return wg_higher(0.0, 1.0 - fabs(wg_wrap(direction - turn)) / SPREAD);
}

// Lets every part that applies act on its own command. Returns the number of them;
// `who` receives their indices.
static int64_t let_all_act(Composed *made, const WgObservation *seen, WgCommand *commands, int64_t *who)
{
    WgShared *shared = &made->own->shared;
    int64_t count = 0;
    for (int64_t k = 0; k < made->count; k++) {
        const WgPart *part = &made->parts[k];
        WgCommand *command = &commands[count];
        *command = (WgCommand){0};
        bool acts = made->left[k] > 0.0;
        bool begins = false;
        if (!acts || part->does->restarts != 0) {
            WgSituation now = wg_situation(part, shared, seen, command);
            begins = part->does->trigger(&now) != 0;
        }
        if (!acts && !begins) {
            continue;
        }
        shared->behaviour = (double)k;
        shared->counter = made->left[k];
        int64_t done = wg_act_part(part, begins, shared, seen, command);

        // A behaviour that keeps time itself may count below 0 before it is done.
        made->left[k] = done != 0 ? 0.0 : wg_higher(shared->counter, 1.0);
        who[count] = k;
        count += 1;
    }
    shared->counter = 0.0;
    shared->behaviour = WG_NO_BEHAVIOUR;
    return count;
}

// Lets all parts that apply vote for directions, with their priorities as weights; returns the part
// that gave the winner the most votes, or -1.
static int64_t vote(Composed *made, const WgObservation *seen, WgCommand *command)
{
    WgCommand commands[WG_MOST_PARTS];
    int64_t who[WG_MOST_PARTS];
    wg_watch(made->parts, made->count, &made->own->shared, seen, command);
    int64_t voters = let_all_act(made, seen, commands, who);
    if (voters == 0) {
        return -1;
    }

    // Find the direction with the most votes.
    double best = 0.0;
    double most = -INFINITY;
    for (int64_t d = 0; d < WG_VOTE_DIRECTIONS; d++) {
        double direction = voted_direction(d);
        double votes = 0.0;
        for (int64_t k = 0; k < voters; k++) {
            double turn = wg_wrap(commands[k].turn_rate * seen->time_step);
            votes += made->parts[who[k]].priority * vote_for(direction, turn);
        }
        if (votes > most) {
            most = votes;
            best = direction;
        }
    }

    // Its speed is the mean over the parts that voted for it; a part that wants nearly that
    // direction contributes its own speed.
    double weights = 0.0;
    double speed = 0.0;
    double heaviest = -INFINITY;
    int64_t winner = who[0];
    double turn = best;
    for (int64_t k = 0; k < voters; k++) {
        double own_turn = wg_wrap(commands[k].turn_rate * seen->time_step);
        double weight = made->parts[who[k]].priority * vote_for(best, own_turn);
        weights += weight;
        speed += weight * commands[k].speed;
        if (weight > heaviest) {
            heaviest = weight;
            winner = who[k];
            bool near = fabs(wg_wrap(best - own_turn)) <= WG_PI / (double)WG_VOTE_DIRECTIONS;
            turn = near ? own_turn : best;
        }
        if (commands[k].used_random != 0.0) {
            command->used_random = 1.0;
        }
    }
    wg_steer(seen, command, turn, weights > 0.0 ? speed / weights : 0.0);
    return winner;
}

// Returns how strongly being active correlates with a feedback, -1 to 1:
// the correlation of two Boolean series.
//
// with:  share of steps with the feedback; acted_with: share of steps in which the part also acted.
static double correlation(double with, double acted, double acted_with)
{
    double idle_with = wg_higher(0.0, with - acted_with);
    double active_without = wg_higher(0.0, acted - acted_with);
    double idle_without = wg_higher(0.0, (double)WG_WHOLE_SHARE - acted - idle_with);
    double scale = (idle_without + active_without) * (idle_without + idle_with) * (acted_with + idle_with)
                   * (acted_with + active_without);
    if (scale <= 0.0) {
        return 0.0;
    }
    return (acted_with * idle_without - active_without * idle_with) / sqrt(scale);
}

// Returns the value of a part in a condition: its benefit minus its harm.
static double relevance(const Composed *made, int64_t part, int64_t condition)
{
    const WgFeedback *all = &made->all[condition];
    const WgFeedback *own = &made->of_part[part * WG_CONDITIONS + condition];
    if (own->trials < TRIALS) {
        return UNTRIED;
    }
    return correlation(all->good, own->acted, own->good) - correlation(all->bad, own->acted, own->bad);
}

// Moves a share towards the result of one step. Integers settle, so that a state can recur.
static double averaged(double share, bool seen)
{
    int64_t wanted = seen ? WG_WHOLE_SHARE : 0;
    return share + (double)wg_floor_div(wanted - (int64_t)share, RECENT);
}

static void average(WgFeedback *shares, bool acted, bool good, bool bad)
{
    shares->trials = wg_lower(shares->trials + (acted ? 1.0 : 0.0), TRIALS);
    shares->acted = averaged(shares->acted, acted);
    shares->good = averaged(shares->good, acted && good);
    shares->bad = averaged(shares->bad, acted && bad);
}

// Learns from the last step: did the signal become stronger, was a wall touched?
static void take_feedback(Composed *made, const WgObservation *seen)
{
    WgLearning *learning = made->learning;
    int64_t part = (int64_t)made->own->acted;
    bool bad = seen->bump != 0.0;
    bool good = seen->signal > learning->signal && !bad;
    learning->lately = bad ? LATELY : wg_higher(0.0, learning->lately - 1.0);
    learning->signal = seen->signal;
    if (part < 0) {
        return;
    }
    int64_t condition = (int64_t)learning->condition;
    average(&made->all[condition], true, good, bad);
    for (int64_t k = 0; k < made->count; k++) {
        average(&made->of_part[k * WG_CONDITIONS + condition], k == part, good, bad);
    }
}

// Lets the part act that has proved most useful in the current condition. It keeps control until it
// is done, so that it gets the credit for the outcome.
static int64_t act_as_learned(Composed *made, const WgObservation *seen, WgCommand *command)
{
    take_feedback(made, seen);
    if (made->own->shared.behaviour < 0.0) {
        int64_t condition = (seen->bump != 0.0 ? 1 : 0) + (made->learning->lately > 0.0 ? 2 : 0);
        made->learning->condition = (double)condition;
        for (int64_t k = 0; k < made->count; k++) {
            made->parts[k].priority = relevance(made, k, condition);
        }
    }
    for (int64_t k = 0; k < made->count; k++) {
        made->parts[k].interruptible = 0.0;
    }
    return wg_arbitrate(made->parts, made->count, &made->own->shared, seen, command);
}

void wg_compose(const WgBehaviour *others, const WgObservation *seen, double *memory, WgCommand *command)
{
    Composed made = composed_of(memory, others);
    int64_t acted = -1;
    if (made.own->arbiter == (double)WG_BY_VOTE) {
        acted = vote(&made, seen, command);
    } else if (made.own->arbiter == (double)WG_BY_LEARNING) {
        acted = act_as_learned(&made, seen, command);
    } else {
        acted = wg_arbitrate(made.parts, made.count, &made.own->shared, seen, command);
    }
    made.own->acted = (double)acted;
}

void wg_composition_act(const WgObservation *seen, double *memory, WgCommand *command)
{
    wg_compose(NULL, seen, memory, command);
}
