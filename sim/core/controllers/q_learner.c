// A Q-learning robot that keeps learning while it drives: each result changes the value of the turn
// that led to it. All values are integers, so a run that repeats itself repeats its table too,
// and a loop can be proved.
//
// Sources: Christopher J. C. H. Watkins, "Learning from delayed rewards", PhD thesis, King's
// College, Cambridge (1989); Christopher J. C. H. Watkins and Peter Dayan, "Q-learning", Machine
// Learning 8 (1992), equation 1. For rewarding a smaller distance as a potential: Andrew Y. Ng,
// Daishi Harada and Stuart Russell, "Policy invariance under reward transformations" (1999).

#include <stddef.h>

#include "directions.h"
#include "library.h"

// Values and rewards are in thousandths.
enum {
    BEAMS = 8,
    DECISION = -200,     // reward of any decision, so that a shorter path is better
    BUMP = -1000,        // reward of touching a wall
    PER_MM = 5,          // reward for coming a millimetre nearer
    DISCOUNT = 98,       // hundredths of the value of the next situation
    LEARNT = 4,          // a value moves by its error divided by this
    OFFSET = 32768,      // offset of a stored value
    IN_A_NUMBER = 3,     // values packed into each number of the memory
    BITS = 16,           // bits of a value
};

static int64_t shift_of(int64_t turn)
{
    return BITS * (turn % IN_A_NUMBER);
}

static double *number_of(WgQLearnerMemory *own, int64_t situation, int64_t turn)
{
    return &own->values[2 * situation + turn / IN_A_NUMBER];
}

static int64_t value_of(WgQLearnerMemory *own, int64_t situation, int64_t turn)
{
    int64_t packed = (int64_t)*number_of(own, situation, turn);
    return ((packed >> shift_of(turn)) & 0xFFFF) - OFFSET;
}

static void set_value(WgQLearnerMemory *own, int64_t situation, int64_t turn, int64_t value)
{
    int64_t kept = wg_least(wg_most(value, -OFFSET), OFFSET - 1) + OFFSET;
    double *number = number_of(own, situation, turn);
    int64_t others = (int64_t)*number & ~(INT64_C(0xFFFF) << shift_of(turn));
    *number = (double)(others | (kept << shift_of(turn)));
}

// Returns the best turn in a situation; the first wins a tie.
static int64_t best_turn(WgQLearnerMemory *own, int64_t situation)
{
    int64_t best = 0;
    for (int64_t turn = 1; turn < WG_Q_TURNS; turn++) {
        if (value_of(own, situation, turn) > value_of(own, situation, best)) {
            best = turn;
        }
    }
    return best;
}

// Moves the value of the last decision towards its actual result.
static void learn(WgQLearnerMemory *own, int64_t worth)
{
    int64_t situation = (int64_t)own->situation;
    int64_t turn = (int64_t)own->choice;
    int64_t value = value_of(own, situation, turn);
    set_value(own, situation, turn, value + wg_floor_div(worth - value, LEARNT));
}

void wg_q_learner_arrives(double *memory, double reward)
{
    WgQLearnerMemory *own = (WgQLearnerMemory *)memory;
    if (own->situation >= 0.0) {
        learn(own, (int64_t)reward);
    }
}

// Returns the turn to take: the best, or sometimes another during training.
static int64_t choose(const WgObservation *seen, WgQLearnerMemory *own, WgCommand *command, int64_t situation)
{
    if (own->explore <= 0.0) {
        return best_turn(own, situation);
    }
    command->used_random = 1.0;
    double drawn = seen->random * 1000.0;
    if (drawn >= own->explore) {
        return best_turn(own, situation);
    }
    return wg_least(wg_floor(drawn / own->explore * (double)WG_Q_TURNS), WG_Q_TURNS - 1);
}

void wg_q_learner_act(const WgObservation *seen, double *memory, WgCommand *command)
{
    WgQLearnerMemory *own = (WgQLearnerMemory *)memory;
    int turn = 0;
    if (own->state.wait <= 0.0 || seen->bump != 0.0) {
        if (seen->beam_count < BEAMS) {
            command->error = "IndexError: the robot has fewer than 8 range beams";
            return;
        }

        // Learn from the previous decision.
        int64_t situation = wg_q_situation(seen, &own->state);
        int64_t far = wg_floor(seen->target_distance * 1000.0 + 0.5);
        if (own->situation >= 0.0) {
            int64_t nearer = (int64_t)own->far - far;
            int64_t reward = DECISION + PER_MM * nearer + (seen->bump != 0.0 ? BUMP : 0);
            int64_t next = value_of(own, situation, best_turn(own, situation));
            learn(own, reward + wg_floor_div(DISCOUNT * next, 100));
        }

        // Make the next decision.
        int64_t choice = choose(seen, own, command, situation);
        own->situation = (double)situation;
        own->choice = (double)choice;
        own->far = (double)far;
        turn = wg_q_turn_of[choice];
        own->state.wait = WG_Q_DRIVEN;
        own->state.turned = 0.0;
        if (turn % 4 != 0) {
            own->state.turned = turn < 4 ? 1.0 : 2.0;
        }
    }
    own->state.wait -= 1.0;
    wg_steer(seen, command, (turn <= 4 ? turn : turn - 8) * (WG_WHOLE_TURN / 8.0), seen->top_speed);
}

// The shipped table, packed as a learner starts with it.
void wg_q_learner_reset(double *memory)
{
    WgQLearnerMemory *own = (WgQLearnerMemory *)memory;
    own->situation = -1.0;
    for (int64_t situation = 0; situation < WG_Q_SITUATIONS; situation++) {
        for (int64_t turn = 0; turn < WG_Q_TURNS; turn++) {
            set_value(own, situation, turn, wg_q_value(situation, turn));
        }
    }
}
